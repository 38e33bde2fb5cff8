"""Phones with their neighbours."""

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError
from visualspeech.features.contexts import phone_contexts, phone_inventory
from visualspeech.speech.alignment import Alignment

PHONES = ["sil", "ah", "b", "t"]
ALIGNMENT = even_alignment([("sil", ["sil"]), ("but", ["b", "ah", "t"]), ("a", ["ah"])])


def test_inventory_has_silence_first_and_the_rest_sorted():
    assert phone_inventory([even_alignment([("x", ["t", "ah"])]), ALIGNMENT]) == PHONES
    assert phone_inventory(iter([even_alignment([("x", ["b"])])])) == ["sil", "b"]
    assert phone_inventory([]) == ["sil"]


def test_triphones_cross_words_and_see_silence_beyond_the_ends():
    assert phone_contexts(ALIGNMENT, PHONES).tolist() == [[0, 0, 2], [0, 2, 1], [2, 1, 3], [1, 3, 1], [3, 1, 0]]


@pytest.mark.parametrize(("before", "after"), [(0, 0), (2, 2), (1, 3), (9, 0)])
def test_contexts_of_any_width_against_a_loop(before, after):
    found = phone_contexts(ALIGNMENT, PHONES, before, after)
    labels = [phone.label for phone in ALIGNMENT.phones]
    for row, context in enumerate(found):
        around = [labels[at] if 0 <= at < len(labels) else "sil" for at in range(row - before, row + after + 1)]
        assert [PHONES[phone] for phone in context] == around
    assert found.shape == (5, before + 1 + after) and np.issubdtype(found.dtype, np.integer)


def test_phones_outside_the_inventory_are_named():
    with pytest.raises(DataError, match="3 phones does not have ah, b"):
        phone_contexts(ALIGNMENT, ["sil", "t", "zh"])
    with pytest.raises(DataError, match="does not have sil"):
        phone_contexts(ALIGNMENT, PHONES[1:])
    with pytest.raises(DataError, match="no phones"):
        phone_contexts(Alignment((), (), ()), PHONES)
