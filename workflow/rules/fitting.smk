# With `aam_source: fit` the trained AAM is fitted to every frame, and the parameters code what it finds.
rule fit_faces:
    input:
        utterances=f"{RUN}/utterances.tsv",
        aam=f"{RUN}/aam/model.safetensors",
        reference=f"{RUN}/aam/reference.safetensors",
        head=f"{RUN}/pose/head.safetensors",
        textures=f"{RUN}/aam/textures/{{shard}}.h5",
        landmarks=f"{CORPUS}/landmarks/{{shard}}.h5",
        pose=f"{RUN}/pose/{{shard}}.h5",
        alignment=f"{CORPUS}/alignment/{{shard}}.tsv",
        recordings=recordings,
    output:
        f"{RUN}/aam/fitted/{{shard}}.h5",
    log:
        f"{RUN}/logs/fit_faces/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/fit_faces/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        drift=SETTINGS["drift"],
        fitting=SETTINGS.get("fitting", {}),
        code=code("fit_faces.py"),
    script:
        "../scripts/fit_faces.py"
