"""What training knows of closures: how the opening of the lips follows from the parameters, and when it is least."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.provenance import digest
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.closures import closing_frames


@dataclass(frozen=True)
class Closing:
    """The opening of the lips as a linear function of the parameters, and the closures of the training utterances.

    Parameters
    ----------
    weights : (N,) opening per unit of each parameter, by least squares over all training frames
    offset : opening of parameters that are zero
    deviation : standard deviation of the opening over all training frames
    limits : of each training utterance, in their order, the recorded opening (T,) float32 in the frames of closures
        (:func:`visualspeech.speech.closures.closing_frames`), infinity in all others
    """

    weights: np.ndarray
    offset: float
    deviation: float
    limits: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, recorded: Iterable[tuple[np.ndarray, np.ndarray, Alignment, float]]) -> "Closing":
        """From parameters (T, N), opening (T,), alignment and frame rate in Hz of each training utterance.

        Raises
        ------
        DataError
            There is no utterance, or the opening never changes.
        """
        gram, moments, squares, limits = 0.0, 0.0, 0.0, []
        for parameters, opening, alignment, rate in recorded:
            inputs = np.column_stack([parameters, np.ones(len(parameters))]).astype(np.float64)
            values = np.asarray(opening, np.float64)
            gram, moments, squares = gram + inputs.T @ inputs, moments + inputs.T @ values, squares + values @ values
            frames, limit = closing_frames(values, alignment, rate), np.full(len(values), np.inf, np.float32)
            limit[frames] = values[frames]
            limits.append(limit)
        if not limits:
            raise DataError("there is no training utterance whose closures could be learned.")
        count, total = gram[-1, -1], moments[-1]
        variance = squares / count - (total / count) ** 2
        if not variance > 0:
            raise DataError("the lips never open in the training utterances; set `training.closure_weight: 0`.")
        *weights, offset = np.linalg.lstsq(gram, moments, rcond=None)[0]
        return cls(np.array(weights), float(offset), float(np.sqrt(variance)), tuple(limits))

    @property
    def digest(self) -> str:
        """Of all that it holds."""
        parts = [self.weights, *self.limits]
        return digest([self.offset, self.deviation, *(part.astype(float).tobytes().hex() for part in parts)])

    def limits_of(self, numbers: Iterable[int], frames: int) -> np.ndarray:
        """Limits (B, frames) float32 of some training utterances, infinity beyond their ends."""
        chosen = [self.limits[int(number)] for number in numbers]
        result = np.full((len(chosen), frames), np.inf, np.float32)
        for row, limit in zip(result, chosen, strict=True):
            row[: len(limit)] = limit
        return result
