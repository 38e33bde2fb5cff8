# Without transcripts nothing is aligned: the table then tells speech from pauses.
rule align_speech:
    input:
        # Nothing heavy starts before every recording is checked; the check's time stamp is no reason to align again.
        checked=ancient("<corpus>/check/findings.tsv"),
        utterances="<corpus>/corpus/utterances/{shard}.tsv",
        audio="<corpus>/audio/{shard}.h5",
    output:
        table="<corpus>/alignment/{shard}.tsv",
        findings="<corpus>/alignment/{shard}.findings.tsv",
    log:
        "<corpus>/logs/align_speech/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/align_speech/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(5, least=15),
        disk_mb=disk(200, 2),
    params:
        settings=alignment_of,
        text=has_text,
        sources=carried(alignment_sources),
        sources_digest=marked(alignment_state),
        code=code("align_speech.py"),
    script:
        "../scripts/align_speech.py"


rule export_alignment:
    input:
        tables=shards("<corpus>/alignment/{shard}.tsv"),
        audio=shards("<corpus>/audio/{shard}.h5"),
    output:
        textgrid=directory("<corpus>/alignment/textgrid"),
        htk=directory("<corpus>/alignment/htk"),
        hts=directory("<corpus>/alignment/hts"),
    log:
        "<corpus>/logs/export_alignment.log",
    benchmark:
        "<corpus>/benchmarks/export_alignment.tsv"
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(200, 2),
    params:
        code=code("export_alignment.py"),
    script:
        "../scripts/export_alignment.py"


rule list_phones:
    input:
        split="<corpus>/corpus/split.tsv",
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
    output:
        "<corpus>/phones.tsv",
    log:
        "<corpus>/logs/list_phones.log",
    localrule: True
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        code=code("list_phones.py"),
    script:
        "../scripts/list_phones.py"
