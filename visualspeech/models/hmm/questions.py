"""Phonetic questions that decision trees ask of a triphone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.speech.phones import CLASSES

POSITIONS = ("left", "current", "right")

# What the lips and the jaw tell apart beyond the classes of the phone set.
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


@dataclass(frozen=True)
class Questions:
    """Yes-no questions: is the phone at a position one of a set?

    Parameters
    ----------
    positions : (Q,) 0 left, 1 current, 2 right
    members : (Q, K) bool, the phones of the inventory for which the answer is yes
    names : (Q,) for people, such as ``right bilabial``
    """

    positions: np.ndarray
    members: np.ndarray
    names: tuple[str, ...]

    def answers(self, triphones: np.ndarray) -> np.ndarray:
        """(Q, M) bool of triphones (M, 3)."""
        return self.members[np.arange(len(self.positions))[:, None], triphones[:, self.positions].T]


def phone_sets(phones: Sequence[str]) -> dict[str, np.ndarray]:
    """Sets of an inventory by name, (K,) bool each: articulatory classes, and every phone by itself.

    A set that holds nothing, everything, or the same phones as one before is left out.
    """
    joined = {name: frozenset().union(*(CLASSES[part] for part in parts.split())) for name, parts in _JOINED.items()}
    more = {name: frozenset(members.split()) for name, members in _MORE.items()}
    result: dict[str, np.ndarray] = {}
    for name, members in {**CLASSES, **joined, **more, **{phone: {phone} for phone in phones}}.items():
        chosen = np.array([phone in members for phone in phones])
        seen = any(np.array_equal(chosen, other) for other in result.values())
        if chosen.any() and not chosen.all() and not seen:
            result[name] = chosen
    return result


def questions(phones: Sequence[str]) -> Questions:
    """Every set of an inventory, asked of every position of a triphone."""
    sets = phone_sets(phones)
    names = [f"{position} {name}" for position in POSITIONS for name in sets]
    members = np.tile(np.array(list(sets.values())).reshape(len(sets), len(phones)), (len(POSITIONS), 1))
    return Questions(np.repeat(np.arange(len(POSITIONS)), len(sets)), members, tuple(names))
