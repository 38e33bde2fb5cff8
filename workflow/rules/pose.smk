rule fit_head:
    input:
        landmarks=shards(f"{CORPUS}/landmarks/{{shard}}.h5"),
        split=f"{CORPUS}/corpus/split.tsv",
    output:
        f"{RUN}/pose/head.safetensors",
    log:
        f"{RUN}/logs/fit_head.log",
    benchmark:
        f"{RUN}/benchmarks/fit_head.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["pose"],
        code=code("fit_head.py"),
    script:
        "../scripts/fit_head.py"


rule normalise_pose:
    input:
        head=f"{RUN}/pose/head.safetensors",
        landmarks=f"{CORPUS}/landmarks/{{shard}}.h5",
    output:
        f"{RUN}/pose/{{shard}}.h5",
    log:
        f"{RUN}/logs/normalise_pose/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/normalise_pose/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["pose"],
        code=code("normalise_pose.py"),
    script:
        "../scripts/normalise_pose.py"


rule accept_utterances:
    input:
        utterances=shards(f"{CORPUS}/corpus/utterances/{{shard}}.tsv"),
        split=f"{CORPUS}/corpus/split.tsv",
        head=f"{RUN}/pose/head.safetensors",
        landmarks=shards(f"{CORPUS}/landmarks/{{shard}}.h5"),
        pose=shards(f"{RUN}/pose/{{shard}}.h5"),
        findings=[
            f"{CORPUS}/check/findings.tsv",
            *shards(f"{CORPUS}/alignment/{{shard}}.findings.tsv"),
            *shards(f"{CORPUS}/landmarks/{{shard}}.findings.tsv"),
        ],
    output:
        accepted=f"{RUN}/utterances.tsv",
        findings=f"{RUN}/findings.tsv",
    log:
        f"{RUN}/logs/accept_utterances.log",
    benchmark:
        f"{RUN}/benchmarks/accept_utterances.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["screening"],
        limit=SETTINGS["max_rejected_share"],
        code=code("accept_utterances.py"),
    script:
        "../scripts/accept_utterances.py"
