"""Static, delta and delta-delta values of a stream, as one linear map of it (Tokuda et al. 2000)."""

from functools import lru_cache

import numpy as np

#: Coefficients of the windows on the frames t - step, t, t + step: value, slope a step, curvature a step squared.
WINDOWS = ((0.0, 1.0, 0.0), (-0.5, 0.0, 0.5), (1.0, -2.0, 1.0))


def observations(values: np.ndarray, step: int) -> np.ndarray:
    """Values with their slope and curvature: (T, N) to (T, 3N), in the order static, delta, delta-delta.

    Before the first and after the last frame the stream is taken as constant.

    Parameters
    ----------
    step : frames between the taps of a window
    """
    taps = [values[frame] for frame in neighbours(len(values), step)]
    return np.concatenate([sum(c * tap for c, tap in zip(row, taps, strict=True) if c) for row in WINDOWS], axis=1)


@lru_cache(maxsize=64)
def window_matrix(frames: int, step: int):
    """The map of :func:`observations` for one dimension: sparse (3 frames, frames), W of Tokuda et al., Eq. 12."""
    from scipy.sparse import csr_array

    at = np.arange(frames)
    rows, columns, values = [], [], []
    for number, window in enumerate(WINDOWS):
        for coefficient, tap in zip(window, neighbours(frames, step), strict=True):
            rows.append(number * frames + at)
            columns.append(tap)
            values.append(np.full(frames, coefficient))
    place = (np.concatenate(rows), np.concatenate(columns))
    matrix = csr_array((np.concatenate(values), place), shape=(len(WINDOWS) * frames, frames))
    matrix.sum_duplicates()
    matrix.eliminate_zeros()
    return matrix


def stacked(values: np.ndarray) -> np.ndarray:
    """(T, 3N) of :func:`observations` as (3T, N), the order of the rows of :func:`window_matrix`."""
    frames, width = values.shape
    parts = values.reshape(frames, len(WINDOWS), width // len(WINDOWS))
    return np.swapaxes(parts, 0, 1).reshape(len(WINDOWS) * frames, -1)


def unstacked(values: np.ndarray) -> np.ndarray:
    """The inverse of :func:`stacked`."""
    frames = len(values) // len(WINDOWS)
    return np.swapaxes(values.reshape(len(WINDOWS), frames, -1), 0, 1).reshape(frames, -1)


def neighbours(frames: int, step: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The frames that the three taps of every frame's windows read, (frames,) each."""
    at = np.arange(frames)
    return np.maximum(at - step, 0), at, np.minimum(at + step, frames - 1)
