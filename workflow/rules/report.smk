rule write_report:
    input:
        table=f"{RUN}/tables/objective.tsv",
        sheets=expand(f"{RUN}/tables/{{table}}.html", table=[name for name in TABLES if name != "objective"]),
        findings=f"{RUN}/findings.tsv",
        utterances=f"{RUN}/utterances.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        reference=f"{RUN}/aam/reference.safetensors",
        features=shards(f"{RUN}/features/{{shard}}.h5"),
        alignment=shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        curves=expand(f"{RUN}/models/{{model}}/learning_curve.tsv", model=MODELS),
        predictions=f"{RUN}/models/{SETTINGS['videos']['model']}/predictions.h5",
        videos=f"{RUN}/videos",
    output:
        f"{CORPUS}/report.html",
    log:
        f"{RUN}/logs/write_report.log",
    conda:
        "../envs/visualspeech.yaml"
    params:
        benchmarks=[f"{CORPUS}/benchmarks", f"{RUN}/benchmarks"],
        settings=SETTINGS,
        models=MODELS,
        code=code("write_report.py"),
    script:
        "../scripts/write_report.py"
