import numpy as np
import pandas
import pytest

from visualspeech.errors import DataError
from visualspeech.features.labels import label_indices, one_hot, phone_inventory

PHONES = ["sil", "ah", "b", "t"]


def alignment(phones, length=0.12):
    """Phones of equal length with three equal states each."""
    rows = []
    for number, phone in enumerate(phones):
        start = number * length
        rows.append(("phone", number, 0, phone, start, start + length))
        for state in range(3):
            begin = start + state * length / 3
            rows.append(("state", 3 * number + state, number, str(state + 1), begin, begin + length / 3))
    return pandas.DataFrame(rows, columns=["tier", "index", "parent", "label", "start", "end"])


def test_inventory_has_silence_first_and_the_rest_sorted():
    tables = [alignment(["t", "ah"]), alignment(["sil", "b", "ah"])]
    assert phone_inventory(tables) == PHONES
    assert phone_inventory([alignment(["b"])]) == ["sil", "b"]


def test_labels_of_frames_against_a_walk_through_the_states():
    rows = alignment(["sil", "b", "ah", "t", "sil"])
    labels = label_indices(rows, 15, 25.0, PHONES)
    spoken = rows[rows["tier"] == "phone"]["label"].tolist()
    for frame, label in enumerate(labels):
        time = (frame + 0.5) / 25.0
        state = next(row for row in rows[rows["tier"] == "state"].itertuples() if row.start <= time < row.end)
        around = ["sil", *spoken, "sil"][state.parent : state.parent + 3]
        assert label.tolist() == [*(PHONES.index(phone) for phone in around), int(state.label) - 1]
    assert labels.dtype == np.int16


def test_the_order_of_rows_does_not_matter_and_frames_beyond_the_end_keep_the_last_state():
    rows = alignment(["b", "t"])
    labels = label_indices(rows, 10, 25.0, PHONES)
    assert np.array_equal(labels, label_indices(rows.sample(frac=1, random_state=1), 10, 25.0, PHONES))
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


def test_states_without_a_phone_are_refused():
    rows = alignment(["b"])
    rows.loc[rows["tier"] == "state", "parent"] = 4
    with pytest.raises(DataError, match="do not fit"):
        label_indices(rows, 3, 25.0, PHONES)
    with pytest.raises(DataError, match="no phones or no states"):
        label_indices(rows[rows["tier"] == "phone"], 3, 25.0, PHONES)
