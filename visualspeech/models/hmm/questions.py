"""Phonetic questions that decision trees ask about a phone and its neighbours."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.speech.phone_classes import PHONE_CLASSES


@dataclass(frozen=True)
class Questions:
    """Yes-no questions: is the phone in a column of the context a member of a set?

    Parameters
    ----------
    positions : (Q,) column of the context
    members : (Q, K) bool, phones of the inventory for which the answer is yes
    names : (Q,) names such as ``right bilabial``, for people
    """

    positions: np.ndarray
    members: np.ndarray
    names: tuple[str, ...]

    def answers(self, contexts: np.ndarray) -> np.ndarray:
        """(Q, M) bool for contexts (M, C)."""
        return self.members[np.arange(len(self.positions))[:, None], contexts[:, self.positions].T]


def position_names(columns: int, centre: int) -> list[str]:
    """Names of the columns of a context: ..., "left 2", "left", "current", "right", "right 2", ...

    Parameters
    ----------
    columns : number of columns
    centre : column of the phone itself
    """
    names = []
    for offset in range(-centre, columns - centre):
        distance = f" {abs(offset)}" if abs(offset) > 1 else ""
        names.append("current" if offset == 0 else f"{'left' if offset < 0 else 'right'}{distance}")
    return names


def phone_sets(phones: Sequence[str]) -> dict[str, np.ndarray]:
    """Sets of phones of an inventory by name, (K,) bool each: articulatory classes, and every phone by itself.

    A set with no phone, with all phones, or with the phones of an earlier set is left out.
    """
    result: dict[str, np.ndarray] = {}
    for name, members in {**PHONE_CLASSES, **{phone: {phone} for phone in phones}}.items():
        chosen = np.array([phone in members for phone in phones])
        seen = any(np.array_equal(chosen, other) for other in result.values())
        if chosen.any() and not chosen.all() and not seen:
            result[name] = chosen
    return result


def questions(phones: Sequence[str], columns: int = 3, centre: int = 1) -> Questions:
    """Questions about every set of an inventory in every column of a context; the defaults are those of triphones.

    Parameters
    ----------
    phones : inventory, K entries
    columns, centre : layout of the contexts, see :func:`position_names`
    """
    sets = phone_sets(phones)
    names = [f"{position} {name}" for position in position_names(columns, centre) for name in sets]
    members = np.tile(np.array(list(sets.values())).reshape(len(sets), len(phones)), (columns, 1))
    return Questions(np.repeat(np.arange(columns), len(sets)), members, tuple(names))
