# One page per corpus, of all systems that run on it.
rule write_report:
    input:
        utterances="<corpus>/utterances.tsv",
        findings="<corpus>/findings.tsv",
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        exports=expand("<corpus>/alignment/{form}", form=["textgrid", "htk", "hts"], allow_missing=True),
        faces=recorded_faces,
        across=multiext("<corpus>/tables/systems", *FORMS),
        files=reported_files,
        evaluations=evaluations_of,
        benchmarks=benchmarks_of,
    output:
        report(
            "<corpus>/report.html",
            category="{corpus}",
            subcategory="Report",
            labels={"system": "all", "page": "report"},
            caption="../report/page.rst",
        ),
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
