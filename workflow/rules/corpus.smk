rule check_recordings:
    input:
        utterances=f"{CORPUS}/corpus/utterances/{{shard}}.tsv",
        recordings=recordings,
    output:
        findings=f"{CORPUS}/check/{{shard}}.tsv",
        digests=f"{CORPUS}/check/{{shard}}.digests.tsv",
        audio=f"{CORPUS}/audio/{{shard}}.h5",
    log:
        f"{CORPUS}/logs/check_recordings/{{shard}}.log",
    benchmark:
        f"{CORPUS}/benchmarks/check_recordings/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["check"],
        code=code("check_recordings.py"),
    script:
        "../scripts/check_recordings.py"


rule gather_findings:
    input:
        utterances=shards(f"{CORPUS}/corpus/utterances/{{shard}}.tsv"),
        findings=shards(f"{CORPUS}/check/{{shard}}.tsv"),
        digests=shards(f"{CORPUS}/check/{{shard}}.digests.tsv"),
    output:
        f"{CORPUS}/check/findings.tsv",
    log:
        f"{CORPUS}/logs/gather_findings.log",
    benchmark:
        f"{CORPUS}/benchmarks/gather_findings.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        limit=SETTINGS["max_rejected_share"],
        code=code("gather_findings.py"),
    script:
        "../scripts/gather_findings.py"
