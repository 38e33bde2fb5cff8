from dataclasses import replace

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError
from visualspeech.features.labels import label_indices, label_shares, mean_over_frames, one_hot

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


def uneven(seed=0, count=12):
    """An utterance whose phones and states last from a hundredth of a frame to several frames."""
    generator = np.random.default_rng(seed)
    spoken = alignment(["sil", *generator.choice(["b", "ah", "t"], count), "sil"])
    starts = np.r_[0, np.cumsum(10 ** generator.uniform(-3.4, -0.9, 3 * len(spoken.phones)))]
    states = tuple(replace(one, start=starts[n], end=starts[n + 1]) for n, one in enumerate(spoken.states))
    phones = tuple(replace(one, start=starts[3 * n], end=starts[3 * n + 3]) for n, one in enumerate(spoken.phones))
    return replace(spoken, phones=phones, states=states)


@pytest.mark.parametrize("states", ["aligned", "thirds"])
def test_shares_against_fine_sampling(states):
    spoken, fine = uneven(), 4000
    frames = int(spoken.phones[-1].end * 25) + 3
    found = label_shares(spoken, frames, 25.0, PHONES, states)
    sampled = one_hot(label_indices(spoken, frames * fine, 25.0 * fine, PHONES, states), len(PHONES))
    # A border may fall between two samples: at most one of them a border.
    assert np.abs(found - sampled.reshape(frames, fine, -1).mean(axis=1)).max() < 12 / fine
    assert np.abs(found.max(axis=1) - 1).max() > 0.3


def test_shares_of_each_part_add_up_to_one():
    found = label_shares(uneven(1), 40, 25.0, PHONES)
    assert found.shape == (40, 15) and found.dtype == np.float32 and found.min() >= 0
    for part in np.split(found, [4, 8, 12], axis=1):
        assert np.allclose(part.sum(axis=1), 1, atol=1e-6)


def test_shares_of_a_frame_in_one_state_are_its_label():
    spoken = alignment(["b", "t"])
    frames = 12  # beyond the end the last state goes on
    labels = label_indices(spoken, frames, 25.0, PHONES)
    assert np.allclose(label_shares(spoken, frames, 25.0, PHONES), one_hot(labels, len(PHONES)), atol=1e-6)
    # At a high rate nearly every frame lies in one state.
    labels = one_hot(label_indices(uneven(2), 4000, 5000.0, PHONES), len(PHONES))
    assert (np.abs(label_shares(uneven(2), 4000, 5000.0, PHONES) - labels).max(axis=1) > 1e-3).mean() < 0.02


def test_states_of_evenly_divided_phones():
    spoken = uneven(3)
    found = label_indices(spoken, 400, 1000.0, PHONES, "thirds")
    for frame, label in enumerate(found):
        time = (frame + 0.5) / 1000.0
        phone = next((one for one in spoken.phones if one.start <= time < one.end), None)
        if phone:
            assert label[3] == min(int(3 * (time - phone.start) / (phone.end - phone.start)), 2)
            assert PHONES[label[1]] == phone.label
    # Evenly aligned states are those of the thirds.
    even = alignment(["b", "t", "ah"], 0.1)
    assert np.array_equal(*(label_indices(even, 9, 29.0, PHONES, states) for states in ("aligned", "thirds")))


def test_means_over_frames_keep_the_integral():
    generator = np.random.default_rng(4)
    values, starts = generator.normal(size=(30, 2)), np.r_[0, np.sort(generator.uniform(0, 1, 29))]
    lasting = np.diff(np.r_[starts, 1.2])
    found = mean_over_frames(values, starts, 30, 25.0)
    assert np.allclose(found.sum(axis=0) / 25.0, lasting @ values, atol=1e-5)
