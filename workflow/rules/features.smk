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
