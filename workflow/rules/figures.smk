rule draw_trajectories:
    input:
        utterances=of_coding("utterances.tsv"),
        targets=shards("<system>/targets/{shard}.h5"),
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        predictions=lambda wildcards: filled("<model>/predictions.h5", wildcards, model=compared_models(wildcards)),
    output:
        "<system>/figures/trajectories.png",
    log:
        "<system>/logs/draw_trajectories.log",
    threads: 1
    resources:
        mem_mb=memory(200),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        titles=lambda wildcards: [
            row.title for name in compared_models(wildcards) for row in rows_of(wildcards.system) if row.name == name
        ],
        parameter=lambda wildcards: system_of(wildcards)["trajectories"]["parameter"],
        utterance=lambda wildcards: system_of(wildcards)["trajectories"]["utterance"],
        code=code("draw_trajectories.py"),
    script:
        "../scripts/draw_trajectories.py"
