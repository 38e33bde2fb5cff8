"""Small studies with real videos, as the tests of the web application need them."""

from pathlib import Path

import numpy as np
import soundfile

from tests import synthetic
from visualspeech.media.encoding import write_video
from visualspeech.study.layouts import ATTENTION, ITEM, PRACTICE, PREFERENCE, RATING
from visualspeech.study.records import (
    MEDIA,
    Condition,
    Item,
    Key,
    Question,
    SoundCheck,
    Stimulus,
    Study,
    write_key,
    write_study,
)

SECONDS = 0.6
SIDES = Question("preference", "Which of the two faces speaks more naturally?", ("left", "none", "right"))
SCALES = tuple(
    Question(name, f"How natural does the {name} look?", (), 1, 10, "not natural at all", "very natural")
    for name in ("face", "eyebrows", "lips")
)
CONDITIONS = (Condition("a", "Model A", "fan2015", "a"), Condition("b", "Model B", "fan2015", "b"))


def make(folder, kind=PREFERENCE, sentences=3, attention=1, sound=True, seconds=SECONDS, forced=False):
    """A study of two conditions in a folder; returns the folder."""
    folder = Path(folder)
    (folder / MEDIA).mkdir(parents=True)
    clip = folder / "clip.mp4"
    video(clip, seconds)
    items, stimuli, expected = [], {}, {}

    def add(item, role, utterance, sides):
        names = []
        for conditions in sides:
            name = f"s{len(stimuli):03d}.mp4"
            (folder / MEDIA / name).write_bytes(clip.read_bytes())
            stimuli[name] = Stimulus(item, utterance, conditions)
            names.append(name)
        items.append(Item(item, role, tuple(names), seconds))

    orders = [("a", "b"), ("b", "a")] if kind == PREFERENCE else None
    add("p0", PRACTICE, "practised", orders or [("a",)])
    for number in range(sentences):
        if kind == PREFERENCE:
            add(f"i{number}", ITEM, f"sentence{number}", orders)
        else:
            for name in "ab":
                add(f"i{number}{name}", ITEM, f"sentence{number}", [(name,)])
    questions = SCALES if kind == RATING else (SIDES,)
    if forced:
        questions = (Question(SIDES.name, SIDES.text, ("left", "right")),)
    for number in range(attention):
        add(f"t{number}", ATTENTION, "checked", orders[:1] if orders else [("a",)])
        expected[f"t{number}"] = {one.name: "right" if one.choices else 3 for one in questions}
    check = None
    if sound:
        soundfile.write(folder / MEDIA / "sound.wav", synthetic.hum(0.3), 16_000)
        check = SoundCheck("sound.wav", ("river", "table", "window"), "table")
    study = write_study(
        folder,
        Study("small", kind, "Talking faces", "You will see faces.", "Nothing personal is stored.", questions,
              tuple(items), check),
    )  # fmt: skip
    write_key(folder, Key(study.digest, "demo", "0123456789ab", 1, "fan2015", CONDITIONS, stimuli, expected))
    clip.unlink()
    return folder


def video(path, seconds=SECONDS, rate=25):
    """A video of a moving bar with sound."""
    count = round(seconds * rate)
    frames = np.full((count, 120, 240, 3), 90, np.uint8)
    for number, frame in enumerate(frames):
        frame[:, 4 * number : 4 * number + 20] = 230
    write_video(path, iter(frames), rate, synthetic.hum(seconds, 48_000), preset="ultrafast")
