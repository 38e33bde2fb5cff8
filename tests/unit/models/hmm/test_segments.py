import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.models.hmm.segments import ContextLayout, PhoneTrack, layout_text, phone_track
from visualspeech.speech.spoken import timed

PHONES = ("sil", "aa", "b")
ALIGNMENT = timed([("b", 0.0, 0.1), ("aa", 0.1, 0.25), ("sil", 0.25, 0.4)])


def test_neighbours_and_starts():
    track = phone_track(ALIGNMENT, PHONES)
    assert track.contexts.tolist() == [[0, 2, 1], [2, 1, 0], [1, 0, 0]]
    assert track.starts.tolist() == [0.0, 0.1, 0.25]
    assert track.layout == ContextLayout(3, 1)


def test_neighbours_on_either_side():
    track = phone_track(ALIGNMENT, PHONES, before=2, after=1)
    assert track.contexts.tolist() == [[0, 0, 2, 1], [0, 2, 1, 0], [2, 1, 0, 0]]
    assert track.layout == ContextLayout(4, 2)


def test_runs_leave_out_a_phone_between_two_frames():
    track = PhoneTrack(np.array([[0, 0, 2], [0, 2, 1], [2, 1, 0]]), np.array([0.0, 0.025, 0.055]), 1)
    contexts, lengths = track.runs(4, 25.0)
    assert (contexts.tolist(), lengths.tolist()) == ([[0, 0, 2], [2, 1, 0]], [1, 3])
    contexts, lengths = track.runs(10, 100.0)
    assert (contexts[:, 1].tolist(), lengths.tolist()) == ([0, 2, 1], [2, 3, 5])


def test_divisions_of_phones_are_rows():
    contexts = np.array([[0, 2, 1, 0], [0, 2, 1, 1], [2, 1, 0, 0], [2, 1, 0, 1]])
    track = PhoneTrack(contexts, np.array([0.0, 0.03, 0.05, 0.09]), 1, 2)
    assert track.layout == ContextLayout(3, 1, 2) and track.columns == 3
    found, lengths = track.runs(12, 100.0)
    assert found.tolist() == contexts.tolist() and lengths.tolist() == [3, 2, 4, 3]
    assert layout_text(track.layout) == "3 columns, the phone in column 1, phones divided in 2"
    with pytest.raises(DataError, match="do not fit"):
        PhoneTrack(contexts, track.starts, 3, 2)


def test_phones_that_a_model_does_not_have():
    with pytest.raises(DataError, match="does not have zh"):
        phone_track(timed([("zh", 0.0, 0.1)]), PHONES)


@pytest.mark.parametrize(
    ("contexts", "starts", "centre"),
    [(np.zeros((2, 3), int), [0.0], 1), (np.zeros((2, 3), int), [0.0, 0.1], 3), (np.zeros((0, 3), int), [], 1)],
)
def test_arrays_that_do_not_fit_each_other(contexts, starts, centre):
    with pytest.raises(DataError, match="do not fit starts of shape"):
        PhoneTrack(contexts, np.array(starts), centre)
