# Who speaks, and what.
from visualspeech.planning.blocks import speaking_row
from visualspeech.planning.codings import no_picture
from visualspeech.speech.sentences import listed_sentences
from visualspeech.speech.tts import letter_to_sound

SPEAK = SETTINGS["speak"]


def speaking():
    """(corpus, system, model) of every speaker: one for each corpus on which the system that speaks runs. The model is
    empty where none of the system can read new speech. There is none where no system predicts a picture."""
    able = [name for _, name in PLAN.pairs if is_pictured(name)]
    if not able:
        return []
    system = SPEAK["system"] or able[0]
    own = SETTINGS["systems"][system]
    model = SPEAK["model"] or speaking_row(rows_of(system), own["blocks"], own["videos"]["model"])
    return [(corpus, system, model) for corpus, name in PLAN.pairs if name == system]


def sound_model_of(wildcards):
    """Name of the row that speaks for recordings without a text; empty for none, and where the speaker's own does."""
    name = system_of(wildcards)["sound_model"]
    return "" if name == wildcards.model else name


def sound_model_file(wildcards):
    """Input function: the file of that row's model, or nothing."""
    name = sound_model_of(wildcards)
    return filled("<system>/models/{sound}/model.safetensors", wildcards, sound=name)[0] if name else []


def speaker_code(script):
    """Params function: digest of a script with the code of the rows that speak."""

    def digest(wildcards):
        names = [wildcards.model, *filter(None, [sound_model_of(wildcards)])]
        return [model_code(script)(OfModel(wildcards, name)) for name in names]

    return digest


class OfModel:
    """Wildcards of another model of a job's system, for the functions that take a job's."""

    def __init__(self, wildcards, model):
        self.corpus, self.system, self.model = wildcards.corpus, wildcards.system, model


def sentences():
    """What is said, one text per video, by number."""
    try:
        if workflow.is_main_process and SPEAK["voice"]["voice"] != "en-us":
            letter_to_sound("a", SPEAK["voice"]["voice"])
        return listed_sentences(SPEAK["sentences"], SPEAK["file"])
    except VisualSpeechError as error:
        raise WorkflowError(f"`speak`: {error}")


SPEAKERS = speaking()

for name in SPEAK["background"]:
    if SPEAKERS and not any(name in PLAN.corpora[corpus].split for corpus, _, _ in SPEAKERS):
        raise WorkflowError(f"`speak.background: {name}` is no utterance of the corpus.")

SENTENCES = sentences()


def check_speakers():
    """Refuse to make a speaker where no system predicts a picture, or all models of the one that is to speak read the
    recorded face."""
    if not SPEAKERS:
        system = PLAN.pairs[0][1]
        refuse(
            f"{no_picture(system, coding_of(OfSystem(*PLAN.pairs[0])))}; select a system that speaks, such as fan2015."
        )
    for _, system, model in SPEAKERS:
        if not model:
            refuse(
                f"every model of {system} reads dynamic visemes of the recording (`source: oracle`), and new text has "
                "none; add a model with predicted ones, or name another system in `speak.system`."
            )


def speaker_folders(wildcards):
    """Input function: folders of all speakers."""
    check_speakers()
    pattern = plain("<system>/speakers/{model}")
    return [pattern.format(corpus=corpus, system=system, model=model) for corpus, system, model in SPEAKERS]


def spoken_videos(wildcards):
    """Input function: videos of all speakers and texts."""
    check_speakers()
    pattern = plain("<system>/spoken/{number}.mp4")
    return [
        pattern.format(corpus=corpus, system=system, number=number)
        for corpus, system, _ in SPEAKERS
        for number in SENTENCES
    ]
