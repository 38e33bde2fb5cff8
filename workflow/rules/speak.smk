# A speaker who says any text: the folder that the console command `visualspeech speak` takes, and given sentences.
rule bundle_speaker:
    input:
        utterances=of_coding("utterances.tsv"),
        phones="<corpus>/phones.tsv",
        model="<system>/models/{model}/model.safetensors",
        sound=sound_model_file,
        aam=of_coding("model.safetensors"),
        reference=of_coding("reference.safetensors"),
        head=of_head,
        alignment=shards("<corpus>/alignment/{shard}.tsv"),
        landmarks=shards("<corpus>/landmarks/{shard}.h5"),
        pose=shards("<corpus>/pose/{shard}.h5"),
        textures=faces,
        parameters=lambda wildcards: filled(
            "<coding>/parameters/{shard}.h5",
            wildcards,
            coding=system_of(wildcards)["coding"],
            shard=PLAN.corpora[wildcards.corpus].shards,
        ),
    output:
        directory("<system>/speakers/{model}"),
    log:
        "<system>/logs/bundle_speaker/{model}.log",
    benchmark:
        "<system>/benchmarks/bundle_speaker/{model}.tsv"
    threads: 1
    resources:
        mem_mb=memory(350),
        runtime=minutes(1),
        disk_mb=disk(500),
    params:
        background=SPEAK["background"],
        seconds=SPEAK["background_seconds"],
        names=names_of,
        sound_model=sound_model_of,
        dictionary=carried(dictionary_of),
        dictionary_digest=marked(dictionary_state),
        code=speaker_code("bundle_speaker.py"),
    script:
        "../scripts/bundle_speaker.py"


rule speak_sentence:
    input:
        lambda wildcards: filled(
            "<system>/speakers/{model}",
            wildcards,
            model=next(model for corpus, system, model in SPEAKERS if system == wildcards.system),
        ),
    output:
        "<system>/spoken/{number}.mp4",
    log:
        "<system>/logs/speak_sentence/{number}.log",
    benchmark:
        "<system>/benchmarks/speak_sentence/{number}.tsv"
    wildcard_constraints:
        number=r"\d+",
    threads: 1
    resources:
        mem_mb=memory(500),
        runtime=minutes(1),
        disk_mb=disk(500),
    params:
        text=lambda wildcards: SENTENCES[wildcards.number],
        voice=SPEAK["voice"],
        label=SPEAK["label"],
        code=code("speak_sentence.py"),
    script:
        "../scripts/speak_sentence.py"
