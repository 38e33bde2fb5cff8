"""The phones of an utterance, or divisions of them, with their neighbours and times, and as runs of frames."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.contexts import phone_contexts
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.timing import frame_times, interval_of_frame


class Factor(NamedTuple):
    """A column of numbers beside the phones of a context, such as a position in the word: 0, ..., ``values`` - 1."""

    name: str
    values: int


class ContextLayout(NamedTuple):
    """The columns of contexts: phones, factors, and the number of the division, where phones are divided.

    Parameters
    ----------
    columns : number of columns that hold phones, the first ones
    centre : column of the phone itself
    divisions : of each phone; if there are several, the last column holds their number
    factors : columns that follow those of the phones
    """

    columns: int
    centre: int
    divisions: int = 1
    factors: tuple[Factor, ...] = ()

    def sizes(self, phones: int) -> tuple[int, ...]:
        """Number of values of every column, with an inventory of ``phones`` phones."""
        factors = tuple(factor.values for factor in self.factors)
        return (phones,) * self.columns + factors + ((self.divisions,) if self.divisions > 1 else ())


@dataclass(frozen=True)
class PhoneTrack:
    """The phones of an utterance in time, or divisions of them whose times are known, such as acoustic states.

    Parameters
    ----------
    contexts : (P, C) int, each phone with its neighbours as indices of the inventory: 3 columns for triphones, 5 for
        quinphones; then a column for each factor. Where phones are divided, a row is a division, and a further last
        column holds its number
    starts : (P,) seconds, ascending; a row ends where the next one starts
    centre : column of the phone itself in ``contexts``
    divisions : number D of divisions of each phone; 1: rows are phones
    factors : columns of numbers beside the phones

    Raises
    ------
    DataError
        The shapes do not fit each other, or there is no phone.
    """

    contexts: np.ndarray
    starts: np.ndarray
    centre: int
    divisions: int = 1
    factors: tuple[Factor, ...] = ()

    def __post_init__(self) -> None:
        shape = np.shape(self.contexts)
        if len(shape) != 2 or np.shape(self.starts) != shape[:1] or not shape[0] or not 0 <= self.centre < self.columns:
            raise DataError(
                f"phone contexts of shape {shape} do not fit starts of shape {np.shape(self.starts)} and the phone in "
                f"column {self.centre}; at least one phone is needed, with one start per phone."
            )

    @property
    def columns(self) -> int:
        """Number of columns of the contexts that hold phones."""
        return self.contexts.shape[1] - len(self.factors) - (self.divisions > 1)

    @property
    def layout(self) -> ContextLayout:
        """What the columns of the contexts hold."""
        return ContextLayout(self.columns, self.centre, self.divisions, self.factors)

    def runs(self, frames: int, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """Contexts (Q, C) and lengths (Q,) of the runs of frames that share a row.

        A frame belongs to the row that is spoken at its centre (:mod:`visualspeech.timing`); a row so short that no
        frame has its centre in it is left out.
        """
        at = interval_of_frame(self.starts, frame_times(frames, rate))
        phones, lengths = np.unique(at, return_counts=True)
        return self.contexts[phones], lengths


def layout_text(layout: ContextLayout) -> str:
    """A layout of phone contexts for messages."""
    divided = f", phones divided in {layout.divisions}" if layout.divisions > 1 else ""
    factors = f", {len(layout.factors)} factors beside the phones" if layout.factors else ""
    return f"{layout.columns} columns, the phone in column {layout.centre}{factors}{divided}"


#: An utterance that HMMs are trained on: its phones, values (T, N), and their frame rate in Hz.
Example = tuple[PhoneTrack, np.ndarray, float]


def phone_track(alignment: Alignment, phones: Sequence[str], before: int = 1, after: int = 1) -> PhoneTrack:
    """The phones of an utterance with ``before`` neighbours on the left and ``after`` on the right.

    Parameters
    ----------
    phones : inventory, K entries

    Raises
    ------
    DataError
        The alignment has no phones, or phones that are not in the inventory.
    """
    return PhoneTrack(phone_contexts(alignment, phones, before, after), starts_of(alignment.phones), before)
