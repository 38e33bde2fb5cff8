"""Networks that predict static, delta and delta-delta parameters: their targets, and the trajectory of their outputs.

The outputs of a frame are the means of 3N Gaussians whose variances are the same in all frames (Zen et al. 2013, 2.3).
By default the variances are those of the errors of the outputs. Tokuda's likelihood asks for the spread of what is
recorded about the mean, which these errors are; the variances of the targets themselves, which are often taken, trust
an output that the network cannot predict as much as one that it can.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.features.examples import Example
from visualspeech.models.trajectory.generation import generate, step_of
from visualspeech.models.trajectory.windows import WINDOWS, observations

_LEAST = 1e-6  # least variance, as a share of the largest of the same parameter: an output that is never wrong


@dataclass(frozen=True)
class Mlpg:
    """The trajectory of the outputs of a network.

    Parameters
    ----------
    variance : (3N,) of static, delta and delta-delta parameters
    delta_step : time between the taps of the windows in seconds
    """

    variance: np.ndarray
    delta_step: float

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return len(self.variance) // len(WINDOWS)

    def trajectory(self, means: np.ndarray, rate: float) -> np.ndarray:
        """Parameters (T, N) at ``rate`` Hz, the most likely ones under the means (T, 3N)."""
        precisions = np.broadcast_to(1 / self.variance.astype(np.float64), means.shape)
        return generate(means.astype(np.float64), precisions, step_of(self.delta_step, rate)).values


def error_variance(errors: Iterable[np.ndarray]) -> np.ndarray:
    """Mean squares (3N,) float32 of the errors (T, 3N) of utterances, none too small to generate a trajectory."""
    return _bounded(_moments(errors)[1])


def target_variance(targets: Iterable[np.ndarray]) -> np.ndarray:
    """Variances (3N,) float32 of the targets (T, 3N) of utterances, none too small to generate a trajectory."""
    mean, squares = _moments(targets)
    return _bounded(np.maximum(squares - mean**2, 0))


def _moments(utterances: Iterable[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Means and mean squares (3N,) of the values (T, 3N) of utterances, over all frames."""
    total, squares, frames = 0.0, 0.0, 0
    for one in utterances:
        total, frames = total + one.sum(axis=0, dtype=np.float64), frames + len(one)
        squares = squares + np.square(one, dtype=np.float64).sum(axis=0)
    return total / frames, squares / frames


def _bounded(variance: np.ndarray) -> np.ndarray:
    parts = variance.reshape(len(WINDOWS), -1)
    largest = parts.max(axis=0)
    return np.maximum(parts, np.where(largest > 0, _LEAST * largest, 1.0)).reshape(-1).astype(np.float32)


class Observed(Sequence):
    """Utterances with static, delta and delta-delta targets (T, 3N) in place of static ones (T, N).

    Parameters
    ----------
    examples : with static targets
    delta_step : time between the taps of the windows in seconds
    """

    def __init__(self, examples: Sequence[Example], delta_step: float) -> None:
        self._examples, self._delta_step = examples, delta_step

    def __len__(self) -> int:
        return len(self._examples)

    def __getitem__(self, number: int) -> Example:
        example = self._examples[number]
        seen = observations(example.target, step_of(self._delta_step, example.rate))
        return example._replace(target=seen.astype(np.float32))
