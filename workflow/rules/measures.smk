# What the tables are made of: statistics of the test and validation utterances of each model, and of its lips.
rule measure_lips:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        targets=shards("<system>/targets/{shard}.h5"),
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
    output:
        "<system>/lips.tsv",
    log:
        "<system>/logs/measure_lips.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        code=code("measure_lips.py"),
    script:
        "../scripts/measure_lips.py"


rule measure_model:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        predictions="<system>/models/{model}/predictions.h5",
        targets=shards("<system>/targets/{shard}.h5"),
        parameters=of_coding_shards("parameters/{shard}.h5"),
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        lips="<system>/lips.tsv",
    output:
        test="<aam_system>/models/{model}/statistics.tsv",
        validation="<aam_system>/models/{model}/validation.tsv",
        camera="<aam_system>/models/{model}/camera.tsv",
    log:
        "<system>/logs/measure_model/{model}.log",
    benchmark:
        "<system>/benchmarks/measure_model/{model}.tsv"
    threads: 1
    resources:
        mem_mb=memory(160),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        drift=lambda wildcards: drift_of(coding_of(wildcards)),
        own=own_metrics_of,
        code=code("measure_model.py"),
    script:
        "../scripts/measure_model.py"


rule measure_tracked_lips:
    input:
        utterances="<corpus>/utterances.tsv",
        heads=heads_of,
        faces=recorded_points,
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
    output:
        speakers="<corpus>/tracked_lips.tsv",
        mouth="<corpus>/mouth.tsv",
    log:
        "<corpus>/logs/measure_tracked_lips.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        speakers=speakers_with_heads,
        names=recorded_names,
        code=code("measure_tracked_lips.py"),
    script:
        "../scripts/measure_tracked_lips.py"


rule measure_across:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        speakers="<corpus>/tracked_lips.tsv",
        mouth="<corpus>/mouth.tsv",
        faces=recorded_points,
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        predictions=predictions_of_rows(ROLES),
        models=statistics_of(PREDICTING, file="model.safetensors"),
        speed=statistics_of(PREDICTING, file="speed.tsv"),
    output:
        lips="<system>/lips_camera.tsv",
        costs="<system>/costs.tsv",
    log:
        "<system>/logs/measure_across.log",
    benchmark:
        "<system>/benchmarks/measure_across.tsv"
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        names=recorded_names,
        rows=lambda wildcards: [row.name for row in rows_of(wildcards.system)],
        models=lambda wildcards: [row.name for row in rows_of(wildcards.system, PREDICTING)],
        code=code("measure_across.py"),
    script:
        "../scripts/measure_across.py"
