"""Label parts: of a sentence labelled by hand, and at the frames of the labels."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError, SettingError
from visualspeech.features.label_parts import PARTS, full_labels, label_parts, part_sizes
from visualspeech.features.labels import label_indices

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
