rule record_demo:
    input:
        "<corpus>/corpus/utterances/{shard}.tsv",
    output:
        recordings=directory("<corpus>/recordings/{shard}"),
        truth="<corpus>/truth/{shard}.h5",
    log:
        "<corpus>/logs/record_demo/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/record_demo/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(290),
        runtime=minutes(1, least=15),
        disk_mb=disk(1000),
    params:
        code=code("record_demo.py"),
    script:
        "../scripts/record_demo.py"
