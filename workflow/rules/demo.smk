if PLAN.adapter == "demo":

    rule record_demo:
        input:
            f"{CORPUS}/corpus/utterances/{{shard}}.tsv",
        output:
            recordings=directory(f"{CORPUS}/recordings/{{shard}}"),
            truth=f"{CORPUS}/truth/{{shard}}.h5",
        log:
            f"{CORPUS}/logs/record_demo/{{shard}}.log",
        benchmark:
            f"{CORPUS}/benchmarks/record_demo/{{shard}}.tsv"
        conda:
            "../envs/visualspeech.yaml"
        params:
            code=code("record_demo.py"),
        script:
            "../scripts/record_demo.py"
