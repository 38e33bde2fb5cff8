# One page per corpus, of all systems that run on it.
rule write_report:
    input:
        utterances="<corpus>/utterances.tsv",
        findings="<corpus>/findings.tsv",
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        faces=recorded_faces,
        tables=["<corpus>/tables/systems.html"],
        files=reported_files,
        evaluations=evaluations_of,
        benchmarks=benchmarks_of,
    output:
        "<corpus>/report.html",
    log:
        "<corpus>/logs/write_report.log",
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
