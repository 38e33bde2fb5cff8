"""Times of predictions."""

import numpy as np
import pytest

from visualspeech.errors import StorageError
from visualspeech.models import speed
from visualspeech.models.speed import read_speed, timed_predictions, write_speed


def test_each_prediction_is_timed_and_the_first_call_is_not(monkeypatch):
    clock, calls = [0.0], []
    monkeypatch.setattr(speed, "process_time", lambda: clock[0])

    def predict(frames):
        # The first call takes ten seconds more.
        clock[0] += frames / 10 + (0 if calls else 10)
        calls.append(frames)
        return np.full(frames, frames)

    found = list(timed_predictions(predict, [("a", 5), ("b", 20)]))
    assert [(name, len(predicted)) for name, predicted, _ in found] == [("a", 5), ("b", 20)]
    assert [seconds for _, _, seconds in found] == pytest.approx([0.5, 2.0])
    assert calls == [5, 5, 20]
    assert list(timed_predictions(predict, [])) == []


def test_times_are_kept_in_a_table(tmp_path):
    path = tmp_path / "speed.tsv"
    write_speed(path, [("b", 0.25), ("007", 1e-5)])
    assert path.read_text().splitlines()[1].startswith("007\t")
    assert read_speed(path) == {"007": 1e-5, "b": 0.25}
    path.write_text("id\nb\n")
    with pytest.raises(StorageError, match="no column seconds"):
        read_speed(path)
