# What viewers answered. The folders of studies are users' files: they are no inputs, and a digest stands for them.
rule evaluate_study:
    output:
        report(
            directory("<evaluation>"),
            patterns=["{page}.html"],
            category="{corpus}",
            subcategory="Viewing tests",
            labels={"system": "{evaluated}", "page": "{page}"},
            caption="../report/evaluation.rst",
        ),
    log:
        "<corpus>/logs/evaluate_study/{evaluated}.log",
    threads: 1
    resources:
        mem_mb=memory(250),
        runtime=minutes(1, least=10),
        disk_mb=disk(20),
    params:
        folder=evaluation_folder,
        simulated=SETTINGS["study_evaluation"]["simulated"],
        settings=evaluation_settings,
        answers=answers_digest,
        code=code("evaluate_study.py"),
    script:
        "../scripts/evaluate_study.py"
