from dataclasses import replace

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError
from visualspeech.features.labels import label_indices, one_hot

PHONES = ["sil", "ah", "b", "t"]


def alignment(phones, length=0.12):
    return even_alignment([("word", phones)], length)


def test_labels_of_frames_against_a_walk_through_the_states():
    spoken = alignment(["sil", "b", "ah", "t", "sil"])
    labels = label_indices(spoken, 15, 25.0, PHONES)
    padded = ["sil", *(phone.label for phone in spoken.phones), "sil"]
    for frame, label in enumerate(labels):
        time = (frame + 0.5) / 25.0
        state = next(one for one in spoken.states if one.start <= time < one.end)
        around = padded[state.parent : state.parent + 3]
        assert label.tolist() == [*(PHONES.index(phone) for phone in around), int(state.label) - 1]
    assert labels.dtype == np.int16


def test_frames_beyond_the_end_keep_the_last_state():
    labels = label_indices(alignment(["b", "t"]), 10, 25.0, PHONES)
    assert np.array_equal(labels[6:], np.tile([2, 3, 0, 2], (4, 1)))


def test_one_hot_is_the_vector_of_the_paper():
    # K = 4: left "sil", current "b", right "ah", second state.
    assert one_hot(np.array([[0, 2, 1, 1]]), 4).tolist() == [[1, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0]]


def test_one_hot_against_a_loop():
    generator = np.random.default_rng(1)
    labels = np.column_stack([generator.integers(0, 7, (20, 3)), generator.integers(0, 3, 20)])
    expected = np.zeros((20, 24), np.float32)
    for row, (left, current, right, state) in enumerate(labels):
        expected[row, [left, 7 + current, 14 + right, 21 + state]] = 1
    assert np.array_equal(one_hot(labels, 7), expected)


def test_a_phone_outside_the_inventory_is_named():
    with pytest.raises(DataError, match="zh"):
        label_indices(alignment(["zh"]), 3, 25.0, PHONES)


@pytest.mark.parametrize("change", [{"parent": 4}, {"parent": -1}, {"label": "4"}, {"label": "0"}])
def test_states_that_do_not_fit_their_phones_are_refused(change):
    spoken = alignment(["b"])
    with pytest.raises(DataError, match="do not fit"):
        states = tuple(replace(state, **change) for state in spoken.states)
        label_indices(replace(spoken, states=states), 3, 25.0, PHONES)
    with pytest.raises(DataError, match="do not fit"):
        label_indices(replace(spoken, states=()), 3, 25.0, PHONES)
    with pytest.raises(DataError, match="no phones"):
        label_indices(replace(spoken, phones=()), 3, 25.0, PHONES)
