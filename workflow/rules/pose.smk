# A head for each speaker, and the list of accepted utterances: one for all systems.
rule fit_head:
    input:
        utterances=shards("<corpus>/corpus/utterances/{shard}.tsv"),
        landmarks=shards("<corpus>/landmarks/{shard}.h5"),
        split="<corpus>/corpus/split.tsv",
    output:
        "<corpus>/heads/{speaker}.safetensors",
    log:
        "<corpus>/logs/fit_head/{speaker}.log",
    benchmark:
        "<corpus>/benchmarks/fit_head/{speaker}.tsv"
    threads: 1
    resources:
        mem_mb=memory(140),
        runtime=minutes(2),
        disk_mb=disk(100),
    params:
        settings=SETTINGS["pose"],
        code=code("fit_head.py"),
    script:
        "../scripts/fit_head.py"


rule normalise_pose:
    input:
        utterances="<corpus>/corpus/utterances/{shard}.tsv",
        heads=heads_of,
        landmarks="<corpus>/landmarks/{shard}.h5",
    output:
        pose="<corpus>/pose/{shard}.h5",
        findings="<corpus>/pose/{shard}.findings.tsv",
    log:
        "<corpus>/logs/normalise_pose/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/normalise_pose/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(130),
        runtime=minutes(2),
        disk_mb=disk(200, 3),
    params:
        settings=SETTINGS["pose"],
        speakers=lambda wildcards: list(PLAN.corpora[wildcards.corpus].speakers),
        code=code("normalise_pose.py"),
    script:
        "../scripts/normalise_pose.py"


rule accept_utterances:
    input:
        utterances=shards("<corpus>/corpus/utterances/{shard}.tsv"),
        split="<corpus>/corpus/split.tsv",
        heads=heads_of,
        landmarks=shards_given("video", "<corpus>/landmarks/{shard}.h5"),
        pose=shards_given("video", "<corpus>/pose/{shard}.h5"),
        motion=shards_given("motion", "<corpus>/motion/{shard}.h5"),
        findings=findings_of,
    output:
        accepted="<corpus>/utterances.tsv",
        findings="<corpus>/findings.tsv",
    log:
        "<corpus>/logs/accept_utterances.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(2),
        disk_mb=disk(100),
    params:
        settings=SETTINGS["screening"],
        speakers=speakers_with_heads,
        limit=SETTINGS["max_rejected_share"],
        code=code("accept_utterances.py"),
    script:
        "../scripts/accept_utterances.py"
