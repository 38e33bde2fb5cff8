rule build_targets:
    input:
        parameters=lambda wildcards: filled(
            "<coding>/parameters/{shard}.h5", wildcards, coding=system_of(wildcards)["coding"]
        )[0],
    output:
        "<aam_system>/targets/{shard}.h5",
    log:
        "<system>/logs/build_targets/{shard}.log",
    benchmark:
        "<system>/benchmarks/build_targets/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(60),
        runtime=minutes(1),
        disk_mb=disk(200, 5),
    params:
        rate=lambda wildcards: system_of(wildcards)["rate"],
        points=lambda wildcards: coding_of(wildcards)["points"],
        code=points_code("build_targets.py"),
    script:
        "../scripts/build_targets.py"


rule fit_block:
    input:
        utterances=of_coding("utterances.tsv"),
        phones=where_needed("text", "<corpus>/phones.tsv"),
        alignment=where_needed("text", "<corpus>/alignment/{shard}.tsv"),
        audio=where_needed("audio", "<corpus>/audio/{shard}.h5"),
        targets=shards("<system>/targets/{shard}.h5"),
        blocks=lambda wildcards: filled(
            "<system>/features/{part}/block.safetensors", wildcards, part=parts_of_block(wildcards)
        ),
    output:
        "<system>/features/{block}/block.safetensors",
    log:
        "<system>/logs/fit_block/{block}.log",
    benchmark:
        "<system>/benchmarks/fit_block/{block}.tsv"
    threads: 1
    resources:
        mem_mb=growing_memory(480, 2),
        runtime=minutes(3),
        disk_mb=disk(100),
    params:
        kind=lambda wildcards: block_of(wildcards)["kind"],
        settings=lambda wildcards: block_of(wildcards)["settings"],
        faces=lambda wildcards: "faces" in needs_of(block_class(block_of(wildcards)["kind"])),
        made_of=lambda wildcards: parts_of_block(wildcards),
        code=lambda wildcards: code("fit_block.py", block_module(block_of(wildcards)["kind"])),
    script:
        "../scripts/fit_block.py"


rule encode_block:
    input:
        utterances=of_coding("utterances.tsv"),
        block="<system>/features/{block}/block.safetensors",
        alignment=where_needed("text", "<corpus>/alignment/{shard}.tsv"),
        audio=where_needed("audio", "<corpus>/audio/{shard}.h5"),
        targets="<system>/targets/{shard}.h5",
    output:
        "<system>/features/{block}/{shard}.h5",
    log:
        "<system>/logs/encode_block/{block}/{shard}.log",
    benchmark:
        "<system>/benchmarks/encode_block/{block}/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(200),
        runtime=minutes(3),
        disk_mb=disk(200, 5),
    params:
        code=lambda wildcards: code("encode_block.py", block_module(block_of(wildcards)["kind"])),
    script:
        "../scripts/encode_block.py"
