"""What training minimises, and the statistics from which its value over a corpus follows."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import torch

from visualspeech.models.training_settings import TrainingSettings


class Objective(Protocol):
    """An objective over batches of utterances, (B, T, N); frames beyond an utterance's length are zero in both.

    ``power``: the value's unit is that of the targets to this power. ``additive``: the loss is a sum over frames.
    """

    power: int
    additive: bool

    def loss(self, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        """What the gradient is taken of."""

    def statistics(
        self, loss: torch.Tensor, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor
    ) -> np.ndarray:
        """Sums (S,) float64 over the batch; those of a corpus are their sum over batches."""

    def value(self, statistics: np.ndarray, frames: int) -> float:
        """The objective of a corpus, the lower the better, from the sums over its ``frames`` frames."""


class SumOfSquaredErrors:
    """E of Fan 2015, Eq. 9 and 10: half the squared differences, summed over dimensions and frames; a value a frame."""

    power = 2
    additive = True

    def loss(self, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        return 0.5 * torch.sum((predicted - true) ** 2)

    def statistics(self, loss, predicted, true, lengths) -> np.ndarray:
        return np.array([loss.item()])

    def value(self, statistics: np.ndarray, frames: int) -> float:
        return statistics[0] / frames


@dataclass(frozen=True)
class CentredSumOfSquaredErrors:
    """E of Fan 2015, Eq. 9, of prediction and truth less their own means over the utterance; a value a frame.

    With the error e_t of T frames and its mean m: ``(sum_t |e_t - m|^2 + offset_weight T |m|^2) / 2``. The offset of a
    whole utterance is position and light of a recording, which neither text nor sound tells. Without any weight on it
    a network's own offset would stay at random, and differ from sentence to sentence.

    Parameters
    ----------
    offset_weight : of the squared mean error; 1 gives :class:`SumOfSquaredErrors`
    """

    offset_weight: float
    power = 2
    additive = True

    def loss(self, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        error = predicted - true
        total = error.sum(dim=1)
        # Frames beyond the end are zero, so sums over T need no mask: sum |e - m|^2 = sum |e|^2 - T |m|^2.
        offset = torch.sum(total**2 / lengths[:, None])
        return 0.5 * (torch.sum(error**2) - (1 - self.offset_weight) * offset)

    def statistics(self, loss, predicted, true, lengths) -> np.ndarray:
        return np.array([loss.item()])

    def value(self, statistics: np.ndarray, frames: int) -> float:
        return statistics[0] / frames


class MeanSquaredError:
    """Squared differences, averaged over dimensions and frames."""

    power = 2
    additive = False

    def loss(self, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        return torch.sum((predicted - true) ** 2) / (lengths.sum() * true.shape[2])

    def statistics(self, loss, predicted, true, lengths) -> np.ndarray:
        return np.array([loss.item() * int(lengths.sum())])

    def value(self, statistics: np.ndarray, frames: int) -> float:
        return statistics[0] / frames


class ConcordanceCorrelation:
    """1 - concordance correlation coefficient (Lin 1989), averaged over dimensions (Sadoughi and Busso 2017, Eq. 1).

    2 cov(x, y) / (var x + var y + (mean x - mean y)^2), means and (co)variances over the frames of a batch; over a
    corpus, over all its frames: it is no mean over batches.
    """

    power = 0
    additive = False

    def loss(self, predicted: torch.Tensor, true: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        # Both less the mean of the truth: the coefficient is the same, and squares of an offset cost no digits.
        offset = true.sum(dim=(0, 1)) / lengths.sum()
        sums = self._sums(predicted - offset, true - offset, lengths)
        return 1 - _concordance(*sums, lengths.sum()).mean()

    def statistics(self, loss, predicted, true, lengths) -> np.ndarray:
        with torch.no_grad():
            sums = self._sums(predicted.double(), true.double(), lengths)
        return torch.stack(sums).numpy().ravel()

    def value(self, statistics: np.ndarray, frames: int) -> float:
        return float(1 - _concordance(*statistics.reshape(5, -1), frames).mean())

    @staticmethod
    def _sums(predicted, true, lengths):
        # The output layer's bias may leave something in padded frames.
        inside = (torch.arange(true.shape[1])[None, :] < lengths[:, None])[..., None]
        x, y = predicted * inside, true * inside
        return tuple(part.sum(dim=(0, 1)) for part in (x, y, x * x, y * y, x * y))


def _concordance(x, y, xx, yy, xy, count):
    """Concordance correlation (N,) from sums over ``count`` frames; tensors or arrays. 0 where nothing varies."""
    mean_x, mean_y = x / count, y / count
    covariance = xy / count - mean_x * mean_y
    spread = (xx / count - mean_x**2) + (yy / count - mean_y**2) + (mean_x - mean_y) ** 2
    return 2 * covariance / (spread + 1e-12)


def objective_of(settings: TrainingSettings) -> Objective:
    """The objective that the settings name."""
    if settings.objective == "sse_centred":
        return CentredSumOfSquaredErrors(settings.offset_weight)
    return {"sse": SumOfSquaredErrors, "mse": MeanSquaredError, "ccc": ConcordanceCorrelation}[settings.objective]()
