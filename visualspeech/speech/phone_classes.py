"""All articulatory classes of phones: place, manner, voicing, height, rounding, and unions of them.

Decision trees ask about them, and the input block ``phone_classes`` gives them to a network. Classes may overlap, and
two may hold the same phones of a small inventory.
"""

from collections.abc import Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech.phones import CLASSES, PHONES

# Classes that differ in the lips and the jaw, beside those of the phone set.
_JOINED = {
    "consonant": "stop affricate fricative nasal",
    "sonorant": "vowel diphthong glide nasal",
    "obstruent": "stop affricate fricative",
    "labial": "bilabial labiodental",
    "coronal": "dental alveolar postalveolar",
    "any_vowel": "vowel diphthong",
}
_MORE = {
    "front": "ae eh ey ih iy",
    "back": "aa ao ow oy uh uw",
    "high": "ih iy uh uw y",
    "mid": "ah eh er ey ow",
    "low": "aa ae ao aw ay",
    "spread": "ey ih iy y s z",
    "voiced": "b d dh g jh l m n ng r v w y z zh",
    "voiceless": "ch f hh k p s sh t th",
    "sibilant": "ch jh s sh z zh",
    "rounding_end": "aw ow uw w",
}

#: Class name -> phones.
PHONE_CLASSES: dict[str, frozenset[str]] = {
    **CLASSES,
    **{name: frozenset().union(*(CLASSES[part] for part in parts.split())) for name, parts in _JOINED.items()},
    **{name: frozenset(members.split()) for name, members in _MORE.items()},
}


def class_members(phones: Sequence[str] = PHONES) -> np.ndarray:
    """Classes of each phone: (K, number of classes) bool, columns in the order of :data:`PHONE_CLASSES`.

    Raises
    ------
    DataError
        A phone is in no class.
    """
    found = np.array([[phone in members for members in PHONE_CLASSES.values()] for phone in phones])
    unknown = [phone for phone, classes in zip(phones, found, strict=True) if not classes.any()]
    if unknown:
        raise DataError(f"the articulatory classes of {', '.join(unknown)} are not known. Known: {', '.join(PHONES)}.")
    return found
