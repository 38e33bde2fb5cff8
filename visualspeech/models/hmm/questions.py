"""Questions that decision trees ask about a phone, its neighbours, and its place in the utterance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.models.hmm.segments import Factor
from visualspeech.speech.phone_classes import PHONE_CLASSES
from visualspeech.speech.phone_sets import arpabet_of


@dataclass(frozen=True)
class Questions:
    """Yes-no questions: is the phone, or the number, in a column of the context a member of a set?

    Parameters
    ----------
    positions : (Q,) column of the context
    members : (Q, V) bool, phones of the inventory, or numbers, for which the answer is yes; V is the largest number of
        values of a column
    names : (Q,) names such as ``right bilabial`` or ``syllables in word at most 2``, for people
    """

    positions: np.ndarray
    members: np.ndarray
    names: tuple[str, ...]

    def answers(self, contexts: np.ndarray) -> np.ndarray:
        """(Q, M) bool for contexts (M, C)."""
        result = np.empty((len(self.positions), len(contexts)), bool)
        for column in np.unique(self.positions):
            asked = self.positions == column
            result[asked] = self.members[asked][:, contexts[:, column]]
        return result

    def subset(self, chosen: np.ndarray) -> "Questions":
        """The questions of some numbers, in their order."""
        return Questions(self.positions[chosen], self.members[chosen], tuple(self.names[number] for number in chosen))


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

    Phones of another set than ARPAbet are in the classes of the phone that they stand for. A set with no phone, with
    all phones, or with the phones of an earlier set is left out.
    """
    result: dict[str, np.ndarray] = {}
    for name, members in {**PHONE_CLASSES, **{phone: {phone} for phone in phones}}.items():
        chosen = np.array([phone in members or arpabet_of(phone) in members for phone in phones])
        seen = any(np.array_equal(chosen, other) for other in result.values())
        if chosen.any() and not chosen.all() and not seen:
            result[name] = chosen
    return result


def number_sets(values: int) -> dict[str, np.ndarray]:
    """Sets of the numbers 0, ..., ``values`` - 1 by name, (values,) bool each: at most k, and k alone.

    A set that asks the same as an earlier one, or its opposite, is left out.
    """
    numbers = np.arange(values)
    at_most = {f"at most {k}": numbers <= k for k in range(values - 1)}
    return at_most | {f"equal to {k}": numbers == k for k in range(1, values - 1)}


def questions(phones: Sequence[str], columns: int = 3, centre: int = 1, factors: Sequence[Factor] = ()) -> Questions:
    """Questions about every set of an inventory in every column of a context, and about the numbers of every factor.

    Parameters
    ----------
    phones : inventory, K entries
    columns, centre : layout of the contexts, see :func:`position_names`; the defaults are those of triphones
    factors : columns of numbers that follow those of the phones
    """
    sets, width = phone_sets(phones), max([len(phones), *(factor.values for factor in factors)])
    asked = [
        (column, f"{position} {name}", members)
        for column, position in enumerate(position_names(columns, centre))
        for name, members in sets.items()
    ]
    asked += [
        (columns + number, f"{factor.name} {name}", members)
        for number, factor in enumerate(factors)
        for name, members in number_sets(factor.values).items()
    ]
    members = np.zeros((len(asked), width), bool)
    for row, (_, _, chosen) in zip(members, asked, strict=True):
        row[: len(chosen)] = chosen
    return Questions(np.array([column for column, _, _ in asked], int), members, tuple(name for _, name, _ in asked))
