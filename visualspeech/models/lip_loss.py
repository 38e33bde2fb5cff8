"""A loss on the decoded opening of the lips in the frames that make speech look articulate."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from visualspeech.models.batches import Scaling
from visualspeech.models.lips import Lips
from visualspeech.models.training_settings import TrainingSettings

#: Objectives in whose units the loss is.
ADDED_TO = ("sse", "sse_centred")


@dataclass(frozen=True)
class LipLoss:
    """Squared errors of the opening on one side of the recorded one.

    Squared errors of the parameters make a network predict means: lips that close now and then stay open. In the frame
    of a closure in which the recorded lips are least open, the excess of the predicted opening counts in addition; in
    the frame of an open vowel in which they are most open, what the predicted opening lacks.

    Parameters
    ----------
    weights : (N,) opening, in standard deviations, per unit of each output
    offset : opening of outputs that are zero, in standard deviations
    highest, lowest : of each training utterance, in standard deviations (:class:`visualspeech.models.lips.Lips`)
    closure_weight, open_weight : with a weight of 1, an error of one standard deviation counts as much as errors of one
        standard deviation of all outputs in a frame
    """

    weights: torch.Tensor
    offset: float
    highest: Sequence[np.ndarray]
    lowest: Sequence[np.ndarray]
    closure_weight: float
    open_weight: float

    @classmethod
    def of(cls, lips: Lips | None, scaling: Scaling, settings: TrainingSettings) -> "LipLoss | None":
        """The loss that the settings ask for, on outputs in the units of training; None for none.

        Of networks whose outputs are parameters and their deltas, the parameters come first.
        """
        asked = settings.closure_weight or settings.open_weight
        if lips is None or not asked or settings.objective not in ADDED_TO:
            return None
        weights = np.zeros(len(scaling.mean))
        weights[: len(lips.weights)] = lips.weights
        unit = lips.deviation
        return cls(
            torch.tensor(weights * scaling.scale / unit, dtype=torch.float32),
            float((lips.offset + weights @ scaling.mean) / unit),
            [values / np.float32(unit) for values in lips.highest],
            [values / np.float32(unit) for values in lips.lowest],
            settings.closure_weight,
            settings.open_weight,
        )

    def __call__(self, predicted: torch.Tensor, numbers: Iterable[int]) -> torch.Tensor:
        """The loss of a batch: outputs (B, T, N) of the training utterances with these numbers."""
        opening = predicted @ self.weights + self.offset
        numbers, frames = [int(number) for number in numbers], predicted.shape[1]
        excess = opening - _padded([self.highest[number] for number in numbers], frames, np.inf)
        missing = _padded([self.lowest[number] for number in numbers], frames, -np.inf) - opening
        total = self.closure_weight * torch.relu(excess).square().sum()
        total = total + self.open_weight * torch.relu(missing).square().sum()
        return 0.5 * predicted.shape[2] * total


def _padded(rows: Sequence[np.ndarray], frames: int, other: float) -> torch.Tensor:
    result = np.full((len(rows), frames), other, np.float32)
    for row, values in zip(result, rows, strict=True):
        row[: len(values)] = values
    return torch.from_numpy(result)
