# The result tables of each system, and of all systems of a corpus.
rule tabulate_results:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(),
    output:
        table_files("<system>/tables/objective", "objective"),
    log:
        "<system>/logs/tabulate_results.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows()),
        rows_digest=marked(plain_rows()),
        facts=facts_of,
        settings=table_settings,
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        latex=lambda wildcards: system_of(wildcards)["tables"]["latex"],
        own=own_metrics_of,
        code=code("tabulate_results.py"),
    script:
        "../scripts/tabulate_results.py"


rule tabulate_articulation:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        lips="<system>/lips.tsv",
        statistics=statistics_of(),
    output:
        table_files("<system>/tables/articulation", "articulation"),
    log:
        "<system>/logs/tabulate_articulation.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows()),
        rows_digest=marked(plain_rows()),
        facts=facts_of,
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        code=code("tabulate_articulation.py"),
    script:
        "../scripts/tabulate_articulation.py"


rule tabulate_resting:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        targets=shards("<system>/targets/{shard}.h5"),
        predictions=predictions_of_rows(("model",)),
    output:
        table_files("<system>/tables/resting", "resting"),
    log:
        "<system>/logs/tabulate_resting.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(("model",))),
        rows_digest=marked(plain_rows(("model",))),
        facts=facts_of,
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        code=code("tabulate_resting.py"),
    script:
        "../scripts/tabulate_resting.py"


rule tabulate_topologies:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_topologies),
    output:
        table_files("<system>/tables/topologies", "topologies"),
    log:
        "<system>/logs/tabulate_topologies.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(names=of_topologies)),
        rows_digest=marked(plain_rows(names=of_topologies)),
        facts=facts_of,
        settings=table_settings,
        published=lambda wildcards: system_of(wildcards)["published"],
        own=own_metrics_of,
        code=code("tabulate_topologies.py"),
    script:
        "../scripts/tabulate_topologies.py"


rule compare_models:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(("model", "baseline")),
    output:
        table_files("<system>/tables/comparisons", "comparisons"),
    log:
        "<system>/logs/compare_models.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(("model", "baseline"))),
        rows_digest=marked(plain_rows(("model", "baseline"))),
        facts=facts_of,
        settings=table_settings,
        comparison=lambda wildcards: system_of(wildcards)["tables"]["comparison"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        latex=lambda wildcards: system_of(wildcards)["tables"]["latex"],
        own=own_metrics_of,
        code=code("compare_models.py"),
    script:
        "../scripts/compare_models.py"


rule tabulate_gains:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_gains),
        validation=of_rows("validation.tsv", lambda system: system["tables"]["gains"]["candidates"]),
    output:
        table_files("<system>/tables/gains", "gains"),
    log:
        "<system>/logs/tabulate_gains.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(names=of_gains)),
        rows_digest=marked(plain_rows(names=of_gains)),
        candidates=lambda wildcards: system_of(wildcards)["tables"]["gains"]["candidates"],
        references=lambda wildcards: system_of(wildcards)["tables"]["gains"]["references"],
        facts=facts_of,
        settings=table_settings,
        published=lambda wildcards: system_of(wildcards)["published"],
        comparison=lambda wildcards: system_of(wildcards)["tables"]["comparison"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        own=own_metrics_of,
        code=code("tabulate_gains.py"),
    script:
        "../scripts/tabulate_gains.py"


rule tabulate_ablation:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_ablation),
    output:
        table_files("<system>/tables/ablation", "ablation"),
    log:
        "<system>/logs/tabulate_ablation.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(names=of_ablation)),
        rows_digest=marked(plain_rows(names=of_ablation)),
        ablation=lambda wildcards: system_of(wildcards)["tables"]["ablation"],
        facts=facts_of,
        settings=table_settings,
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        own=own_metrics_of,
        code=code("tabulate_ablation.py"),
    script:
        "../scripts/tabulate_ablation.py"


rule tabulate_selection:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of_selection,
    output:
        table_files("<system>/tables/{selection}", "{selection}"),
    log:
        "<system>/logs/tabulate_selection/{selection}.log",
    wildcard_constraints:
        selection=SELECTIONS,
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(selected_rows),
        rows_digest=marked(selected_rows),
        facts=facts_of,
        selection=lambda wildcards: wildcards.selection,
        settings=lambda wildcards: system_of(wildcards)["tables"]["selections"][wildcards.selection],
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        published=lambda wildcards: system_of(wildcards)["published"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        latex=lambda wildcards: system_of(wildcards)["tables"]["latex"],
        own=own_metrics_of,
        code=code("tabulate_selection.py"),
    script:
        "../scripts/tabulate_selection.py"


rule tabulate_regions:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=of_rows("statistics.tsv", of_regions),
        models=of_trained("model.safetensors"),
        curves=of_trained("learning_curve.tsv"),
    output:
        table_files("<system>/tables/regions", "regions"),
    log:
        "<system>/logs/tabulate_regions.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(ordered_rows(of_regions)),
        rows_digest=marked(ordered_rows(of_regions)),
        trained=trained_of_regions,
        facts=facts_of,
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        published=lambda wildcards: system_of(wildcards)["published"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        needs=needs_of_blocks,
        code=code("tabulate_regions.py"),
    script:
        "../scripts/tabulate_regions.py"


rule tabulate_emotions:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=of_rows("statistics.tsv", of_emotions),
    output:
        tables=table_files("<system>/tables/emotions", "emotions"),
        figure="<system>/figures/emotions.png",
    log:
        "<system>/logs/tabulate_emotions.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(ordered_rows(of_emotions)),
        rows_digest=marked(ordered_rows(of_emotions)),
        facts=facts_of,
        settings=lambda wildcards: system_of(wildcards)["tables"]["emotions"],
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        published=lambda wildcards: system_of(wildcards)["published"],
        bootstrap=lambda wildcards: system_of(wildcards)["tables"]["bootstrap"],
        seed=SEED,
        needs=needs_of_blocks,
        code=code("tabulate_emotions.py"),
    script:
        "../scripts/tabulate_emotions.py"


# Across systems: what is measured of a speaker, and of the lips that the rows of a system predict.
rule tabulate_systems:
    input:
        utterances=of_systems(lambda wildcards: [of_coding("utterances.tsv")(wildcards)]),
        codings=of_systems(lambda wildcards: [of_coding("model.safetensors")(wildcards)]),
        statistics=of_systems(statistics_of(file="camera.tsv")),
        lips=of_systems(lambda wildcards: filled("<system>/{file}.tsv", wildcards, file=["lips_camera", "costs"])),
    output:
        table_files("<corpus>/tables/systems", "systems", system="all"),
    log:
        "<corpus>/logs/tabulate_systems.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        systems=carried(tabulated),
        systems_digest=marked(tabulated),
        bootstrap=lambda wildcards: system_of(systems_of(wildcards)[0])["tables"]["bootstrap"],
        seed=SEED,
        digits=lambda wildcards: system_of(systems_of(wildcards)[0])["tables"]["digits"],
        code=code("tabulate_systems.py"),
    script:
        "../scripts/tabulate_systems.py"
