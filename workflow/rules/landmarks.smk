rule track_landmarks:
    input:
        checked=ancient("<corpus>/check/findings.tsv"),
        utterances="<corpus>/corpus/utterances/{shard}.tsv",
        audio="<corpus>/audio/{shard}.h5",
        recordings=recordings,
    output:
        landmarks="<corpus>/landmarks/{shard}.h5",
        findings="<corpus>/landmarks/{shard}.findings.tsv",
    log:
        "<corpus>/logs/track_landmarks/{shard}.log",
    benchmark:
        "<corpus>/benchmarks/track_landmarks/{shard}.tsv"
    threads: 1
    resources:
        mem_mb=memory(260),
        runtime=minutes(30, least=15),
        disk_mb=disk(500, 1),
    params:
        landmarks=SETTINGS["landmarks"],
        screening=SETTINGS["screening"],
        recordings=recordings_digest,
        files=landmark_files,
        folder=carried(tracker_folder),
        code=tracker_digest,
    script:
        "../scripts/track_landmarks.py"
