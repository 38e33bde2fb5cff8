# Material of a preference test (Fan 2015, Fig. 4), and what its viewers answered.
rule render_pairs:
    input:
        utterances=of_coding("utterances.tsv"),
        aam=of_coding("model.safetensors"),
        reference=of_coding("reference.safetensors"),
        head=of_head,
        first=predictions_of(0),
        second=predictions_of(1),
        landmarks=shards("<corpus>/landmarks/{shard}.h5"),
        pose=shards("<corpus>/pose/{shard}.h5"),
        textures=faces,
    output:
        videos=directory("<aam_system>/preference/videos"),
        sheet="<system>/preference/answers.tsv",
        # Not beside the videos: who shows them should not see it.
        key="<system>/preference_key.tsv",
    log:
        "<system>/logs/render_pairs.log",
    benchmark:
        "<system>/benchmarks/render_pairs.tsv"
    threads: 1
    resources:
        mem_mb=memory(300),
        runtime=minutes(1, least=30),
        disk_mb=disk(1000),
    params:
        models=lambda wildcards: system_of(wildcards)["preference"]["models"],
        pairs=lambda wildcards: system_of(wildcards)["preference"]["count"],
        label=lambda wildcards: system_of(wildcards)["videos"]["label"],
        names=names_of,
        seed=SEED,
        code=code("render_pairs.py"),
    script:
        "../scripts/render_pairs.py"


rule tally_preference:
    input:
        utterances=of_coding("utterances.tsv"),
        coding=of_coding("model.safetensors"),
        statistics=statistics_of(names=of_preference),
        key="<system>/preference_key.tsv",
        answers=answers_of,
    output:
        table_files("<system>/tables/preference", "preference"),
    log:
        "<system>/logs/tally_preference.log",
    threads: 1
    resources:
        mem_mb=memory(150),
        runtime=minutes(1),
        disk_mb=disk(10),
    params:
        rows=carried(plain_rows(names=of_preference)),
        rows_digest=marked(plain_rows(names=of_preference)),
        facts=facts_of,
        published=lambda wildcards: system_of(wildcards)["published"],
        code=code("tally_preference.py"),
    script:
        "../scripts/tally_preference.py"
