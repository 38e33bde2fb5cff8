"""Structure of utterances that anyone can count: syllables, words and phrases, and where each phone lies."""

from dataclasses import fields, replace

import numpy as np
import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import DataError
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.phones import PHONES
from visualspeech.speech.structure import SYMBOLS, Structure, structure_of, symbols_of
from visualspeech.speech.syllables import VOWELS

#: "extra computers | hmm": pauses of 0.3 s at the ends, 0.1 s within the phrase, 0.2 s between the phrases.
WORDS = (
    ("sil", ("sil 0.3",)),
    ("extra", "eh k s t r ah".split()),
    ("sil", ("sil 0.1",)),
    ("computers", "k ah m p y uw t er z".split()),
    ("sil", ("sil 0.2",)),
    ("hmm", "hh m".split()),
    ("sil", ("sil 0.3",)),
)
EXPECTED = {  # 0: pauses
    "phone_in_syllable": [0, 1, 2, 1, 2, 3, 4, 0, 1, 2, 3, 1, 2, 3, 1, 2, 3, 0, 1, 2, 0],
    "phones_in_syllable": [0, 2, 2, 4, 4, 4, 4, 0, 3, 3, 3, 3, 3, 3, 3, 3, 3, 0, 2, 2, 0],
    "syllable_in_word": [0, 1, 1, 2, 2, 2, 2, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 0, 1, 1, 0],
    "syllables_in_word": [0, *[2] * 6, 0, *[3] * 9, 0, 1, 1, 0],
    "syllable_in_phrase": [0, 1, 1, 2, 2, 2, 2, 0, 3, 3, 3, 4, 4, 4, 5, 5, 5, 0, 1, 1, 0],
    "syllables_in_phrase": [0, *[5] * 6, 0, *[5] * 9, 0, 1, 1, 0],
    "word_in_phrase": [0, *[1] * 6, 0, *[2] * 9, 0, 1, 1, 0],
    "words_in_phrase": [0, *[2] * 6, 0, *[2] * 9, 0, 1, 1, 0],
    "syllable_in_utterance": [0, 1, 1, 2, 2, 2, 2, 0, 3, 3, 3, 4, 4, 4, 5, 5, 5, 0, 6, 6, 0],
    "syllables_in_utterance": [0, *[6] * 6, 0, *[6] * 9, 0, 6, 6, 0],
    "word_in_utterance": [0, *[1] * 6, 0, *[2] * 9, 0, 3, 3, 0],
    "words_in_utterance": [0, *[3] * 6, 0, *[3] * 9, 0, 3, 3, 0],
    "phrase_in_utterance": [0, *[1] * 6, 0, *[1] * 9, 0, 2, 2, 0],
    "phrases_in_utterance": [0, *[2] * 6, 0, *[2] * 9, 0, 2, 2, 0],
}


def utterance(words=WORDS) -> Alignment:
    """Phones of 0.1 s, or of the seconds after their label; no states."""
    spoken, segments, time = [], [], 0.0
    for number, (word, phones) in enumerate(words):
        start = time
        for phone in phones:
            label, _, seconds = phone.partition(" ")
            segments.append(Segment(label, time, time + float(seconds or 0.1), number))
            time = segments[-1].end
        spoken.append(Segment(word, start, time))
    return Alignment(tuple(spoken), tuple(segments), ())


def test_every_phone_has_its_place_and_the_sizes_around_it():
    found = structure_of(utterance())
    assert [field.name for field in fields(Structure)] == list(EXPECTED)
    for name, expected in EXPECTED.items():
        assert getattr(found, name).tolist() == expected, name


def test_pauses_end_phrases_from_the_given_length_on():
    words = {limit: structure_of(utterance(), limit).word_in_phrase[[1, 8, 18]].tolist() for limit in (0.1, 0.2, 0.21)}
    assert words == {0.1: [1, 1, 1], 0.2: [1, 2, 1], 0.21: [1, 2, 3]}
    # Neighbouring pauses are one pause.
    parted = [*WORDS[:4], ("sil", ("sil 0.1", "sil 0.1")), *WORDS[5:]]
    assert structure_of(utterance(parted), 0.2).phrases_in_utterance.max() == 2


def test_short_pauses_inside_are_sp():
    assert len(SYMBOLS) == len(set(SYMBOLS)) == 41 and SYMBOLS[0] == "sil" and SYMBOLS[-1] == "sp"
    found = symbols_of(utterance(), 0.2)
    assert [found[at] for at in (0, 7, 17, 20)] == ["sil", "sp", "sil", "sil"]
    assert [one for one in found if one not in ("sil", "sp")] == [
        phone for word, phones in WORDS if word != "sil" for phone in phones
    ]
    assert symbols_of(utterance(), 0.4)[17] == "sp" and symbols_of(utterance(), 0.4)[0] == "sil"
    assert symbols_of(utterance((("sil", ("sil",)),)), 1) == ["sil"]


def test_only_pauses_have_no_structure():
    found = structure_of(utterance((("sil", ("sil",)),)))
    assert all(getattr(found, field.name).tolist() == [0] for field in fields(Structure))


def test_random_utterances_are_counted_as_slowly_by_hand(seed=3):
    random = np.random.default_rng(seed)
    for _ in range(50):
        words = []
        for _ in range(random.integers(1, 8)):
            if random.random() < 0.4:
                words.append(("sil", (f"sil {random.choice([0.1, 0.2, 0.4])}",)))
            words.append(("word", random.choice(PHONES[1:], random.integers(1, 9)).tolist()))
        alignment = utterance(words)
        found = structure_of(alignment, 0.2)
        spoken = np.array([one.label != "sil" for one in alignment.phones])
        for unit, whole in (("syllable", "word"), ("syllable", "phrase"), ("word", "phrase"), ("word", "utterance")):
            own = getattr(found, f"{unit}_in_utterance")
            around = np.ones_like(own) if whole == "utterance" else getattr(found, f"{whole}_in_utterance")
            for at in np.flatnonzero(spoken):
                inside = sorted(set(own[spoken & (around == around[at])]))
                assert getattr(found, f"{unit}s_in_{whole}")[at] == len(inside)
                assert getattr(found, f"{unit}_in_{whole}")[at] == inside.index(own[at]) + 1
        for name in EXPECTED:
            assert not getattr(found, name)[~spoken].any() and getattr(found, name)[spoken].min() >= 1
        # A syllable has one vowel, or is a whole word without one.
        for syllable in range(1, found.syllable_in_utterance.max() + 1):
            members = np.flatnonzero(found.syllable_in_utterance == syllable)
            vowels = sum(alignment.phones[at].label in VOWELS for at in members)
            assert vowels == 1 or (vowels == 0 and found.syllables_in_word[members[0]] == 1)
            assert found.phone_in_syllable[members].tolist() == list(range(1, len(members) + 1))
            assert len({alignment.phones[at].parent for at in members}) == 1


def test_a_word_without_a_vowel_is_one_syllable():
    found = structure_of(even_alignment([("hmm", ["hh", "m"])]))
    assert found.syllables_in_word.tolist() == [1, 1] and found.phone_in_syllable.tolist() == [1, 2]


@pytest.mark.parametrize("read", [structure_of, symbols_of])
def test_unknown_phones_and_empty_alignments_are_named(read):
    with pytest.raises(DataError, match="the phone 'xx' of the alignment is not one of the 40 symbols"):
        read(even_alignment([("word", ["s", "xx"])]))
    with pytest.raises(DataError, match="the alignment has no phones"):
        read(replace(even_alignment([("word", ["s"])]), phones=()))
