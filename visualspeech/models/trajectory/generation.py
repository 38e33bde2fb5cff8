"""The trajectory that a sequence of Gaussians generates under its own slopes: MLPG (Tokuda et al. 2000).

The most likely stream c of values whose observations W c have the means m and the precisions u solves

    R c = W' U m,    R = W' U W,

one system for each dimension. R is banded, and linear in u; the systems of all dimensions are laid behind each other as
one banded matrix, so that one Cholesky factorisation solves an utterance.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np

from visualspeech.errors import DamagedFile
from visualspeech.models.trajectory.windows import WINDOWS, neighbours, observations, stacked, unstacked, window_matrix

MAX_STEP = 200  # frames between the taps of the windows, to which the memory of a trajectory is proportional
MAX_SPREAD = 1e12  # largest over least variance of one parameter, beyond which trajectories cannot be computed


@dataclass(frozen=True)
class Trajectory:
    """A generated stream, with what it takes to follow an error back through the generation.

    Parameters
    ----------
    values : (T, N)
    step : frames between the taps of the windows
    factor : banded Cholesky factor of R of all dimensions, (bands, N T)
    """

    values: np.ndarray
    step: int
    factor: np.ndarray

    def back(self, error: np.ndarray) -> np.ndarray:
        """W R^-1 error, (T, 3N), of the error of each frame (T, N); times the precisions, the slope by the means."""
        solved = _solve(self.factor, np.asarray(error, np.float64))
        return unstacked(window_matrix(len(error), self.step) @ solved)

    def observations(self) -> np.ndarray:
        """The stream's own static, delta and delta-delta values, (T, 3N)."""
        return observations(self.values, self.step)


def step_of(delta_step: float, rate: float) -> int:
    """Frames between the taps of the windows at ``rate`` Hz, at least one, for a time in seconds."""
    return max(round(delta_step * rate), 1)


def check_generation(path, variance: np.ndarray, step: int) -> None:
    """Refuse Gaussians from which no trajectory can be generated.

    Parameters
    ----------
    path : of the file that they come from
    variance : (M, 3N) of M Gaussians
    step : frames between the taps of the windows

    Raises
    ------
    DamagedFile
        The windows are too wide, or the variances of one parameter differ too much.
    """
    if step > MAX_STEP:
        raise DamagedFile(path, f"its windows reach over {step} frames, more than {MAX_STEP}")
    each = variance.reshape(len(variance), len(WINDOWS), -1).astype(np.float64)
    if (each.max(axis=(0, 1)) > MAX_SPREAD * each.min(axis=(0, 1))).any():
        raise DamagedFile(path, "the variances of one parameter are too different to generate a stream")


def generate(means: np.ndarray, precisions: np.ndarray, step: int) -> Trajectory:
    """The most likely trajectory of a sequence of diagonal Gaussians.

    Parameters
    ----------
    means, precisions : (T, 3N) of the Gaussian of each frame, in the order of :func:`observations`; precisions are
        inverse variances
    step : frames between the taps of the windows
    """
    frames = len(means)
    matrix, bands, count = _operators(frames, step)
    precision = stacked(precisions)
    right = matrix.T @ (precision * stacked(means))
    width = right.shape[1]
    banded = (bands @ precision).reshape(count, frames, width)
    factor = _factor(np.ascontiguousarray(np.swapaxes(banded, 1, 2)).reshape(count, width * frames))
    return Trajectory(_solve(factor, right), step, factor)


@lru_cache(maxsize=64)
def _operators(frames: int, step: int):
    """W, the sparse map from precisions (3T,) to the upper bands of W' U W (bands T,), and the number of bands."""
    from scipy.sparse import csr_array

    matrix = window_matrix(frames, step)
    count = min(2 * step, frames - 1) + 1
    at = np.arange(frames)
    taps = neighbours(frames, step)
    rows, columns, values = [], [], []
    for number, window in enumerate(WINDOWS):
        # Every pair of taps of an observation meets in R at their two frames; R is symmetric, the upper half is kept.
        for (one, i), (other, j) in product(zip(window, taps, strict=True), repeat=2):
            if one and other:
                upper = i <= j
                rows.append(((count - 1 + i - j) * frames + j)[upper])
                columns.append((number * frames + at)[upper])
                values.append(np.full(upper.sum(), one * other))
    place = (np.concatenate(rows), np.concatenate(columns))
    return matrix, csr_array((np.concatenate(values), place), shape=(count * frames, matrix.shape[0])), count


def _factor(bands: np.ndarray) -> np.ndarray:
    from scipy.linalg import cholesky_banded

    return cholesky_banded(bands, overwrite_ab=True, lower=False, check_finite=False)


def _solve(factor: np.ndarray, right: np.ndarray) -> np.ndarray:
    from scipy.linalg import cho_solve_banded

    frames, width = right.shape
    solved = cho_solve_banded((factor, False), right.T.ravel(), check_finite=False)
    return np.ascontiguousarray(solved.reshape(width, frames).T)
