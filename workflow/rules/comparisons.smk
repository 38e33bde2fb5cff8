# Tables 1 and 3 of the paper, and which differences are real.
FACTS = {"corpus": PLAN.name, "experiment": SETTINGS["experiment"], "drift": SETTINGS["drift"]["method"]}


rule tabulate_topologies:
    input:
        utterances=f"{RUN}/utterances.tsv",
        metrics=expand(f"{RUN}/models/{{model}}/metrics.tsv", model=[*MODELS, "training_mean"]),
    output:
        multiext(f"{RUN}/tables/topologies", ".tsv", ".md", ".tex", ".html"),
    log:
        f"{RUN}/logs/tabulate_topologies.log",
    benchmark:
        f"{RUN}/benchmarks/tabulate_topologies.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings={key: SETTINGS["tables"][key] for key in ("digits", "ratio_digits") if key in SETTINGS["tables"]},
        b_nodes=SETTINGS["networks"].get("b_nodes", "direction"),
        facts=FACTS,
        code=code("tabulate_topologies.py"),
    script:
        "../scripts/tabulate_topologies.py"


rule compare_models:
    input:
        utterances=f"{RUN}/utterances.tsv",
        metrics=expand(f"{RUN}/models/{{model}}/metrics.tsv", model=PREDICTORS),
    output:
        multiext(f"{RUN}/tables/comparisons", ".tsv", ".md", ".tex", ".html"),
    log:
        f"{RUN}/logs/compare_models.log",
    benchmark:
        f"{RUN}/benchmarks/compare_models.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        metrics=SETTINGS["tables"]["metrics"],
        comparison=SETTINGS["tables"].get("comparison", {}),
        bootstrap=SETTINGS["tables"]["bootstrap"],
        facts=FACTS,
        seed=SEED,
        code=code("compare_models.py"),
    script:
        "../scripts/compare_models.py"


rule compare_systems:
    input:
        utterances=f"{RUN}/utterances.tsv",
        metrics=expand(f"{RUN}/models/{{model}}/metrics.tsv", model=[*MODELS, *HMM_ROWS]),
        curves=expand(f"{RUN}/models/{{model}}/learning_curve.tsv", model=MODELS),
    output:
        multiext(f"{RUN}/tables/systems", ".tsv", ".md", ".tex", ".html"),
    log:
        f"{RUN}/logs/compare_systems.log",
    benchmark:
        f"{RUN}/benchmarks/compare_systems.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        comparison=SETTINGS["tables"].get("comparison", {}),
        bootstrap=SETTINGS["tables"]["bootstrap"],
        facts=FACTS,
        seed=SEED,
        code=code("compare_systems.py"),
    script:
        "../scripts/compare_systems.py"
