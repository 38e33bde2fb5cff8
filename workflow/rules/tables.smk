rule measure_model:
    input:
        aam=f"{RUN}/aam/model.safetensors",
        predictions=f"{RUN}/models/{{model}}/predictions.h5",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
    output:
        f"{RUN}/models/{{model}}/metrics.tsv",
    log:
        f"{RUN}/logs/measure_model/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/measure_model/{{model}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("measure_model.py"),
    script:
        "../scripts/measure_model.py"


rule tabulate_results:
    input:
        utterances=f"{RUN}/utterances.tsv",
        metrics=expand(f"{RUN}/models/{{model}}/metrics.tsv", model=MODELS + HMM_ROWS + BASELINES),
    output:
        tsv=f"{RUN}/tables/objective.tsv",
        markdown=f"{RUN}/tables/objective.md",
        latex=f"{RUN}/tables/objective.tex",
        html=f"{RUN}/tables/objective.html",
    log:
        f"{RUN}/logs/tabulate_results.log",
    benchmark:
        f"{RUN}/benchmarks/tabulate_results.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["tables"],
        facts={"corpus": PLAN.name, "experiment": SETTINGS["experiment"], "drift": SETTINGS["drift"]["method"]},
        seed=SEED,
        code=code("tabulate_results.py"),
    script:
        "../scripts/tabulate_results.py"
