# Motion capture takes the place of landmarks and pose in corpora without video.
rule read_motion:
    input:
        checked=ancient("<corpus>/check/findings.tsv"),
        utterances="<corpus>/corpus/utterances/{shard}.tsv",
        audio="<corpus>/audio/{shard}.h5",
    output:
        motion="<corpus>/motion/{shard}.h5",
        findings="<corpus>/motion/{shard}.findings.tsv",
    log:
        "<corpus>/logs/read_motion/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/read_motion/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(260),
        runtime=minutes(30),
        disk_mb=disk(500, 5),
    params:
        settings=SETTINGS["motion"],
        source=motion_of,
        recordings=recordings_digest,
        code=code("read_motion.py"),
    script:
        "../scripts/read_motion.py"
