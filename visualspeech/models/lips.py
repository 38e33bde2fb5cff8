"""What training knows of the lips: how their opening follows from the parameters, and when it matters most."""

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.models.rows import ModelRow
from visualspeech.speech.alignment import Alignment, alignments_of
from visualspeech.speech.closures import closing_frames, open_frames

#: Settings of training that ask for it.
WEIGHTS = ("closure_weight", "open_weight")


@dataclass(frozen=True)
class Lips:
    """The opening of the lips as a linear function of the parameters, and its extremes in the training utterances.

    Parameters
    ----------
    weights : (N,) opening per unit of each parameter, by least squares over all training frames
    offset : opening of parameters that are zero
    deviation : standard deviation of the opening over all training frames
    highest : of each training utterance, in their order, the recorded opening (T,) float32 in the frames of closures
        (:func:`visualspeech.speech.closures.closing_frames`), infinity in all others
    lowest : likewise in the frames of open vowels (:func:`visualspeech.speech.closures.open_frames`), minus infinity in
        all others
    """

    weights: np.ndarray
    offset: float
    deviation: float
    highest: tuple[np.ndarray, ...]
    lowest: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, recorded: Iterable[tuple[np.ndarray, np.ndarray, Alignment, float]]) -> "Lips":
        """From parameters (T, N), opening (T,), alignment and frame rate in Hz of each training utterance.

        Raises
        ------
        DataError
            There is no utterance, or the opening never changes.
        """
        gram, moments, squares, highest, lowest = 0.0, 0.0, 0.0, [], []
        for parameters, opening, alignment, rate in recorded:
            inputs = np.column_stack([parameters, np.ones(len(parameters))]).astype(np.float64)
            values = np.asarray(opening, np.float64)
            gram, moments, squares = gram + inputs.T @ inputs, moments + inputs.T @ values, squares + values @ values
            highest.append(_only(values, closing_frames(values, alignment, rate), np.inf))
            lowest.append(_only(values, open_frames(values, alignment, rate), -np.inf))
        if not highest:
            raise DataError("there is no training utterance whose lips could be learned.")
        count, total = gram[-1, -1], moments[-1]
        variance = squares / count - (total / count) ** 2
        if not variance > 1e-12 * squares / count:
            raise DataError(f"the lips never move in the training utterances; set `training.{WEIGHTS[0]}` and "
                            f"`training.{WEIGHTS[1]}` to 0.")  # fmt: skip
        solved = np.linalg.lstsq(gram, moments, rcond=None)[0]
        return cls(solved[:-1], float(solved[-1]), float(np.sqrt(variance)), tuple(highest), tuple(lowest))

    @property
    def digest(self) -> str:
        """Of all that it holds."""
        sha = hashlib.sha256(np.array([self.offset, self.deviation, *self.weights]).tobytes())
        for part in (*self.highest, *self.lowest):
            sha.update(part.tobytes())
        return sha.hexdigest()


def _only(values: np.ndarray, frames: np.ndarray, other: float) -> np.ndarray:
    result = np.full(len(values), other, np.float32)
    result[frames] = values[frames]
    return result


def recorded_lips(row: ModelRow, ids: Sequence[str], targets, alignment: Sequence[str | Path]) -> Lips | None:
    """The lips of the training utterances, if the training of a row asks for them.

    Parameters
    ----------
    ids : training utterances in their order
    targets : opened files with ``appearance`` and ``opening``
    alignment : table files

    Raises
    ------
    StorageError
        An utterance is missing in the files.
    DataError
        As :meth:`Lips.of`.
    """
    if not any(row.training.get(name) for name in WEIGHTS):
        return None
    aligned = alignments_of(alignment, ids)
    return Lips.of(
        (targets.array(name, "appearance"), targets.array(name, "opening"), aligned[name], targets.rate(name))
        for name in ids
    )
