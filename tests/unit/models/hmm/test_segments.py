import numpy as np
import pandas
import pytest

from visualspeech.errors import DataError
from visualspeech.models.hmm.segments import PhoneTrack, phone_track

PHONES = ("sil", "aa", "b")


def rows(*spoken):
    return pandas.DataFrame(
        [{"tier": "phone", "index": at, "label": label, "start": start} for at, (label, start) in enumerate(spoken)]
    )


def test_neighbours_and_starts():
    track = phone_track(rows(("b", 0.0), ("aa", 0.1), ("sil", 0.25)), PHONES)
    assert track.triphones.tolist() == [[0, 2, 1], [2, 1, 0], [1, 0, 0]]
    assert track.starts.tolist() == [0.0, 0.1, 0.25]


def test_runs_leave_out_a_phone_between_two_frames():
    track = PhoneTrack(np.array([[0, 0, 2], [0, 2, 1], [2, 1, 0]]), np.array([0.0, 0.025, 0.055]))
    triphones, lengths = track.runs(4, 25.0)
    assert (triphones.tolist(), lengths.tolist()) == ([[0, 0, 2], [2, 1, 0]], [1, 3])
    triphones, lengths = track.runs(10, 100.0)
    assert (triphones[:, 1].tolist(), lengths.tolist()) == ([0, 2, 1], [2, 3, 5])


@pytest.mark.parametrize("spoken", [[("zh", 0.0)], []])
def test_phones_that_a_model_does_not_know(spoken):
    table = rows(*spoken) if spoken else pandas.DataFrame(columns=["tier", "index", "label", "start"])
    with pytest.raises(DataError, match="alignment holds"):
        phone_track(table, PHONES)
