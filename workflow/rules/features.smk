rule list_phones:
    input:
        shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
    output:
        f"{RUN}/phones.tsv",
    log:
        f"{RUN}/logs/list_phones.log",
    benchmark:
        f"{RUN}/benchmarks/list_phones.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("list_phones.py"),
    script:
        "../scripts/list_phones.py"


rule build_features:
    input:
        phones=f"{RUN}/phones.tsv",
        alignment=f"{CORPUS}/alignment/{{shard}}.tsv",
        parameters=f"{RUN}/aam/parameters/{{shard}}.h5",
    output:
        f"{RUN}/features/{{shard}}.h5",
    log:
        f"{RUN}/logs/build_features/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/build_features/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["features"],
        code=code("build_features.py"),
    script:
        "../scripts/build_features.py"


# Apart from the features, so that plain networks do not care.
rule enrich_labels:
    input:
        alignment=f"{CORPUS}/alignment/{{shard}}.tsv",
        features=f"{RUN}/features/{{shard}}.h5",
    output:
        f"{RUN}/label_parts/{{shard}}.h5",
    log:
        f"{RUN}/logs/enrich_labels/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/enrich_labels/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        parts=LABEL_PARTS,
        code=code("enrich_labels.py"),
    script:
        "../scripts/enrich_labels.py"
