# One rule trains every model and one predicts: the row of the tables says how.
rule train_model:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        targets=shards("<system>/targets/{shard}.h5"),
        blocks=lambda wildcards: filled(
            "<system>/features/{block}/block.safetensors", wildcards, block=row_of(wildcards).reads
        ),
        features=features_of,
        alignment=alignment_of_lips,
        # The models that it is made from.
        parents=lambda wildcards: filled(
            "<system>/models/{parent}/model.safetensors", wildcards, parent=row_of(wildcards).parents
        ),
    output:
        model="<system>/models/{model}/model.safetensors",
        curve="<system>/models/{model}/learning_curve.tsv",
    log:
        "<system>/logs/train_model/{model}.log",
    benchmark:
        "<system>/benchmarks/train_model/{model}.tsv"
    wildcard_constraints:
        model=TRAINED,
    priority: 10
    threads: 1
    resources:
        mem_mb=memory_of_training,
        runtime=minutes(15, least=60),
        disk_mb=disk(200, 1),
    params:
        row=lambda wildcards: row_of(wildcards).plain(),
        module=lambda wildcards: FAMILIES[row_of(wildcards).family].module,
        code=model_code("train_model.py"),
    script:
        "../scripts/train_model.py"


rule predict_model:
    input:
        utterances=of_coding("utterances.tsv"),
        model="<system>/models/{model}/model.safetensors",
        targets=shards("<system>/targets/{shard}.h5"),
        features=features_of,
    output:
        predictions="<system>/models/{model}/predictions.h5",
        speed="<system>/models/{model}/speed.tsv",
    log:
        "<system>/logs/predict_model/{model}.log",
    benchmark:
        "<system>/benchmarks/predict_model/{model}.tsv"
    wildcard_constraints:
        model=TRAINED,
    threads: 1
    resources:
        mem_mb=memory(330),
        runtime=minutes(1),
        disk_mb=disk(200, 2),
    params:
        reads=lambda wildcards: len(row_of(wildcards).reads),
        module=lambda wildcards: FAMILIES[row_of(wildcards).family].module,
        code=model_code("predict_model.py"),
    script:
        "../scripts/predict_model.py"


rule reconstruct_targets:
    input:
        utterances=of_coding("utterances.tsv"),
        targets=shards("<system>/targets/{shard}.h5"),
    output:
        "<system>/models/{model}/predictions.h5",
    log:
        "<system>/logs/reconstruct_targets/{model}.log",
    wildcard_constraints:
        model=FLOORS,
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(200, 2),
    params:
        code=code("reconstruct_targets.py"),
    script:
        "../scripts/reconstruct_targets.py"
