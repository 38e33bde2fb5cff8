rule fit_reference:
    input:
        utterances=f"{RUN}/utterances.tsv",
        pose=shards(f"{RUN}/pose/{{shard}}.h5"),
    output:
        f"{RUN}/aam/reference.safetensors",
    log:
        f"{RUN}/logs/fit_reference.log",
    benchmark:
        f"{RUN}/benchmarks/fit_reference.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["texture"],
        code=code("fit_reference.py"),
    script:
        "../scripts/fit_reference.py"


rule sample_textures:
    input:
        utterances=f"{RUN}/utterances.tsv",
        reference=f"{RUN}/aam/reference.safetensors",
        landmarks=f"{CORPUS}/landmarks/{{shard}}.h5",
        pose=f"{RUN}/pose/{{shard}}.h5",
        alignment=f"{CORPUS}/alignment/{{shard}}.tsv",
        recordings=recordings,
    output:
        f"{RUN}/aam/textures/{{shard}}.h5",
    log:
        f"{RUN}/logs/sample_textures/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/sample_textures/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        drift=SETTINGS["drift"],
        code=code("sample_textures.py"),
    script:
        "../scripts/sample_textures.py"


rule fit_aam:
    input:
        utterances=f"{RUN}/utterances.tsv",
        textures=shards(f"{RUN}/aam/textures/{{shard}}.h5"),
    output:
        f"{RUN}/aam/model.safetensors",
    log:
        f"{RUN}/logs/fit_aam.log",
    benchmark:
        f"{RUN}/benchmarks/fit_aam.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        settings=SETTINGS["aam"],
        seed=SEED,
        code=code("fit_aam.py"),
    script:
        "../scripts/fit_aam.py"


rule encode_appearance:
    input:
        aam=f"{RUN}/aam/model.safetensors",
        textures=FACES,
    output:
        f"{RUN}/aam/parameters/{{shard}}.h5",
    log:
        f"{RUN}/logs/encode_appearance/{{shard}}.log",
    benchmark:
        f"{RUN}/benchmarks/encode_appearance/{{shard}}.tsv"
    conda:
        "../envs/visualspeech.yaml"
    params:
        code=code("encode_appearance.py"),
    script:
        "../scripts/encode_appearance.py"
