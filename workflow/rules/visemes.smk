# Dynamic visemes: pictures of their classes, and the choice of their number, which is a target of its own.
rule draw_visemes:
    input:
        coding=of_coding("model.safetensors"),
        reference=of_coding("reference.safetensors"),
        block="<system>/features/{block}/block.safetensors",
    output:
        "<system>/features/{block}/visemes.png",
    log:
        "<system>/logs/draw_visemes/{block}.log",
    threads: 1
    resources:
        mem_mb=memory(200),
        runtime=minutes(1),
        disk_mb=disk(50),
    params:
        code=code("draw_visemes.py"),
    script:
        "../scripts/draw_visemes.py"


rule try_viseme_number:
    input:
        utterances=of_coding("utterances.tsv"),
        targets=shards("<system>/targets/{shard}.h5"),
    output:
        "<system>/visemes/{classes}.tsv",
    log:
        "<system>/logs/try_viseme_number/{classes}.log",
    benchmark:
        "<system>/benchmarks/try_viseme_number/{classes}.tsv"
    wildcard_constraints:
        classes=r"\d+",
    threads: 1
    resources:
        mem_mb=growing_memory(480, 2),
        runtime=minutes(3),
        disk_mb=disk(50),
    params:
        settings=lambda wildcards: system_of(wildcards)["blocks"][numbered_block(wildcards.system)]["settings"],
        code=code("try_viseme_number.py"),
    script:
        "../scripts/try_viseme_number.py"


rule tabulate_viseme_numbers:
    input:
        utterances=of_coding("utterances.tsv"),
        numbers=lambda wildcards: filled(
            "<system>/visemes/{classes}.tsv", wildcards, classes=system_of(wildcards)["viseme_numbers"]["classes"]
        ),
    output:
        table_files("<system>/tables/viseme_numbers", "viseme_numbers"),
    log:
        "<system>/logs/tabulate_viseme_numbers.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        facts=facts_of,
        digits=lambda wildcards: system_of(wildcards)["tables"]["digits"],
        code=code("tabulate_viseme_numbers.py"),
    script:
        "../scripts/tabulate_viseme_numbers.py"
