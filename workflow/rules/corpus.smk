rule list_utterances:
    output:
        "<corpus>/corpus/utterances/{shard}.tsv",
    log:
        "<corpus>/logs/list_utterances/{shard}.log",
    threads: 1
    resources:
        mem_mb=memory(60),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(utterances_of),
        rows_digest=marked(utterances_of),
        code=code("list_utterances.py"),
    script:
        "../scripts/list_utterances.py"


rule write_split:
    output:
        "<corpus>/corpus/split.tsv",
    log:
        "<corpus>/logs/write_split.log",
    localrule: True
    threads: 1
    resources:
        mem_mb=memory(60),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        split=carried(split_of),
        split_digest=marked(split_of),
        code=code("write_split.py"),
    script:
        "../scripts/write_split.py"


rule check_recordings:
    input:
        utterances="<corpus>/corpus/utterances/{shard}.tsv",
        recordings=recordings,
    output:
        findings="<corpus>/check/{shard}.tsv",
        digests="<corpus>/check/{shard}.digests.tsv",
        audio="<corpus>/audio/{shard}.h5",
    log:
        "<corpus>/logs/check_recordings/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/check_recordings/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes_of_recordings(2),
        disk_mb=disk(1000),
    params:
        settings=SETTINGS["check"],
        text=is_written,
        dictionary=carried(dictionary_of),
        dictionary_digest=marked(dictionary_state),
        recordings=recordings_digest,
        code=code("check_recordings.py"),
    script:
        "../scripts/check_recordings.py"


rule gather_findings:
    input:
        utterances=shards("<corpus>/corpus/utterances/{shard}.tsv"),
        findings=shards("<corpus>/check/{shard}.tsv"),
        digests=shards("<corpus>/check/{shard}.digests.tsv"),
    output:
        "<corpus>/check/findings.tsv",
    log:
        "<corpus>/logs/gather_findings.log",
    localrule: True
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        limit=SETTINGS["max_rejected_share"],
        code=code("gather_findings.py"),
    script:
        "../scripts/gather_findings.py"
