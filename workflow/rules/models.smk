rule train_network:
    input:
        utterances=f"{RUN}/utterances.tsv",
        phones=f"{RUN}/phones.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
        parts=parts_of,
    output:
        network=f"{RUN}/models/{{model}}/network.safetensors",
        curve=f"{RUN}/models/{{model}}/learning_curve.tsv",
    log:
        f"{RUN}/logs/train_network/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/train_network/{{model}}.tsv"
    wildcard_constraints:
        model="|".join(MODELS),
    conda:
        "../envs/visualspeech.yaml"
    params:
        # Not an output: it must outlive a killed job, whose outputs are removed before it runs again.
        checkpoint=f"{RUN}/models/{{model}}/checkpoint.safetensors",
        settings=SETTINGS["training"],
        b_nodes=SETTINGS["networks"].get("b_nodes", "direction"),
        seed=lambda wildcards: network_seed(wildcards.model),
        parts=lambda wildcards: LABEL_PARTS if parse_name(wildcards.model).rich else [],
        code=code("train_network.py"),
    script:
        "../scripts/train_network.py"


rule predict_network:
    input:
        utterances=f"{RUN}/utterances.tsv",
        network=f"{RUN}/models/{{model}}/network.safetensors",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
        parts=parts_of,
    output:
        f"{RUN}/models/{{model}}/predictions.h5",
    log:
        f"{RUN}/logs/predict_network/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/predict_network/{{model}}.tsv"
    wildcard_constraints:
        model="|".join(MODELS),
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("predict_network.py"),
    script:
        "../scripts/predict_network.py"


rule predict_baseline:
    input:
        utterances=f"{RUN}/utterances.tsv",
        phones=f"{RUN}/phones.tsv",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
    output:
        f"{RUN}/models/{{model}}/predictions.h5",
    log:
        f"{RUN}/logs/predict_baseline/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/predict_baseline/{{model}}.tsv"
    wildcard_constraints:
        model="training_mean|phone_state_mean|triphone_state_mean",
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["baselines"],
        code=code("predict_baseline.py"),
    script:
        "../scripts/predict_baseline.py"


rule reconstruct_appearance:
    input:
        utterances=f"{RUN}/utterances.tsv",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
    output:
        f"{RUN}/models/aam_reconstruction/predictions.h5",
    log:
        f"{RUN}/logs/reconstruct_appearance.log",
    benchmark:
        f"{RUN}/benchmarks/reconstruct_appearance.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("reconstruct_appearance.py"),
    script:
        "../scripts/reconstruct_appearance.py"
