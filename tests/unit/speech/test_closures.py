"""Closures of alignments in other phone sets: the label says which phone it is."""

import numpy as np

from tests.unit.speech.alignments import spoken
from visualspeech.speech.closures import closing_frames, greatest_openings, least_openings

OPENING = np.array([5.0, 1.0, 5.0, 2.0, 9.0, 3.0, 5.0, 5.0])  # at 10 Hz


def test_closures_and_open_vowels_of_ipa_are_those_of_arpabet():
    seconds = (0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.2)
    arpabet = spoken(*zip(("sil", "p", "iy", "m", "aa", "f", "sil"), seconds, strict=True))
    ipa = spoken(*zip(("sil", "pʰ", "iː", "m̩", "ɑː", "fʲ", "sil"), seconds, strict=True))
    for one in (arpabet, ipa):
        assert least_openings(OPENING, one, 10, "bilabial").tolist() == [1.0, 2.0]
        assert least_openings(OPENING, one, 10, "labiodental").tolist() == [3.0]
        assert closing_frames(OPENING, one, 10).tolist() == [1, 3, 5] and greatest_openings(OPENING, one, 10) == [9.0]


def test_labels_that_stand_for_nothing_close_no_lips():
    other = spoken(("sil", 0.1), ("4", 0.3), ("%", 0.4))
    assert not len(closing_frames(OPENING, other, 10))
