rule train_hmm:
    input:
        utterances=f"{RUN}/utterances.tsv",
        phones=f"{RUN}/phones.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        alignment=shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        features=shards(f"{RUN}/features/{{shard}}.h5"),
        # Each variant is made from the one before it.
        start=lambda wildcards: [
            f"{RUN}/models/{before}/hmm.safetensors" for before, name in zip(HMMS, HMMS[1:]) if name == wildcards.model
        ],
    output:
        hmm=f"{RUN}/models/{{model}}/hmm.safetensors",
        curve=f"{RUN}/models/{{model}}/training.tsv",
    log:
        f"{RUN}/logs/train_hmm/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/train_hmm/{{model}}.tsv"
    wildcard_constraints:
        model="|".join(HMMS),
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings={key: value for key, value in SETTINGS.get("hmm", {}).items() if key != "variants"},
        seed=SEED,
        code=code("train_hmm.py"),
    script:
        "../scripts/train_hmm.py"


rule predict_hmm:
    input:
        utterances=f"{RUN}/utterances.tsv",
        hmm=f"{RUN}/models/{{model}}/hmm.safetensors",
        alignment=shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        features=shards(f"{RUN}/features/{{shard}}.h5"),
    output:
        f"{RUN}/models/{{model}}/predictions.h5",
    log:
        f"{RUN}/logs/predict_hmm/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/predict_hmm/{{model}}.tsv"
    wildcard_constraints:
        model="|".join(HMMS),
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("predict_hmm.py"),
    script:
        "../scripts/predict_hmm.py"
