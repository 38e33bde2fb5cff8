"""The sound of an utterance as features are computed from it: read in parts, wherever it lies."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import gcd
from typing import Protocol

import numpy as np

RATE = 16_000  # Hz, of the sound that is kept of recordings
BLOCK = 20.0  # seconds that are read at a time


def to_int16(samples: np.ndarray) -> np.ndarray:
    """Samples (n,) in [-1, 1] as int16; values out of range are clipped."""
    return np.round(np.clip(samples, -1, 1) * 32767).astype(np.int16)


class Samples(Protocol):
    """A sequence of samples that is read in slices: an array, a :class:`~visualspeech.media.spooling.Spool`, a file."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice) -> np.ndarray: ...


@dataclass(frozen=True, eq=False)
class Sound:
    """The sound of one recording; two of them are the same only if they are one object.

    Parameters
    ----------
    samples : (n,) int16, mono
    rate : sample rate in Hz
    """

    samples: Samples
    rate: float = RATE

    @property
    def seconds(self) -> float:
        """Duration."""
        return len(self.samples) / self.rate

    def between(self, first: int, last: int) -> np.ndarray:
        """Samples ``first`` to ``last`` (exclusive) as float64 in [-1, 1]; zero outside the recording."""
        result = np.zeros(max(0, last - first))
        begin, end = max(first, 0), min(last, len(self.samples))
        if end > begin:
            result[begin - first : end - first] = self.samples[begin:end]
        return result / 32768

    @classmethod
    def of(cls, samples: np.ndarray, rate: int) -> "Sound":
        """Samples (n,) in [-1, 1] at any rate, resampled to that of the recordings (:data:`RATE`)."""
        from scipy.signal import resample_poly

        common = gcd(int(rate), RATE)
        if rate != RATE and len(samples):
            samples = resample_poly(np.asarray(samples, np.float64), RATE // common, int(rate) // common)
        return cls(to_int16(samples))


class StoredSamples:
    """Samples of an utterance in a file of arrays, read as they are asked for.

    Parameters
    ----------
    arrays : opened reader or collection with the array ``samples``
    utterance : id
    """

    def __init__(self, arrays, utterance: str) -> None:
        self._arrays, self._utterance = arrays, utterance

    def __len__(self) -> int:
        return self._arrays.length(self._utterance, "samples")

    def __getitem__(self, rows: slice) -> np.ndarray:
        return self._arrays.array(self._utterance, "samples", rows)


def spans(count: int, size: int) -> Iterator[tuple[int, int]]:
    """First and last (exclusive) number of consecutive runs of at most ``size`` of ``count`` things."""
    for first in range(0, count, size):
        yield first, min(first + size, count)


def between_voiced(values: np.ndarray) -> np.ndarray:
    """Values (T,) that are NaN in unvoiced frames, interpolated linearly through them; all NaN where none is voiced.

    Before the first and after the last voiced frame they are constant.
    """
    voiced = np.flatnonzero(~np.isnan(values))
    return np.interp(np.arange(len(values)), voiced, values[voiced]) if len(voiced) else values
