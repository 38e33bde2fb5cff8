"""The folder of clips of a system whose coding are markers."""

import numpy as np
import pytest

from tests.fap_reader import read_fap
from tests.synthetic import hum
from tests.unit.animation.markers.test_actor import moving
from visualspeech.animation.markers.rendering import ANYBODY, actors_of, chosen_clips, motion_of, write_files
from visualspeech.corpora.records import Utterance
from visualspeech.face import marker_coding
from visualspeech.face.markers import read_marker_set
from visualspeech.storage.arrays import ArrayCollection, ArrayReader, ArrayWriter

NAMES = {"corpus": "c", "model": "Joint-2", "consent": "yes"}


def utterance(name, speaker="F", emotion=""):
    return Utterance(name, speaker, "", "", emotion=emotion)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A coding, and files of recorded and predicted parameters and of sound, of one training and one test utterance."""
    folder = tmp_path_factory.mktemp("markers")
    names, points, _ = moving(frames=220)
    markers = read_marker_set("iemocap_46")
    points = points[:, markers.positions_in(names, "here")]
    coding = marker_coding.fit([("F", points)], markers, "iemocap_46")
    parameters = coding.encode(points, "F")
    sound = np.concatenate([np.zeros(8000), hum(1.0)])
    for name, values in (("parameters", parameters), ("predictions", 0.5 * parameters)):
        with ArrayWriter(folder / f"{name}.h5") as out:
            for one in ("seen", "new"):
                out.add(one, {"appearance": values}, 120.0)
    with ArrayWriter(folder / "audio.h5") as out:
        for one in ("seen", "new"):
            out.add(one, {"samples": (32767 * sound).astype(np.int16)}, 16000.0)
    with (
        ArrayCollection([folder / "parameters.h5"]) as recorded,
        ArrayReader(folder / "predictions.h5") as predictions,
        ArrayCollection([folder / "audio.h5"]) as audio,
    ):
        yield coding, recorded, predictions, audio, points


def test_clips_are_spread_over_speakers_and_emotions():
    listed = [utterance(f"{s}{e}{i}", s, e) for s in "ab" for e in "xy" for i in range(3)]
    assert [one.id for one in chosen_clips(listed, 5)] == ["ax0", "ay0", "bx0", "by0", "ax1"]
    plain = [utterance(f"u{i}") for i in range(4)]
    assert chosen_clips(plain, 2) == plain[:2] and chosen_clips(plain, 9) == plain


def test_the_actor_is_that_of_the_speakers_training_utterances(files):
    coding, recorded, _, audio, points = files
    actors = actors_of(coding, [utterance("seen"), utterance("lost")], recorded, audio)
    assert set(actors) == {"F", ANYBODY}
    assert np.allclose(actors["F"].idle, points[0], atol=1e-3), "the quiet frames are the idle face"
    assert actors_of(coding, [], recorded, audio) == {}


@pytest.mark.parametrize("speaker", ["F", "somebody else"])
def test_a_clip_and_its_controls_are_written(files, speaker, tmp_path):
    coding, recorded, predictions, audio, points = files
    actors = actors_of(coding, [utterance("seen")], recorded, audio)
    one = utterance("new", speaker)
    write_files(tmp_path, one, coding, recorded, predictions, audio, actors, NAMES)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.csv", "new.fap", "new.mp4"]
    frames = read_fap((tmp_path / "new.fap").read_text()).frames
    assert len(frames) == 110
    predicted = motion_of(coding, predictions, one)
    assert np.allclose(predicted.points, (points + points.mean(axis=0)) / 2, atol=1e-2)
    # The prediction moves half as much as the recording.
    jaw = np.array([frame[3][0] for frame in frames])
    assert 0.2 * 360 < np.ptp(jaw) < 0.6 * 360
