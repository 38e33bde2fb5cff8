"""Time of generating trajectories by the number of frames: linear, where a dense solution is cubic.

Run: python -m benchmarks.generation [ROUNDS]

30 parameters at 100 frames per second with windows over 4 frames. Prints microseconds per frame of utterances from 2.5
to 80 seconds, median of ROUNDS (5), and those of a dense solution of the shorter ones; processor time, on one thread.
"""

import time
from collections.abc import Callable

import numpy as np

from benchmarks.command import run_main
from visualspeech.models.trajectory.generation import generate
from visualspeech.models.trajectory.windows import WINDOWS, stacked, window_matrix

OUTPUTS, STEP, DENSE = 30, 4, 500  # the longest utterance that is solved densely, in frames


def dense(means: np.ndarray, precisions: np.ndarray) -> np.ndarray:
    """The trajectory (T, N) by one dense system per parameter."""
    matrix = window_matrix(len(means), STEP).toarray()
    mean, precision = stacked(means), stacked(precisions)
    columns = [
        np.linalg.solve(matrix.T @ (precision[:, n, None] * matrix), matrix.T @ (precision[:, n] * mean[:, n]))
        for n in range(OUTPUTS)
    ]
    return np.stack(columns, axis=1)


def microseconds(function: Callable, means: np.ndarray, precisions: np.ndarray, rounds: int) -> float:
    """Median processor time per frame."""
    times = []
    for _ in range(rounds):
        begin = time.process_time()
        function(means, precisions)
        times.append(time.process_time() - begin)
    return 1e6 * float(np.median(times)) / len(means)


def banded(means: np.ndarray, precisions: np.ndarray) -> np.ndarray:
    """The trajectory (T, N) of the library."""
    return generate(means, precisions, STEP).values


def main(rounds: int = 5) -> None:
    random = np.random.default_rng(1)
    for frames in (250, 500, 1000, 2000, 4000, 8000):
        means = random.normal(size=(frames, len(WINDOWS) * OUTPUTS))
        precisions = np.exp(random.normal(size=means.shape))
        expected = banded(means, precisions)  # the operators of a length are kept
        line = f"{frames} frames: {microseconds(banded, means, precisions, rounds):.1f} µs a frame"
        if frames <= DENSE:
            furthest = np.abs(dense(means, precisions) - expected).max()
            slow = microseconds(dense, means, precisions, 1)
            line += f", dense {slow:.1f} µs a frame (largest difference {furthest:.1e})"
        print(line, flush=True)


if __name__ == "__main__":
    run_main(main, __doc__)
