"""Normalised counts: moments of all frames at once, the range of training, and what does not vary."""

import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.features.counts import COUNTS, Counts, fit_counts
from visualspeech.storage.layouts import check_plain


def test_statistics_are_those_of_all_frames_whatever_their_order():
    random = np.random.default_rng(2)
    utterances = [random.integers(0, 300, (length, 4)) for length in (5, 1, 200, 0, 33)]
    found = fit_counts(iter(utterances), 4)
    every = np.concatenate(utterances)
    assert np.allclose(found.mean, every.mean(axis=0), rtol=1e-14)
    assert np.allclose(found.deviation, every.std(axis=0), rtol=1e-10)
    values = found.normalised(every)
    assert values.dtype == np.float32
    assert np.allclose(values.mean(axis=0), 0, atol=1e-6) and np.allclose(values.std(axis=0), 1, atol=1e-6)
    assert fit_counts(reversed(utterances), 4) == found and found != fit_counts(utterances[:1], 4)
    check_plain("a file", found.plain(), COUNTS)
    assert Counts.of(found.plain(), 4) == found
    with pytest.raises(SettingError, match="statistics of 4 counts, the features have 3"):
        Counts.of(found.plain(), 3)


def test_counts_beyond_those_of_training_are_limited():
    found = fit_counts([np.array([[2.0], [4.0], [6.0]])], 1)
    values = found.normalised(np.array([[0.0], [2.0], [6.0], [40.0]]))[:, 0]
    assert values[0] == values[1] and values[2] == values[3] and values[1] == pytest.approx(-np.sqrt(1.5))


def test_a_count_that_does_not_vary_is_zero():
    found = fit_counts([np.full((10, 1), 6.0)], 1)
    assert found.normalised(np.array([[6.0], [9.0]])).tolist() == [[0.0], [0.0]]


def test_no_frames_are_refused():
    with pytest.raises(DataError, match="there is no training utterance"):
        fit_counts([], 2)
    with pytest.raises(DataError, match="there is no training utterance"):
        fit_counts([np.zeros((0, 2))], 2)


def test_no_counts_are_no_error():
    found = fit_counts([np.zeros((3, 0))], 0)
    assert isinstance(found, Counts) and found.normalised(np.zeros((3, 0))).shape == (3, 0)
