"""Which frames a head is fitted to."""

import numpy as np
import pytest

from visualspeech.errors import CorpusError
from visualspeech.face.sampling import frame_size, sample_landmarks, screen_frame_sizes
from visualspeech.storage.arrays import ArrayReader, ArrayWriter


@pytest.fixture
def landmarks(tmp_path):
    with ArrayWriter(tmp_path / "l.h5") as out:
        for number in range(6):
            points = np.full((10, 68, 2), float(number))
            points[:, 0, 0] = np.arange(10)
            size = {"width": 99 if number == 5 else 360, "height": 288}
            detected = np.arange(10) % 2 == 0
            out.add(f"u{number}", {"points": points, "detected": detected}, 25.0, **size)
    with ArrayReader(tmp_path / "l.h5") as reader:
        yield type("Files", (), {"array": reader.array, "reader": lambda self, one: reader})()


def test_frames_are_spread_over_utterances_of_the_usual_size_and_were_detected(landmarks):
    ids = [f"u{number}" for number in range(6)]
    points, size = sample_landmarks(landmarks, ids, 10)
    assert size == (360, 288) == frame_size(landmarks, ids)
    assert sorted(set(points[:, 5, 0])) == [0, 1, 2, 3, 4]
    assert np.all(points[:, 0, 0] % 2 == 0)
    assert len(points) == 10


def test_fewer_frames_than_utterances(landmarks):
    points, _ = sample_landmarks(landmarks, [f"u{number}" for number in range(5)], 3)
    assert len(points) == 3


def test_another_frame_size_is_rejected_by_name(landmarks):
    ids = [f"u{number}" for number in range(6)]
    refused = screen_frame_sizes(landmarks, ids, ids)
    assert list(refused) == ["u5"] and "99x288" in refused["u5"].reason
    # The usual size is that of the training utterances, however many others there are.
    assert list(screen_frame_sizes(landmarks, ids, ["u5"])) == ids[:5]


def test_nothing_to_fit_is_a_sentence(landmarks):
    with pytest.raises(CorpusError, match="no training utterance"):
        sample_landmarks(landmarks, [], 5)
