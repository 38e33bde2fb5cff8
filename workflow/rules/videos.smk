rule render_videos:
    input:
        utterances=of_coding("utterances.tsv"),
        aam=of_coding("model.safetensors"),
        reference=of_coding("reference.safetensors"),
        head=of_head,
        predictions=shown_model("predictions.h5"),
        landmarks=shards("<corpus>/landmarks/{shard}.h5"),
        pose=shards("<corpus>/pose/{shard}.h5"),
        parameters=of_coding_shards("parameters/{shard}.h5"),
        textures=faces,
    output:
        report(
            directory("<aam_system>/videos"),
            patterns=["{utterance}.mp4"],
            category="{corpus}",
            subcategory="Videos",
            labels={"system": "{system}", "utterance": "{utterance}"},
            caption="../report/video.rst",
        ),
    log:
        "<system>/logs/render_videos.log",
    benchmark:
        "<system>/benchmarks/render_videos.tsv"
    priority: 20
    threads: 1
    resources:
        mem_mb=memory(300),
        runtime=minutes(1, least=30),
        disk_mb=disk(1000),
    params:
        clips=lambda wildcards: system_of(wildcards)["videos"]["count"],
        label=lambda wildcards: system_of(wildcards)["videos"]["label"],
        names=lambda wildcards: {**names_of(wildcards), "model": system_of(wildcards)["videos"]["model"]},
        code=code("render_videos.py"),
    script:
        "../scripts/render_videos.py"
