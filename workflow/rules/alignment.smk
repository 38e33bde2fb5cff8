rule align_speech:
    input:
        # Nothing heavy starts before every recording is checked; the check's time stamp is no reason to align again.
        checked=ancient(f"{CORPUS}/check/findings.tsv"),
        utterances=f"{CORPUS}/corpus/utterances/{{shard}}.tsv",
        audio=f"{CORPUS}/audio/{{shard}}.h5",
    output:
        table=f"{CORPUS}/alignment/{{shard}}.tsv",
        findings=f"{CORPUS}/alignment/{{shard}}.findings.tsv",
    log:
        f"{CORPUS}/logs/align_speech/{{shard}}.log",
    benchmark:
        f"{CORPUS}/benchmarks/align_speech/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["alignment"],
        code=code("align_speech.py"),
    script:
        "../scripts/align_speech.py"


rule export_alignment:
    input:
        tables=shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        audio=shards(f"{CORPUS}/audio/{{shard}}.h5"),
    output:
        textgrid=directory(f"{CORPUS}/alignment/textgrid"),
        htk=directory(f"{CORPUS}/alignment/htk"),
        hts=directory(f"{CORPUS}/alignment/hts"),
    log:
        f"{CORPUS}/logs/export_alignment.log",
    benchmark:
        f"{CORPUS}/benchmarks/export_alignment.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("export_alignment.py"),
    script:
        "../scripts/export_alignment.py"
