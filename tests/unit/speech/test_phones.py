"""The phone set: what the acoustic model knows, shared out among the manners of articulation."""

import pytest

from visualspeech.speech.lexicon import Lexicon
from visualspeech.speech.phones import CLASSES, PHONES, manner


def test_the_set_is_the_dictionary_s():
    lexicon = Lexicon()
    words = "zoo yes boy her judge chew thing this vision hawed hood ale bag map vow few row walk she tea lie cup head"
    found = {phone for word in words.split() for one in lexicon.pronunciations(word) for phone in one}
    assert found == set(PHONES) - {"sil"}
    assert PHONES[0] == "sil"
    assert list(PHONES[1:]) == sorted(PHONES[1:])
    assert len(PHONES) == 40


def test_each_phone_has_one_manner():
    manners = ("vowel", "diphthong", "glide", "nasal", "stop", "affricate", "fricative", "pause")
    assert sorted(phone for name in manners for phone in CLASSES[name]) == sorted(PHONES)
    assert manner("p") == "stop"
    assert manner("sil") == "pause"
    with pytest.raises(KeyError):
        manner("x")


def test_lips_close_on_bilabials():
    assert CLASSES["bilabial"] == {"p", "b", "m"}
