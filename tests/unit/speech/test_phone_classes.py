"""Articulatory classes: what phonetics says of them, and the table of members."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.speech.phone_classes import PHONE_CLASSES, class_members
from visualspeech.speech.phones import CLASSES, PHONES


def test_members_are_phones_and_those_of_the_phone_set():
    assert all(members and members <= set(PHONES) for members in PHONE_CLASSES.values())
    assert all(PHONE_CLASSES[name] == members for name, members in CLASSES.items())


def test_every_consonant_is_voiced_or_voiceless_and_every_vowel_is_in_one_class():
    vowels = PHONE_CLASSES["any_vowel"]
    consonants = set(PHONES) - vowels - {"sil"}
    assert PHONE_CLASSES["voiced"] | PHONE_CLASSES["voiceless"] == consonants
    assert not PHONE_CLASSES["voiced"] & PHONE_CLASSES["voiceless"]
    assert vowels == CLASSES["vowel"] | CLASSES["diphthong"]
    assert PHONE_CLASSES["labial"] == {"p", "b", "m", "f", "v"}


def test_classes_tell_all_phones_apart_but_two():
    members = class_members()
    assert members.shape == (len(PHONES), len(PHONE_CLASSES))
    _, number = np.unique(members, axis=0, return_inverse=True)
    alike = {tuple(phone for phone, own in zip(PHONES, number, strict=True) if own == one) for one in set(number)}
    assert {group for group in alike if len(group) > 1} == {("ih", "iy")}


def test_the_table_against_the_sets():
    chosen = ("m", "sil", "uw")
    for phone, row in zip(chosen, class_members(chosen), strict=True):
        named = {name for name, member in zip(PHONE_CLASSES, row, strict=True) if member}
        assert named == {name for name, members in PHONE_CLASSES.items() if phone in members}
    with pytest.raises(DataError, match="classes of x1, x2 are not known"):
        class_members(("m", "x1", "x2"))
