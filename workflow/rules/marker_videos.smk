# The videos of a system whose visual coding are markers; those of an AAM are made by render_videos.
rule render_markers:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        predictions=shown_model("predictions.h5"),
        parameters=of_coding_shards("parameters/{shard}.h5"),
        audio=shards("<corpus>/audio/{shard}.h5"),
    output:
        report(
            directory("<marker_system>/videos"),
            patterns=["{utterance}.mp4"],
            category="{corpus}",
            subcategory="Videos",
            labels={"system": "{system}", "utterance": "{utterance}"},
            caption="../report/video.rst",
        ),
    log:
        "<system>/logs/render_markers.log",
    benchmark:
        "<system>/benchmarks/render_markers.tsv"
    priority: 20
    threads: 1
    resources:
        mem_mb=memory(200),
        runtime=minutes(1, least=30),
        disk_mb=disk(1000),
    params:
        clips=lambda wildcards: system_of(wildcards)["videos"]["count"],
        label=lambda wildcards: system_of(wildcards)["videos"]["label"],
        names=lambda wildcards: {**names_of(wildcards), "model": system_of(wildcards)["videos"]["model"]},
        code=code("render_markers.py"),
    script:
        "../scripts/render_markers.py"
