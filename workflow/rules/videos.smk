rule render_videos:
    input:
        utterances=f"{RUN}/utterances.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        reference=f"{RUN}/aam/reference.safetensors",
        head=f"{RUN}/pose/head.safetensors",
        predictions=f"{RUN}/models/{SETTINGS['videos']['model']}/predictions.h5",
        landmarks=shards(f"{CORPUS}/landmarks/{{shard}}.h5"),
        pose=shards(f"{RUN}/pose/{{shard}}.h5"),
        parameters=shards(f"{RUN}/aam/parameters/{{shard}}.h5"),
        textures=shards(FACES),
    output:
        directory(f"{RUN}/videos"),
    log:
        f"{RUN}/logs/render_videos.log",
    benchmark:
        f"{RUN}/benchmarks/render_videos.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["videos"],
        names={
            "corpus": PLAN.name,
            "model": SETTINGS["videos"]["model"],
            "consent": SETTINGS["corpus"].get("consent", ""),
        },
        code=code("render_videos.py"),
    script:
        "../scripts/render_videos.py"
