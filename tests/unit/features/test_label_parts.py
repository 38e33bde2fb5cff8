"""Label parts: of a sentence labelled by hand, and at the frames of the labels."""

from dataclasses import replace

import numpy as np
import pytest
from visualspeech.models.blstm import StackSettings

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError, SettingError
from visualspeech.features.label_parts import PARTS, full_labels, label_parts, part_sizes
from visualspeech.features.labels import label_indices
<<<<<<< HEAD
from visualspeech.models.network import Network
from visualspeech.models.training import TrainingSettings, train
=======
>>>>>>> tests

WORDS = [("sil", ["sil"]), ("computer", "k ah m p y uw t er".split()), ("a", ["ah"]), ("sil", ["sil"])]


def alignment(step=0.1):
    return even_alignment(WORDS, step)


def test_a_sentence_by_hand():
    found = label_parts(alignment(), 11, 10.0, list(PARTS))
    names = [[PARTS[part][value] for part, value in zip(PARTS, row, strict=True)] for row in found]
    syllable, word, stress = (list(column) for column in zip(*names, strict=True))
    onsets = "onset nucleus coda onset onset nucleus onset nucleus".split()
    assert syllable == ["pause", *onsets, "nucleus", "pause"]
    assert word == ["pause", "first", *["inside"] * 6, "last", "only", "pause"]
    assert stress[:9] == ["pause", *["none"] * 3, *["primary"] * 3, *["none"] * 2] and stress[-1] == "pause"


def test_parts_change_where_the_phones_do():
    spoken, frames, rate = alignment(0.07), 25, 30.0
    given = {"computer": [0, 2, 0], "a": [2]}
    parts = label_parts(spoken, frames, rate, ["stress", "position_in_word"], given)
    for frame in range(frames):
        time = min((frame + 0.5) / rate, spoken.duration - 1e-9)
        number = max(at for at, phone in enumerate(spoken.phones) if phone.start <= time + 1e-12)
        assert (parts[frame, 1] == 1) == (number == 1)
        assert (parts[frame, 0] == 0) == (spoken.phones[number].label == "sil")
    phones = ["sil", *sorted({phone for _, spoken in WORDS for phone in spoken} - {"sil"})]
    joined = full_labels(spoken, frames, rate, phones, ["stress"])
    np.testing.assert_array_equal(joined[:, :4], label_indices(spoken, frames, rate, phones))
    assert joined.shape == (frames, 5) and joined.dtype == np.int16
    assert full_labels(spoken, frames, rate, phones, []).shape == (frames, 4)


def test_mistakes_are_named():
    with pytest.raises(SettingError, match="tone` is unknown.*stress"):
        part_sizes(["tone"])
    spoken = alignment()
    phones = tuple(replace(phone, parent=9) for phone in spoken.phones)
    with pytest.raises(DataError, match="align again"):
        label_parts(replace(spoken, phones=phones), 5, 25.0, ["stress"], {})
<<<<<<< HEAD


def rich_utterances(number, seed):
    """What a part says is half of the face, and the phones say nothing of it."""
    generator = np.random.default_rng(seed)
    result = []
    for labels, values in utterances(number, seed):
        part = generator.integers(0, 4, len(labels)).astype(np.int16)
        shift = 20 * np.stack([np.sin(part), np.cos(part), part, -part], axis=1)
        result.append((np.column_stack([labels, part]), (values + shift).astype(np.float32)))
    return result


def test_a_network_learns_from_parts_and_keeps_them(tmp_path):
    settings = TrainingSettings(max_epochs=30, dropout=0.0, averaging=0.0, learning_rate=0.02, seed=1)
    training, validation = rich_utterances(24, 1), rich_utterances(6, 2)
    rich = train(StackSettings("F", 16), PHONES, training, validation, 25.0, settings, parts=("stress",))
    plain = [[(labels[:, :4], values) for labels, values in part] for part in (training, validation)]
    poor = train(StackSettings("F", 16), PHONES, *plain, 25.0, settings)
    assert min(row[2] for row in rich.curve) < 0.5 * min(row[2] for row in poor.curve)
    rich.network.save(tmp_path / "rich.safetensors")
    again = Network.load(tmp_path / "rich.safetensors")
    assert again.parts == ("stress",)
    labels = validation[0][0]
    np.testing.assert_array_equal(again.predict(labels), rich.network.predict(labels))
    with pytest.raises(DataError, match="5 indices"):
        again.predict(labels[:, :4])
    with pytest.raises(DataError, match="four indices"):
        poor.network.predict(labels)
    with pytest.raises(DataError, match="parts of other kinds"):
        again.predict(labels + np.array([0, 0, 0, 0, 4], np.int16))


def test_one_hot_blocks_lie_beside_each_other():
    import torch
    from visualspeech.models.blstm import Stack

    from visualspeech.features.labels import one_hot

    labels, _ = rich_utterances(1, 3)[0]
    stack = Stack(StackSettings("F", 4), len(PHONES), 2, parts=(4,))
    found = stack.encode(torch.tensor(labels.astype(np.int64))).numpy()
    np.testing.assert_array_equal(found[:, :-4], one_hot(labels[:, :4], len(PHONES)))
    np.testing.assert_array_equal(found[:, -4:], np.eye(4)[labels[:, 4]])
=======
>>>>>>> tests
