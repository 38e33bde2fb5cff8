# The visual coding is what models predict. Its faces are read at landmarks, or where the fitted AAM finds them.
rule fit_reference:
    input:
        utterances="<corpus>/utterances.tsv",
        pose=shards("<corpus>/pose/{shard}.h5"),
    output:
        "<coding>/reference.safetensors",
    log:
        "<coding>/logs/fit_reference.log",
    benchmark:
        "<coding>/benchmarks/fit_reference.tsv"
    threads: 1
    resources:
        mem_mb=memory(120),
        runtime=minutes(2),
        disk_mb=disk(100),
    params:
        points=lambda wildcards: coding_of(wildcards)["points"],
        settings=lambda wildcards: coding_of(wildcards)["texture"],
        code=points_code("fit_reference.py"),
    script:
        "../scripts/fit_reference.py"


rule sample_textures:
    input:
        utterances="<corpus>/utterances.tsv",
        reference="<coding>/reference.safetensors",
        landmarks="<corpus>/landmarks/{shard}.h5",
        pose="<corpus>/pose/{shard}.h5",
        alignment="<corpus>/alignment/{shard}.tsv",
        recordings=recordings,
    output:
        textures="<coding>/textures/{shard}.h5",
        findings="<coding>/textures/{shard}.findings.tsv",
    log:
        "<coding>/logs/sample_textures/{shard}.log",
    benchmark:
        "<coding>/benchmarks/sample_textures/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(170),
        runtime=minutes(10, least=15),
        disk_mb=disk(1000, 50),
    params:
        drift=lambda wildcards: coding_of(wildcards)["drift"],
        recordings=recordings_digest,
        code=points_code("sample_textures.py"),
    script:
        "../scripts/sample_textures.py"


rule fit_aam:
    input:
        utterances="<corpus>/utterances.tsv",
        textures=shards("<coding>/textures/{shard}.h5"),
    output:
        "<aam>/model.safetensors",
    log:
        "<coding>/logs/fit_aam.log",
    benchmark:
        "<coding>/benchmarks/fit_aam.tsv"
    threads: 1
    resources:
        mem_mb=memory(520),
        runtime=minutes(0.5, least=15),
        disk_mb=disk(1000, 1),
    params:
        points=lambda wildcards: coding_of(wildcards)["points"],
        settings=lambda wildcards: coding_of(wildcards)["aam"],
        seed=SEED,
        code=points_code("fit_aam.py"),
    script:
        "../scripts/fit_aam.py"


# Only with `source: fit`: the trained AAM is fitted to every frame, and the parameters code what it finds.
rule fit_faces:
    input:
        utterances="<corpus>/utterances.tsv",
        aam="<coding>/model.safetensors",
        reference="<coding>/reference.safetensors",
        heads=heads_of,
        textures="<coding>/textures/{shard}.h5",
        landmarks="<corpus>/landmarks/{shard}.h5",
        pose="<corpus>/pose/{shard}.h5",
        alignment="<corpus>/alignment/{shard}.tsv",
        recordings=recordings,
    output:
        fitted="<coding>/fitted/{shard}.h5",
        findings="<coding>/fitted/{shard}.findings.tsv",
    log:
        "<coding>/logs/fit_faces/{shard}.log",
    benchmark:
        "<coding>/benchmarks/fit_faces/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(520),
        runtime=minutes(30, least=15),
        disk_mb=disk(1000, 5),
    params:
        drift=lambda wildcards: coding_of(wildcards)["drift"],
        fitting=lambda wildcards: coding_of(wildcards)["fitting"],
        speakers=lambda wildcards: list(PLAN.corpora[wildcards.corpus].speakers),
        recordings=recordings_digest,
        code=points_code("fit_faces.py"),
    script:
        "../scripts/fit_faces.py"


# The utterances that models of this coding see: a recording can fail where it is read again for its faces.
rule accept_faces:
    input:
        utterances="<corpus>/utterances.tsv",
        split="<corpus>/corpus/split.tsv",
        earlier="<corpus>/findings.tsv",
        findings=faces_findings_of,
    output:
        accepted="<coding>/utterances.tsv",
        findings="<coding>/findings.tsv",
    log:
        "<coding>/logs/accept_faces.log",
    localrule: True
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        limit=SETTINGS["max_rejected_share"],
        code=code("accept_faces.py"),
    script:
        "../scripts/accept_faces.py"


rule encode_appearance:
    input:
        aam="<coding>/model.safetensors",
        textures=faces,
    output:
        "<aam>/parameters/{shard}.h5",
    log:
        "<coding>/logs/encode_appearance/{shard}.log",
    benchmark:
        "<coding>/benchmarks/encode_appearance/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(100),
        runtime=minutes(0.1),
        disk_mb=disk(200, 1),
    params:
        code=points_code("encode_appearance.py"),
    script:
        "../scripts/encode_appearance.py"
