"""A study is drawn by its seed, tells nothing, and its key says what everything is."""

from collections import Counter

import numpy as np
import pytest

from tests import synthetic
from visualspeech.corpora.records import Utterance
from visualspeech.errors import CorpusError, DataError
from visualspeech.media.loudness import integrated_loudness
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.study.making import common_utterances, make_study, planned_items, write_made
from visualspeech.study.records import MEDIA, read_key, read_study
from visualspeech.study.settings import StudySettings
from visualspeech.study.sources import Shown

GREY = {"dark": 60, "light": 200, "recorded": 120}
CONDITIONS = (Shown("dark", "aam", "dark"), Shown("light", "aam", "light"))
NAMES = {"corpus": "demo", "consent": "Nobody's face."}
UTTERANCES = [
    Utterance(f"u{number}", "s", "none.mp4", "words", split)
    for number, split in enumerate(["test"] * 4 + ["validation"] * 2 + ["train"] * 3)
]


class Greys:
    """Faces of one grey by condition, 10 frames of 97 x 61 pixels; the sound of each utterance has its own level."""

    def __init__(self, missing=0):
        self.missing = missing

    def timing(self, utterance):
        return 25.0, 10

    def frames(self, utterance, condition):
        count = 10 - self.missing * (condition.name == "light")
        return iter([np.full((61, 97, 3), GREY[condition.name], np.uint8)] * count)

    def sound(self, utterance):
        return synthetic.hum(0.7) * (1 + int(utterance.id[1:])) / 20, 16_000


def made(folder, settings=None, conditions=CONDITIONS, seed=1, name="mine", faces=None):
    (folder / MEDIA).mkdir(parents=True)
    settings = settings or StudySettings(utterances=3, attention=1)
    found = make_study(folder / MEDIA, name, settings, conditions, UTTERANCES, faces or Greys(), NAMES, seed)
    known = [{"name": one.name, "title": one.name, "system": "fan2015", "model": one.model} for one in conditions]
    write_made(folder, found, known, {one.id: one.split for one in UTTERANCES}, seed, "demo", "fan2015")
    return read_study(folder), read_key(folder)


@pytest.fixture(scope="module")
def preference(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "study"
    return folder, *made(folder)


def brightness(path):
    """Grey of the left and of the right half of the first frame."""
    frame = next(iter(read_frames(path)))
    return [round(float(half.mean())) for half in (frame[:40, :80], frame[:40, -80:])]


def test_the_key_says_what_is_on_which_side(preference):
    folder, study, key = preference
    items = study.of_role("item")
    assert len(items) == 3
    for item in items:
        first, second = (key.stimuli[file] for file in item.stimuli)
        assert first.conditions == second.conditions[::-1] and first.utterance == second.utterance
        for file in item.stimuli:
            greys = [GREY[name] for name in key.stimuli[file].conditions]
            assert brightness(folder / MEDIA / file) == pytest.approx(greys, abs=6)
    assert {key.stimuli[item.stimuli[0]].utterance for item in items} < {"u0", "u1", "u2", "u3"}


def test_stimuli_have_one_length_and_one_loudness(preference):
    folder, study, _ = preference
    for item in study.items:
        for file in item.stimuli:
            about = probe(folder / MEDIA / file)
            assert (about.width, about.height, about.rate) == (202, 62, 25) and item.seconds == pytest.approx(0.4)
            assert len(list(read_frames(folder / MEDIA / file))) == 10
            sound = read_audio(folder / MEDIA / file, 48_000)
            assert integrated_loudness(sound, 48_000) == pytest.approx(-23, abs=0.7)
    spoken = read_audio(folder / MEDIA / study.sound_check.stimulus, 22_050)
    assert integrated_loudness(spoken, 22_050) == pytest.approx(-23, abs=0.3)


def test_practice_and_attention_are_of_other_utterances(preference):
    folder, study, key = preference
    shown = {key.stimuli[one.stimuli[0]].utterance for one in study.of_role("item")}
    (practice,), (attention,) = study.of_role("practice"), study.of_role("attention")
    assert not {key.stimuli[practice.stimuli[0]].utterance, key.stimuli[attention.stimuli[0]].utterance} & shown
    assert len(practice.stimuli) == 2 and len(attention.stimuli) == 1
    assert key.expected == {attention.id: {"preference": key.expected[attention.id]["preference"]}}
    frames = list(read_frames(folder / MEDIA / attention.stimuli[0]))
    assert np.abs(frames[0].astype(int) - frames[-1]).mean() > 5  # the bar of text


def test_names_and_metadata_tell_nothing(preference):
    import av

    folder, study, key = preference
    text = (folder / "study.json").read_text()
    assert not [name for name in ("dark", "light", "u0", "u1", "fan2015") if f'"{name}' in text]
    said = set()
    for file in (folder / MEDIA).glob("*.mp4"):
        assert len(file.stem) == 16
        with av.open(str(file)) as opened:
            said.add(str(sorted(opened.metadata.items())))
    assert len(said) == 1 and "dark" not in said.pop()


def test_a_study_repeats_with_its_seed_alone(preference, tmp_path):
    folder, study, _ = preference
    again, _ = made(tmp_path / "again")
    assert again == study
    for file in (folder / MEDIA).iterdir():
        assert (tmp_path / "again" / MEDIA / file.name).read_bytes() == file.read_bytes()
    other, _ = made(tmp_path / "other", seed=2)
    renamed, _ = made(tmp_path / "renamed", name="another")
    assert {one.id for one in study.items}.isdisjoint(one.id for one in (*other.items, *renamed.items))


def test_a_rating_study_shows_every_condition_alone(tmp_path):
    conditions = (*CONDITIONS, Shown("recorded", "", ""))
    settings = StudySettings(
        "rating", utterances=2, attention=1, sound_check=False, questions={"lips": "?", "all": "?"}
    )
    study, key = made(tmp_path / "study", settings, conditions)
    shown = [key.stimuli[one.stimuli[0]] for one in study.of_role("item")]
    assert Counter(one.conditions for one in shown) == {("dark",): 2, ("light",): 2, ("recorded",): 2}
    assert study.sound_check is None and [one.name for one in study.questions] == ["lips", "all"]
    assert all(1 <= value <= 10 for own in key.expected.values() for value in own.values())
    # No label: it would tell the recorded face.
    for item in study.items:
        if item.role == "item":
            frame = next(iter(read_frames(tmp_path / "study" / MEDIA / item.stimuli[0])))
            assert frame.std() < 3


def test_a_small_corpus_gives_what_it_has():
    generator = np.random.default_rng(1)
    few = [one for one in UTTERANCES if one.split == "test"][:2]
    items = planned_items(StudySettings(utterances=10), CONDITIONS, few, generator)
    assert Counter(one.role for one in items) == {"item": 2, "practice": 1}
    with pytest.raises(CorpusError, match="no test utterance"):
        planned_items(StudySettings(), CONDITIONS, [one for one in UTTERANCES if one.split == "train"], generator)


def test_conditions_of_different_length_are_refused(tmp_path):
    with pytest.raises((DataError, ValueError), match="9 frames in place of 10|shorter"):
        made(tmp_path / "study", faces=Greys(missing=1))


def test_utterances_are_those_of_every_coding(tmp_path):
    from dataclasses import asdict

    import pandas

    from visualspeech.storage.tables import write_table

    for name, rows in (("a.tsv", UTTERANCES), ("b.tsv", UTTERANCES[1:])):
        write_table(tmp_path / name, pandas.DataFrame([asdict(one) for one in rows]))
    found = common_utterances([tmp_path / "a.tsv", tmp_path / "b.tsv"])
    assert [one.id for one in found] == [one.id for one in UTTERANCES[1:]]
