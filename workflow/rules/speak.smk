# A speaker who says any text: the folder that the console command `visualspeech speak` takes, and given sentences.
from visualspeech.speech.sentences import listed_sentences
from visualspeech.speech.tts import letter_to_sound

SPEAK = SETTINGS["speak"]


def speaking():
    """(corpus, system, model) of every speaker: one for each corpus on which the system that speaks runs.

    Raises
    ------
    WorkflowError
        The system or the model is not there, or a text or voice cannot be spoken.
    """
    system = SPEAK["system"] or next(iter(SETTINGS["systems"]))
    if system not in SETTINGS["systems"]:
        raise WorkflowError(f"`speak.system: {system}` is not selected. Selected: {', '.join(SETTINGS['systems'])}.")
    model = SPEAK["model"] or SETTINGS["systems"][system]["videos"]["model"]
    known = [row.name for row in rows_of(system, ("model", "baseline"))]
    if model not in known:
        raise WorkflowError(f"`speak.model: {model}` is no model of {system}. Known: {', '.join(known)}.")
    return [(corpus, system, model) for corpus, name in PLAN.pairs if name == system]


def sentences():
    """What is said, one text per video, by number."""
    try:
        if workflow.is_main_process and SPEAK["voice"]["voice"] != "en-us":
            letter_to_sound("a", SPEAK["voice"]["voice"])
        return listed_sentences(SPEAK["sentences"], SPEAK["file"])
    except VisualSpeechError as error:
        raise WorkflowError(f"`speak`: {error}")


for name in SPEAK["background"]:
    if not any(name in PLAN.corpora[corpus].split for corpus, _, _ in speaking()):
        raise WorkflowError(f"`speak.background: {name}` is no utterance of the corpus.")

SPEAKERS = speaking()
SENTENCES = sentences()


def speaker_folders():
    """Folders of all speakers."""
    pattern = workflow.pathvars.apply("<system>/speakers/{model}")
    return [pattern.format(corpus=corpus, system=system, model=model) for corpus, system, model in SPEAKERS]


def spoken_videos():
    """Videos of all speakers and texts."""
    pattern = workflow.pathvars.apply("<system>/spoken/{{number}}.mp4")
    return [
        pattern.format(corpus=corpus, system=system).replace("{number}", number)
        for corpus, system, _ in SPEAKERS
        for number in SENTENCES
    ]


rule bundle_speaker:
    input:
        utterances="<corpus>/utterances.tsv",
        phones="<corpus>/phones.tsv",
        model="<model>/model.safetensors",
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
        mem_mb=1500,
        disk_mb=500,
    params:
        background=SPEAK["background"],
        seconds=SPEAK["background_seconds"],
        names=names_of,
        code=model_code("bundle_speaker.py"),
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
    threads: 1
    resources:
        mem_mb=1500,
        disk_mb=500,
    wildcard_constraints:
        number=r"\d+",
    params:
        text=lambda wildcards: SENTENCES[wildcards.number],
        voice=SPEAK["voice"],
        label=SPEAK["label"],
        code=code("speak_sentence.py"),
    script:
        "../scripts/speak_sentence.py"
