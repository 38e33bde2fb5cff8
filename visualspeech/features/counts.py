"""Counts as inputs of a network: zero mean and unit variance over the training frames, and never beyond their range.

A text to be spoken may have more words than any training utterance; a network says little about inputs that it has
never seen, so a count outside the range of the training frames is taken as the nearest inside it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError, SettingError

MAX_COUNT = 1e7  # frames of a day at 100 Hz
MIN_DEVIATION = 1e-3  # what varies less does not vary: one frame of 5 million with another count
_NAMES = ("mean", "deviation", "low", "high")
_NUMBER = {"type": "number", "minimum": 0, "maximum": MAX_COUNT}
#: JSON Schema of what :meth:`Counts.plain` gives.
COUNTS = {
    "type": "array",
    "maxItems": 100,
    "items": {
        "type": "object",
        "required": list(_NAMES),
        "additionalProperties": False,
        "properties": {name: _NUMBER | ({"minimum": MIN_DEVIATION} if name == "deviation" else {}) for name in _NAMES},
    },
}


@dataclass(frozen=True, eq=False)
class Counts:
    """Statistics of N counts over training frames, (N,) float64 each."""

    mean: np.ndarray
    deviation: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __eq__(self, other) -> bool:
        return isinstance(other, Counts) and self.plain() == other.plain()

    def normalised(self, values: np.ndarray) -> np.ndarray:
        """Counts (T, N), limited to the range of the training frames, with zero mean and unit variance: float32."""
        return ((np.clip(values, self.low, self.high) - self.mean) / self.deviation).astype(np.float32)

    def plain(self) -> list[dict[str, float]]:
        """Statistics of each count by name, as plain data hold them; an array of no counts could not be stored."""
        columns = (getattr(self, name).tolist() for name in _NAMES)
        return [dict(zip(_NAMES, one, strict=True)) for one in zip(*columns, strict=True)]

    @classmethod
    def of(cls, plain: Sequence[Mapping[str, float]], columns: int) -> "Counts":
        """The inverse of :meth:`plain`, for data of the schema :data:`COUNTS`.

        Raises
        ------
        SettingError
            There are not ``columns`` counts.
        """
        if len(plain) != columns:
            raise SettingError(f"there are statistics of {len(plain)} counts, the features have {columns}.")
        return cls(*(np.array([one[name] for one in plain], np.float64) for name in _NAMES))


def fit_counts(values: Iterable[np.ndarray], columns: int) -> Counts:
    """Statistics of counts; memory does not grow with the number of utterances.

    A count that is the same in all frames has the deviation 1, so that it gives 0.

    Parameters
    ----------
    values : (T, N) of each utterance
    columns : N

    Raises
    ------
    DataError
        There is no frame.
    """
    frames, total, squares = 0, np.zeros(columns), np.zeros(columns)
    low, high = np.full(columns, np.inf), np.full(columns, -np.inf)
    for one in values:
        # Sums of integers below 2 ** 53 are exact in float64, so the order of the utterances does not matter.
        found = np.asarray(one, np.float64)
        frames += len(found)
        total, squares = total + found.sum(axis=0), squares + (found**2).sum(axis=0)
        if len(found):
            low, high = np.minimum(low, found.min(axis=0)), np.maximum(high, found.max(axis=0))
    if not frames:
        raise DataError("there is no training utterance to learn from. Add recordings, or change `split`.")
    mean = total / frames
    deviation = np.sqrt(np.maximum(squares / frames - mean**2, 0))
    return Counts(mean, np.where(deviation < MIN_DEVIATION, 1.0, deviation), low, high)
