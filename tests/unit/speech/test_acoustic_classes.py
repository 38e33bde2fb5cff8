"""Every acoustic class against a description of each phone as a phonetician gives it, from which rules derive it."""

from types import SimpleNamespace

import numpy as np
import pytest

from visualspeech.speech.acoustic_classes import ACOUSTIC_CLASSES, acoustic_classes
from visualspeech.speech.structure import SYMBOLS

#: voicing, place, manner, as in the IPA's chart of consonants
CONSONANTS = """
p voiceless bilabial stop
b voiced bilabial stop
t voiceless alveolar stop
d voiced alveolar stop
k voiceless velar stop
g voiced velar stop
ch voiceless postalveolar affricate
jh voiced postalveolar affricate
f voiceless labiodental fricative
v voiced labiodental fricative
th voiceless dental fricative
dh voiced dental fricative
s voiceless alveolar fricative
z voiced alveolar fricative
sh voiceless postalveolar fricative
zh voiced postalveolar fricative
hh voiceless glottal fricative
m voiced bilabial nasal
n voiced alveolar nasal
ng voiced velar nasal
l voiced alveolar lateral-approximant
r voiced alveolar rhotic-approximant
w voiced labial-velar semivowel
y voiced palatal semivowel
"""
#: height and backness of each target, rounding of the first, tense or lax: "bead", "bid", "bayed", "bed" ...
VOWELS = """
iy high-front unrounded tense
ih high-front unrounded lax reducible
ey mid-front>high-front unrounded tense
eh mid-front unrounded lax
ae low-front unrounded lax
ah mid-central unrounded lax reducible
er mid-central unrounded tense reducible rhotic
ay low-central>high-front unrounded tense
aw low-central>high-back unrounded tense
aa low-back unrounded tense
ao mid-back rounded tense
oy mid-back>high-front rounded tense
ow mid-back>high-back rounded tense
uh high-back rounded lax
uw high-back rounded tense
"""


def described():
    found = {"sil": SimpleNamespace(sort="silence"), "sp": SimpleNamespace(sort="silence")}
    for line in CONSONANTS.strip().splitlines():
        phone, voicing, place, manner = line.split()
        found[phone] = SimpleNamespace(sort="consonant", voiced=voicing == "voiced", place=place, manner=manner)
    for line in VOWELS.strip().splitlines():
        phone, targets, rounding, tension, *more = line.split()
        first, *glide = (target.split("-") for target in targets.split(">"))
        found[phone] = SimpleNamespace(
            sort="vowel",
            voiced=True,
            height=first[0],
            backness=first[1],
            glide=glide[0] if glide else None,
            rounded=rounding == "rounded",
            tense=tension == "tense",
            reducible="reducible" in more,
            rhotic="rhotic" in more,
        )
    return found


PHONES = described()
NARROW, NASAL = ("stop", "affricate", "fricative"), ("stop", "affricate", "nasal")
APPROXIMANTS = ("lateral-approximant", "rhotic-approximant", "semivowel")
SIBILANT_PLACES = ("alveolar", "postalveolar")


def vowel(rule):
    return lambda name, one: one.sort == "vowel" and rule(one)


def consonant(rule):
    return lambda name, one: one.sort == "consonant" and rule(one)


def sibilant(one):
    return one.manner in ("fricative", "affricate") and one.place in SIBILANT_PLACES


RULES = {
    "vowel": vowel(lambda one: True),
    "consonant": consonant(lambda one: True),
    "silence": lambda name, one: one.sort == "silence",
    "short_pause": lambda name, one: name == "sp",
    "voiced": lambda name, one: one.sort != "silence" and one.voiced,
    "unvoiced": lambda name, one: one.sort != "silence" and not one.voiced,
    "voiced_consonant": consonant(lambda one: one.voiced),
    "sonorant": lambda name, one: one.sort == "vowel" or (one.sort == "consonant" and one.manner not in NARROW),
    "obstruent": consonant(lambda one: one.manner in NARROW),
    "voiced_obstruent": consonant(lambda one: one.manner in NARROW and one.voiced),
    "sonorant_consonant": consonant(lambda one: one.manner not in NARROW),
    "continuant_consonant": consonant(lambda one: one.manner not in NASAL),
    "noncontinuant_consonant": consonant(lambda one: one.manner in NASAL),
    "stop": consonant(lambda one: one.manner == "stop"),
    "voiced_stop": consonant(lambda one: one.manner == "stop" and one.voiced),
    "unvoiced_stop": consonant(lambda one: one.manner == "stop" and not one.voiced),
    "affricate": consonant(lambda one: one.manner == "affricate"),
    "fricative": consonant(lambda one: one.manner == "fricative"),
    "voiced_fricative": consonant(lambda one: one.manner == "fricative" and one.voiced),
    "unvoiced_fricative": consonant(lambda one: one.manner == "fricative" and not one.voiced),
    "sibilant": consonant(sibilant),
    "strident": consonant(lambda one: sibilant(one) or one.place == "labiodental"),
    "nonsibilant_fricative": consonant(lambda one: one.manner == "fricative" and not sibilant(one)),
    "nasal": consonant(lambda one: one.manner == "nasal"),
    "approximant": consonant(lambda one: one.manner in APPROXIMANTS),
    "liquid": consonant(lambda one: one.manner in APPROXIMANTS[:2]),
    "glide": consonant(lambda one: one.manner == "semivowel"),
    "lateral": consonant(lambda one: one.manner.startswith("lateral")),
    "rhotic": lambda name, one: (
        (one.sort == "vowel" and one.rhotic) or (one.sort == "consonant" and one.manner.startswith("rhotic"))
    ),
    "labial": consonant(lambda one: "labi" in one.place),
    "bilabial": consonant(lambda one: one.place == "bilabial"),
    "labiodental": consonant(lambda one: one.place == "labiodental"),
    "dental": consonant(lambda one: one.place == "dental"),
    "alveolar": consonant(lambda one: one.place == "alveolar"),
    "postalveolar": consonant(lambda one: one.place == "postalveolar"),
    "palatal": consonant(lambda one: one.place == "palatal"),
    "velar": consonant(lambda one: one.place == "velar"),
    "glottal": consonant(lambda one: one.place == "glottal"),
    "coronal": consonant(lambda one: one.place in ("dental", "alveolar", "postalveolar")),
    "dorsal": consonant(lambda one: one.place in ("palatal", "velar", "labial-velar")),
    "anterior": consonant(lambda one: one.place in ("bilabial", "labiodental", "dental", "alveolar")),
    "labial_stop": consonant(lambda one: one.manner == "stop" and one.place == "bilabial"),
    "alveolar_stop": consonant(lambda one: one.manner == "stop" and one.place == "alveolar"),
    "velar_stop": consonant(lambda one: one.manner == "stop" and one.place == "velar"),
    "front_vowel": vowel(lambda one: one.backness == "front"),
    "central_vowel": vowel(lambda one: one.backness == "central"),
    "back_vowel": vowel(lambda one: one.backness == "back"),
    "high_vowel": vowel(lambda one: one.height == "high"),
    "mid_vowel": vowel(lambda one: one.height == "mid"),
    "low_vowel": vowel(lambda one: one.height == "low"),
    "rounded_vowel": vowel(lambda one: one.rounded),
    "unrounded_vowel": vowel(lambda one: not one.rounded),
    "diphthong": vowel(lambda one: one.glide is not None),
    "fronting_diphthong": vowel(lambda one: one.glide is not None and one.glide[1] == "front"),
    "tense_vowel": vowel(lambda one: one.tense),
    "lax_vowel": vowel(lambda one: not one.tense),
    "reduced_vowel": vowel(lambda one: one.reducible),
}


def test_the_descriptions_are_of_all_symbols():
    assert set(PHONES) == set(SYMBOLS) and len(SYMBOLS) == 41
    assert len(ACOUSTIC_CLASSES) == 57 and set(RULES) == set(ACOUSTIC_CLASSES)


@pytest.mark.parametrize("name", RULES)
def test_each_class_splits_the_phones_as_its_name_says(name):
    assert ACOUSTIC_CLASSES[name] == {phone for phone, one in PHONES.items() if RULES[name](phone, one)}


def test_no_two_classes_hold_the_same_phones_and_no_two_phones_the_same_classes():
    answers = acoustic_classes()
    assert answers.shape == (41, 57)
    assert len(np.unique(answers, axis=0)) == 41 and len(np.unique(answers, axis=1).T) == 57
    assert answers.any(axis=0).all() and not answers.all(axis=0).any()
    for number, symbol in enumerate(SYMBOLS):
        named = {name for name, answer in zip(ACOUSTIC_CLASSES, answers[number], strict=True) if answer}
        assert named == {name for name, members in ACOUSTIC_CLASSES.items() if symbol in members}
