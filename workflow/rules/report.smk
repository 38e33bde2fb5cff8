# One page per corpus, of all systems that run on it.
rule write_report:
    input:
        utterances="<corpus>/utterances.tsv",
        findings="<corpus>/findings.tsv",
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        faces=recorded_faces,
        tables=["<corpus>/tables/systems.html"],
        files=reported_files,
        benchmarks=benchmarks_of,
    output:
        "<corpus>/report.html",
    log:
        "<corpus>/logs/write_report.log",
    threads: 1
    resources:
        mem_mb=memory(200),
        runtime=minutes(1),
        disk_mb=disk(100),
    params:
        corpus=lambda wildcards: wildcards.corpus,
        consent=lambda wildcards: PLAN.corpora[wildcards.corpus].consent,
        systems=carried(reported),
        systems_digest=marked(reported),
        settings=carried(reported_settings),
        settings_digest=marked(reported_settings),
        code=code("write_report.py"),
    script:
        "../scripts/write_report.py"
