"""Syllables and stress of words that anyone can divide."""

import pytest

from visualspeech.speech import tts
from visualspeech.speech.syllables import stress_of_syllables, syllables


@pytest.mark.parametrize(
    ("word", "divided"),
    [
        ("k ah m p y uw t er", "k ah m|p y uw|t er"),
        ("eh k s t r ah", "eh k|s t r ah"),
        ("s ih ng er", "s ih ng|er"),
        ("ih n s t r ah k sh ah n", "ih n|s t r ah k|sh ah n"),
        ("p l ey s", "p l ey s"),
        ("ae t l ah s", "ae t|l ah s"),
        ("ay ow", "ay|ow"),
        ("m", "m"),
        ("", ""),
    ],
)
def test_consonants_begin_a_syllable_as_far_as_they_can(word, divided):
    phones = word.split()
    assert "|".join(" ".join(phones[i] for i in one) for one in syllables(phones)) == divided


def test_every_phone_is_in_one_syllable():
    phones = "ih n t er n ae sh ah n ah l".split()
    assert [i for one in syllables(phones) for i in one] == list(range(len(phones)))


def test_stress_is_that_of_the_spelling():
    found = tts.stresses(["computer", "photograph", "the", "now", "understand", "zero", "computer"])
    assert found["computer"] == [0, 2, 0] and found["photograph"] == [2, 0, 1] and found["understand"][-1] == 2
    assert found["the"] == [0] and found["now"] == [2] and found["zero"][0] == 2
    assert tts.stresses([]) == {}


def test_marks_do_not_change_what_is_pronounced():
    words = ["computer", "understand", "zero"]
    assert tts.letters_to_sounds(words)["computer"] == "k ah m p y uw t er".split()


def test_stress_comes_to_a_pronunciation_of_another_length():
    assert stress_of_syllables("z iy r ow".split(), [2, 0, 0]) == [2, 0]
    assert stress_of_syllables("f ay r".split(), [2, 0]) == [2]
    assert stress_of_syllables("k ah m p y uw t er".split(), [0, 2, 0]) == [0, 2, 0]
    assert stress_of_syllables("b l uw".split(), []) == [0]
