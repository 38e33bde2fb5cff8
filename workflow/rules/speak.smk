# A speaker who says any text: the bundle that the console command `visualspeech speak` takes, and given sentences.
from visualspeech.speech.sentences import listed_sentences
from visualspeech.speech.tts import letter_to_sound

SPEAK = {
    "model": SETTINGS["videos"]["model"],
    "label": SETTINGS["videos"]["label"],
    "sentences": ["Hello."],
    "file": "",
    "voice": {},
    "background": [],
    "background_seconds": 9,
} | SETTINGS.get("speak", {})

if SPEAK["model"] not in MODELS:
    raise WorkflowError(f"`speak.model: {SPEAK['model']}` is not trained. Trained here: {', '.join(MODELS)}.")
for name in SPEAK["background"]:
    if name not in PLAN.ids:
        raise WorkflowError(
            f"`speak.background: {name}` is no utterance of the corpus {PLAN.name}; its ids are in "
            f"{CORPUS}/corpus/split.tsv."
        )
try:
    SENTENCES = listed_sentences(SPEAK["sentences"], SPEAK["file"])
    if workflow.is_main_process and "voice" in SPEAK["voice"]:
        letter_to_sound("a", SPEAK["voice"]["voice"])
except VisualSpeechError as error:
    raise WorkflowError(f"`speak`: {error}")


rule bundle_speaker:
    input:
        utterances=f"{RUN}/utterances.tsv",
        phones=f"{RUN}/phones.tsv",
        network=f"{RUN}/models/{{model}}/network.safetensors",
        aam=f"{RUN}/aam/model.safetensors",
        reference=f"{RUN}/aam/reference.safetensors",
        head=f"{RUN}/pose/head.safetensors",
        alignment=shards(f"{CORPUS}/alignment/{{shard}}.tsv"),
        landmarks=shards(f"{CORPUS}/landmarks/{{shard}}.h5"),
        pose=shards(f"{RUN}/pose/{{shard}}.h5"),
        textures=shards(FACES),
        parameters=shards(f"{RUN}/aam/parameters/{{shard}}.h5"),
    output:
        directory(f"{RUN}/speakers/{{model}}"),
    log:
        f"{RUN}/logs/bundle_speaker/{{model}}.log",
    benchmark:
        f"{RUN}/benchmarks/bundle_speaker/{{model}}.tsv"
    wildcard_constraints:
        model="|".join(MODELS),
    conda:
        "../envs/visualspeech.yaml"
    params:
        background=SPEAK["background"],
        seconds=SPEAK["background_seconds"],
        names={"corpus": PLAN.name, "consent": SETTINGS["corpus"].get("consent", "")},
        code=code("bundle_speaker.py"),
    script:
        "../scripts/bundle_speaker.py"


rule speak_sentence:
    input:
        f"{RUN}/speakers/{SPEAK['model']}",
    output:
        f"{RUN}/spoken/{{number}}.mp4",
    log:
        f"{RUN}/logs/speak_sentence/{{number}}.log",
    benchmark:
        f"{RUN}/benchmarks/speak_sentence/{{number}}.tsv"
    wildcard_constraints:
        number=r"\d+",
    conda:
        "../envs/visualspeech.yaml"
    params:
        text=lambda wildcards: SENTENCES[wildcards.number],
        voice=SPEAK["voice"],
        label=SPEAK["label"],
        code=code("speak_sentence.py"),
    script:
        "../scripts/speak_sentence.py"
