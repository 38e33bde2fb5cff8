"""Pronunciations: listed, of one's own, and guessed."""

import pytest

from visualspeech.errors import StorageError
from visualspeech.speech.lexicon import Lexicon
from visualspeech.speech.phones import PHONES


def test_listed_words_with_all_their_pronunciations():
    assert Lexicon().pronunciations("blue") == (("b", "l", "uw"),)
    assert set(Lexicon().pronunciations("a")) == {("ah",), ("ey",)}
    assert Lexicon().pronunciations("frobnicator") == ()


def test_own_pronunciations_come_first():
    lexicon = Lexicon(own={"z": [("z", "eh", "d")], "quux": [("k", "w", "ah", "k", "s")]})
    assert lexicon.pronunciations("z") == (("z", "eh", "d"),)
    assert lexicon.unknown_words("z quux frobnicator, frobnicator") == ["frobnicator"]


def test_unknown_words_are_guessed_by_letter_to_sound():
    guessed = Lexicon().guess(["frobnicator", "quux"])
    assert guessed["frobnicator"] == (("f", "r", "aa", "b", "n", "ih", "k", "ey", "t", "er"),)
    assert all(phone in PHONES for phone in guessed["quux"][0])


def test_possessives_follow_their_stem():
    def not_asked(words):
        raise AssertionError(words)

    lexicon = Lexicon(letters_to_sounds=not_asked, own={"quux": [("k", "w", "ah", "k", "s")], "frob": [("b", "p")]})
    assert lexicon.guess(["quux's", "frob's", "frob's"]) == {
        "quux's": (("k", "w", "ah", "k", "s", "ih", "z"),),
        "frob's": (("b", "p", "s"),),
    }


def test_what_cannot_be_spoken_has_no_pronunciation():
    assert Lexicon(letters_to_sounds=lambda words: dict.fromkeys(words, ["sil", "?"])).guess(["x"]) == {"x": ()}


def test_a_missing_dictionary_is_a_sentence(tmp_path):
    with pytest.raises(StorageError, match="cannot read the dictionary"):
        Lexicon(tmp_path / "none.dict")
