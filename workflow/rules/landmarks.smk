rule track_landmarks:
    input:
        checked=ancient(f"{CORPUS}/check/findings.tsv"),
        utterances=f"{CORPUS}/corpus/utterances/{{shard}}.tsv",
        audio=f"{CORPUS}/audio/{{shard}}.h5",
        recordings=recordings,
    output:
        landmarks=f"{CORPUS}/landmarks/{{shard}}.h5",
        findings=f"{CORPUS}/landmarks/{{shard}}.findings.tsv",
    log:
        f"{CORPUS}/logs/track_landmarks/{{shard}}.log",
    benchmark:
        f"{CORPUS}/benchmarks/track_landmarks/{{shard}}.tsv"
    params:
        settings=SETTINGS["landmarks"],
        code=code("track_landmarks.py"),
    script:
        "../scripts/track_landmarks.py"
