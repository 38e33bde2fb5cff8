import json

import numpy as np
import pytest

from tests.unit.animation import speakers
from visualspeech.animation.bundle import SpeakerBundle
from visualspeech.animation.performance import perform
from visualspeech.animation.timings import Timings
from visualspeech.speech.spoken import speak_text, timed
from visualspeech.speech.spoken_settings import VoiceSettings

FIRST = timed([("sil", 0, 0.4), ("p", 0.4, 0.6), ("aa", 0.6, 0.9), ("sil", 0.9, 1.2)], [("pa", 0.4, 0.9)])
SECOND = timed([("sil", 0, 0.2), ("m", 0.2, 0.5)], [("mm", 0.2, 0.5)])


def given(**changes):
    times = Timings()
    times.add(FIRST, 0.0, 1.2)
    times.add(SECOND, 1.2, 1.7)
    return times.data("Pa. Mm.", 25.0, 43, **changes)


def entries(rows):
    return [(one["label"], one["start"], one["end"]) for one in rows]


def test_the_sentences_follow_each_other_in_the_video():
    data = given()
    assert (data["kind"], data["version"], data["text"]) == ("visualspeech timings", 1, "Pa. Mm.")
    assert (data["rate"], data["frames"], data["seconds"]) == (25.0, 43, 1.72)
    assert entries(data["words"]) == [("pa", 0.4, 0.9), ("mm", 1.4, 1.7)]
    # The pause after one sentence and that before the next are one.
    assert entries(data["phones"]) == [
        ("sil", 0, 0.4), ("p", 0.4, 0.6), ("aa", 0.6, 0.9), ("sil", 0.9, 1.4), ("m", 1.4, 1.7),
    ]  # fmt: skip
    assert entries(data["visemes"]) == [
        ("sil", 0, 0.4), ("PP", 0.4, 0.6), ("aa", 0.6, 0.9), ("sil", 0.9, 1.4), ("PP", 1.4, 1.7),
    ]  # fmt: skip
    assert [one["mpeg4"] for one in data["visemes"]] == [0, 1, 10, 0, 1]


def test_nothing_lies_after_the_end_of_its_sentence():
    times = Timings()
    times.add(FIRST, 0.0, 0.8)
    assert entries(times.data("", 25.0, 20)["phones"]) == [("sil", 0, 0.4), ("p", 0.4, 0.6), ("aa", 0.6, 0.8)]


def test_the_file_is_json_in_utf8(tmp_path):
    times = Timings()
    times.add(FIRST, 0.0, 1.2)
    times.save(tmp_path / "t.json", "Café", 25.0, 30)
    assert "Café" in (tmp_path / "t.json").read_text(encoding="utf-8")
    assert json.loads((tmp_path / "t.json").read_text(encoding="utf-8")) == times.data("Café", 25.0, 30)


@pytest.fixture(scope="module")
def bundle(tmp_path_factory):
    return SpeakerBundle.load(speakers.make(tmp_path_factory.mktemp("speaker") / "made", rate=30.0))


def test_the_times_are_those_of_the_sound_that_is_played(bundle):
    """A second route: the words of each sentence, found again in the samples of the performance."""
    times, text = Timings(), "Bob buys a map. I saw five."
    voice = VoiceSettings(sentence_pause=0.6)
    spoken = list(speak_text(text, voice))
    performance = perform(iter(spoken), bundle.trained, bundle.rest, timings=times)
    data = times.data(performance.text, bundle.background.rate, 1)
    assert [one["label"] for one in data["words"]] == ["bob", "buys", "a", "map", "i", "saw", "five"]
    begins, at = [], 0
    for one in spoken:
        begins.append(at)
        at = round(np.ceil((at + len(one.samples) - 1) / one.rate * 30 - 1e-6) / 30 * one.rate)
    level = np.abs(performance.samples[0 : len(performance.samples)].astype(float))
    window = round(0.02 * performance.audio_rate)
    for word in data["words"]:
        middle = round((word["start"] + word["end"]) / 2 * performance.audio_rate)
        assert level[middle - window : middle + window].max() > 300, word
    pause = next(one for one in data["phones"][1:] if one["label"] == "sil" and one["end"] - one["start"] > 0.4)
    quiet = [round((pause[name] + move) * performance.audio_rate) for name, move in (("start", 0.05), ("end", -0.05))]
    assert level[slice(*quiet)].max() < 300
    assert abs((pause["start"] + pause["end"]) / 2 - begins[1] / performance.audio_rate) < 0.1


def test_performances_are_the_same_with_and_without(bundle):
    one = perform(speak_text("Hello."), bundle.trained, bundle.rest)
    other = perform(speak_text("Hello."), bundle.trained, bundle.rest, timings=Timings())
    assert len(one.samples) == len(other.samples)
    np.testing.assert_array_equal(one.appearance[0 : len(one.appearance)], other.appearance[0 : len(one.appearance)])
