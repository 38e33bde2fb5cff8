import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.models.rest import rest_of, resting_face, resting_frames
from visualspeech.speech.spoken import timed


def test_the_face_at_rest_is_that_of_silence_away_from_speech():
    spoken = timed([("sil", 0, 0.4), ("aa", 0.4, 0.8), ("sil", 0.8, 1.2)])
    found = resting_frames(spoken, 30, 25.0, after=0.11, before=0.31)
    times = (np.arange(30) + 0.5) / 25
    assert np.array_equal(found, (times < 0.09) | (times > 0.91))
    assert np.allclose(rest_of([np.ones((3, 2)), np.zeros((1, 2))]), 0.75)
    with pytest.raises(DataError, match="no silence"):
        rest_of([np.zeros((0, 2))])


def test_recordings_cut_close_to_the_speech_rest_where_they_can():
    long = timed([("sil", 0, 0.4), ("aa", 0.4, 0.8), ("sil", 0.8, 1.2)])
    close = timed([("sil", 0, 0.2), ("aa", 0.2, 0.8), ("sil", 0.8, 1.0)])
    seen, times = np.arange(30.0)[:, None], (np.arange(30) + 0.5) / 25
    assert np.allclose(resting_face(lambda: iter([(long, seen, 25.0)])), seen[times > 1.05].mean())
    near = (times < 0.08) | ((times > 0.92) & (times < 1.0))
    assert np.allclose(resting_face(lambda: iter([(close, seen[:25], 25.0)])), seen[near].mean())
