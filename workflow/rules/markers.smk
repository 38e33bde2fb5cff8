# The visual coding of markers: of the landmarks of videos, or of motion capture.
rule fit_markers:
    input:
        utterances="<corpus>/utterances.tsv",
        faces=recorded_points,
    output:
        "<markers>/model.safetensors",
    log:
        "<coding>/logs/fit_markers.log",
    benchmark:
        "<coding>/benchmarks/fit_markers.tsv"
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        given=recorded_markers,
        settings=lambda wildcards: coding_of(wildcards)["markers"],
        code=code("fit_markers.py"),
    script:
        "../scripts/fit_markers.py"


rule encode_markers:
    input:
        utterances="<corpus>/utterances.tsv",
        coding="<coding>/model.safetensors",
        faces=recorded_points,
    output:
        "<markers>/parameters/{shard}.h5",
    log:
        "<coding>/logs/encode_markers/{shard}.log",
    benchmark:
        "<coding>/benchmarks/encode_markers/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(200, 2),
    params:
        given=recorded_markers,
        code=code("encode_markers.py"),
    script:
        "../scripts/encode_markers.py"


rule build_marker_targets:
    input:
        parameters=lambda wildcards: filled(
            "<coding>/parameters/{shard}.h5", wildcards, coding=system_of(wildcards)["coding"]
        )[0],
    output:
        "<marker_system>/targets/{shard}.h5",
    log:
        "<system>/logs/build_marker_targets/{shard}.log",
    benchmark:
        "<system>/benchmarks/build_marker_targets/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(60),
        runtime=minutes(1),
        disk_mb=disk(200, 5),
    params:
        rate=lambda wildcards: system_of(wildcards)["rate"],
        code=code("build_marker_targets.py"),
    script:
        "../scripts/build_marker_targets.py"


rule measure_regions:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        predictions="<system>/models/{model}/predictions.h5",
        targets=shards("<system>/targets/{shard}.h5"),
        parameters=of_coding_shards("parameters/{shard}.h5"),
    output:
        test="<marker_system>/models/{model}/statistics.tsv",
        validation="<marker_system>/models/{model}/validation.tsv",
        camera="<marker_system>/models/{model}/camera.tsv",
    log:
        "<system>/logs/measure_regions/{model}.log",
    benchmark:
        "<system>/benchmarks/measure_regions/{model}.tsv"
    threads: 1
    resources:
        mem_mb=memory(110),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        own=own_metrics_of,
        code=code("measure_regions.py"),
    script:
        "../scripts/measure_regions.py"
