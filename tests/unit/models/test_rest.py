"""The face at rest: silence away from speech, or the short silences of recordings without a long one."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.models.rest import rest_of, resting_face, resting_frames
from visualspeech.speech.spoken import timed

SPOKEN = timed([("sil", 0.0, 1.0), ("aa", 1.0, 1.5), ("sil", 1.5, 2.5)])
CLOSE = timed([("sil", 0.0, 0.2), ("aa", 0.2, 0.8), ("sil", 0.8, 1.0)])


def test_frames_of_rest_are_silent_and_away_from_speech():
    times = (np.arange(50) + 0.5) / 20
    expected = (times < 0.5) | (times > 1.75)
    assert resting_frames(SPOKEN, 50, 20.0).tolist() == expected.tolist()
    wider = resting_frames(SPOKEN, 50, 20.0, after=0.0, before=0.0)
    assert wider.tolist() == ((times < 1.0) | (times > 1.5)).tolist()
    assert resting_frames(timed([("sil", 0.0, 1.0)]), 5, 5.0).all()
    assert not resting_frames(timed([("aa", 0.0, 1.0)]), 5, 5.0).any()


def given(*utterances):
    return lambda: iter(utterances)


def test_the_mean_over_all_frames_of_rest():
    values = np.arange(100.0).reshape(50, 2)
    found = resting_face(given((SPOKEN, values, 20.0), (CLOSE, np.full((20, 2), 9e9), 20.0)))
    assert found.dtype == np.float32
    assert np.allclose(found, values[resting_frames(SPOKEN, 50, 20.0)].mean(axis=0))


def test_short_silences_count_where_there_is_no_long_one():
    values = np.arange(40.0).reshape(20, 2)
    times = (np.arange(20) + 0.5) / 20
    expected = values[(times < 0.08) | (times > 0.92)].mean(axis=0)
    assert np.allclose(resting_face(given((CLOSE, values, 20.0))), expected)


def test_no_silence_at_all():
    with pytest.raises(DataError, match="no silence that shows the face at rest"):
        resting_face(given((timed([("aa", 0.0, 1.0)]), np.zeros((5, 2)), 5.0)))
    with pytest.raises(DataError, match="no silence"):
        rest_of([])
    assert rest_of([np.ones((2, 3)), np.zeros((2, 3))]).tolist() == [0.5, 0.5, 0.5]
