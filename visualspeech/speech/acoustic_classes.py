"""The 57 acoustic classes of the 41 phone symbols: yes-no questions about the current phone.

Thangthai et al. (2016), section 4.1, take 57 questions from HTS and name two of them, voiced and nasalised. The classes
here are of the same sort: voicing, manner and place of articulation, height, backness, rounding and tenseness. They are
built on the classes that decision trees ask about (:mod:`visualspeech.speech.phone_classes`) where those agree with
phonetics; those of lips and jaw do not. Vowels with two targets belong to the height, backness and rounding of
the first.
"""

import numpy as np

from visualspeech.speech.phone_classes import PHONE_CLASSES
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.structure import SHORT_PAUSE, SYMBOLS

# Class -> the class of the same phones in PHONE_CLASSES.
_SHARED = {
    "vowel": "any_vowel",
    "unvoiced": "voiceless",
    "voiced_consonant": "voiced",
    "sonorant": "sonorant",
    "obstruent": "obstruent",
    "stop": "stop",
    "affricate": "affricate",
    "fricative": "fricative",
    "sibilant": "sibilant",
    "nasal": "nasal",
    "approximant": "glide",
    "bilabial": "bilabial",
    "labiodental": "labiodental",
    "dental": "dental",
    "alveolar": "alveolar",
    "postalveolar": "postalveolar",
    "velar": "velar",
    "coronal": "coronal",
    "diphthong": "diphthong",
}
_MORE = {
    "silence": f"{SILENCE} {SHORT_PAUSE}",
    "short_pause": SHORT_PAUSE,
    "consonant": "b ch d dh f g hh jh k l m n ng p r s sh t th v w y z zh",
    "voiced": "aa ae ah ao aw ay b d dh eh er ey g ih iy jh l m n ng ow oy r uh uw v w y z zh",
    "voiced_obstruent": "b d dh g jh v z zh",
    "sonorant_consonant": "l m n ng r w y",
    "continuant_consonant": "dh f hh l r s sh th v w y z zh",
    "noncontinuant_consonant": "b ch d g jh k m n ng p t",
    "voiced_stop": "b d g",
    "unvoiced_stop": "k p t",
    "voiced_fricative": "dh v z zh",
    "unvoiced_fricative": "f hh s sh th",
    "strident": "ch f jh s sh v z zh",
    "nonsibilant_fricative": "dh f hh th v",
    "liquid": "l r",
    "glide": "w y",
    "lateral": "l",
    "rhotic": "er r",
    "labial": "b f m p v w",
    "palatal": "y",
    "glottal": "hh",
    "dorsal": "g k ng w y",
    "anterior": "b d dh f l m n p r s t th v z",
    "labial_stop": "b p",
    "alveolar_stop": "d t",
    "velar_stop": "g k",
    "front_vowel": "ae eh ey ih iy",
    "central_vowel": "ah aw ay er",
    "back_vowel": "aa ao ow oy uh uw",
    "high_vowel": "ih iy uh uw",
    "mid_vowel": "ah ao eh er ey ow oy",
    "low_vowel": "aa ae aw ay",
    "rounded_vowel": "ao ow oy uh uw",
    "unrounded_vowel": "aa ae ah aw ay eh er ey ih iy",
    "fronting_diphthong": "ay ey oy",
    "tense_vowel": "aa ao aw ay er ey iy ow oy uw",
    "lax_vowel": "ae ah eh ih uh",
    "reduced_vowel": "ah er ih",  # without stress: "ax", "axr" and "ix" of the larger ARPAbet
}

#: Class -> symbols (of :data:`visualspeech.speech.structure.SYMBOLS`) of which the answer is yes.
ACOUSTIC_CLASSES: dict[str, frozenset[str]] = {
    **{name: PHONE_CLASSES[shared] for name, shared in _SHARED.items()},
    **{name: frozenset(members.split()) for name, members in _MORE.items()},
}


def acoustic_classes() -> np.ndarray:
    """Answers about each symbol, (41, 57) bool, in the order of ``SYMBOLS`` and of :data:`ACOUSTIC_CLASSES`."""
    return np.array([[symbol in members for members in ACOUSTIC_CLASSES.values()] for symbol in SYMBOLS])
