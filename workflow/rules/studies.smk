# Viewing tests: stimuli with meaningless names, and the key apart from them.
rule make_study:
    input:
        utterances=of_study_codings("<coding>/utterances.tsv"),
        aam=of_study_codings("<coding>/model.safetensors", "aam"),
        reference=of_study_codings("<coding>/reference.safetensors", "aam"),
        head=where_pictured(of_head),
        landmarks=where_pictured(shards("<corpus>/landmarks/{shard}.h5")),
        pose=where_pictured(shards("<corpus>/pose/{shard}.h5")),
        textures=faces_of_study,
        markers=of_study_codings("<coding>/model.safetensors", "markers"),
        parameters=of_study_codings("<coding>/parameters/{shard}.h5", "markers"),
        audio=where_drawn(shards("<corpus>/audio/{shard}.h5")),
        predictions=predictions_of_study,
    output:
        study="<study>/study.json",
        key="<study>/key.json",
        media=directory("<study>/media"),
    log:
        "<study>/logs/make_study.log",
    benchmark:
        "<study>/benchmarks/make_study.tsv"
    threads: 1
    resources:
        mem_mb=memory(300),
        runtime=minutes(2, least=60),
        disk_mb=disk(2000),
    params:
        study=study_of,
        codings=codings_of_study,
        names=names_of,
        seed=SEED,
        code=code("make_study.py"),
    script:
        "../scripts/make_study.py"
