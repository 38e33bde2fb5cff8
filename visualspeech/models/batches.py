"""Utterances brought to a network: what is learned of them beforehand, their order, and padded batches."""

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example
from visualspeech.features.streams import joined
from visualspeech.models.frames import Frames, of_utterances
from visualspeech.models.task import check_examples
from visualspeech.models.training_settings import TrainingSettings


@dataclass(frozen=True)
class Content:
    """What one pass over utterances tells.

    Parameters
    ----------
    lengths : (M,) frames of each utterance
    mean : (N,) mean target of all frames
    variance : (N,) variance of all frames
    digest : of all streams and targets: their types, shapes and bytes
    """

    lengths: np.ndarray
    mean: np.ndarray
    variance: np.ndarray
    digest: str


def content(examples: Sequence[Example], blocks: Mapping[str, Block], name: str) -> Content:
    """One pass over utterances; ``name`` (training, validation) is for messages.

    Raises
    ------
    DataError
        There is no utterance, a stream does not fit its block, or a target is not finite.
    """
    check_examples(examples, blocks, name)
    lengths, total, squares, sha = [], 0.0, 0.0, hashlib.sha256()
    for number in range(len(examples)):
        example = examples[number]
        lengths.append(len(example.target))
        total = total + example.target.sum(axis=0, dtype=np.float64)
        squares = squares + np.square(example.target, dtype=np.float64).sum(axis=0)
        named = [(f"{number}.{key}", part) for number, one in enumerate(example.streams) for key, part in
                 one.arrays().items()]  # fmt: skip
        for key, array in (*named, ("target", example.target)):
            sha.update(f"{key} {array.dtype.str} {array.shape};".encode())
            sha.update(np.ascontiguousarray(array).tobytes())
    mean = total / sum(lengths)
    variance = np.maximum(squares / sum(lengths) - mean**2, 0)
    return Content(np.array(lengths), mean, variance, sha.hexdigest())


@dataclass(frozen=True)
class Scaling:
    """What a network's outputs stand for: target = output * scale + mean, each (N,)."""

    mean: np.ndarray
    scale: np.ndarray

    @classmethod
    def of(cls, training: Content, method: str) -> "Scaling":
        """Learned from training utterances: ``global``, ``dimension`` or ``none``."""
        if method == "none":
            return cls(np.zeros_like(training.mean), np.ones_like(training.mean))
        deviation = np.sqrt(training.variance.mean() if method == "global" else training.variance)
        # What never varies is learned as it is.
        return cls(training.mean, np.where(deviation > 0, deviation, 1.0) * np.ones_like(training.mean))

    def unit(self, power: int) -> float:
        """Factor from an objective of scaled targets to one of targets; 1 where dimensions are scaled apart."""
        return float(self.scale[0]) ** power if np.ptp(self.scale) == 0 else 1.0


def batches(lengths: np.ndarray, settings: TrainingSettings, order: np.ndarray, least: int = 1) -> list[np.ndarray]:
    """The utterances of each batch, those of similar length together, to pad little.

    Utterances are sorted by length within runs of 16 batches of the given order.

    Parameters
    ----------
    lengths : (M,) frames of each utterance
    settings : its batcher: ``utterances`` (``batch_size`` of them); with any other one, as many as, padded to the
        longest, hold at most ``batch_frames`` frames; at least one
    order : (M,) in which they are taken
    least : smallest batch size of the batcher ``utterances``
    """
    if settings.batcher == "utterances":
        size = max(settings.batch_size, least)
    else:
        size = max(1, int(settings.batch_frames // max(lengths.mean(), 1)))
    result = []
    for start in range(0, len(order), 16 * size):
        run = order[start : start + 16 * size]
        run = run[np.argsort(-lengths[run], kind="stable")]
        if settings.batcher == "utterances":
            result += [run[first : first + size] for first in range(0, len(run), size)]
        else:
            result += _bounded(run, lengths, settings.batch_frames)
    return result


def _bounded(run: np.ndarray, lengths: np.ndarray, frames: int) -> list[np.ndarray]:
    """Consecutive utterances of a run, longest first, of which the padded batch holds at most ``frames`` frames."""
    parts, first = [], 0
    while first < len(run):
        count = max(1, int(frames // max(lengths[run[first]], 1)))
        parts.append(run[first : first + count])
        first += count
    return parts


@dataclass(frozen=True)
class Batch:
    """Utterances of one update, longest first; zero beyond an utterance's end.

    Parameters
    ----------
    index : (B, T, C) int64, classes of the categorical inputs
    values : (B, T, D) float32, real-valued inputs
    lengths : (B,) int64, descending
    targets : (B, T, N) float32, scaled
    """

    index: torch.Tensor
    values: torch.Tensor
    lengths: torch.Tensor
    targets: torch.Tensor

    def frames(self) -> Frames:
        """All frames of the utterances, without the padding."""
        inside = self._inside()
        return of_utterances(self.index[inside], self.values[inside], self.lengths)

    def laid_out(self, outputs: torch.Tensor) -> torch.Tensor:
        """Outputs (F, N) of all frames as those of utterances, (B, T, N), zero beyond an utterance's end."""
        inside = self._inside()
        result = outputs.new_zeros(*inside.shape, outputs.shape[1])
        result[inside] = outputs
        return result

    def _inside(self) -> torch.Tensor:
        return torch.arange(self.index.shape[1]) < self.lengths[:, None]


def batch(examples: Sequence[Example], numbers: np.ndarray, scaling: Scaling) -> Batch:
    """Some utterances, given longest first, padded to one length."""
    chosen = [examples[int(number)] for number in numbers]
    lengths = torch.tensor([len(one.target) for one in chosen])
    inputs = [joined(one.streams) for one in chosen]
    size = (len(chosen), int(lengths[0]))
    index = torch.zeros(*size, inputs[0][0].shape[1], dtype=torch.int64)
    values = torch.zeros(*size, inputs[0][1].shape[1])
    targets = torch.zeros(*size, len(scaling.mean))
    for row, (one, (classes, numbers_)) in enumerate(zip(chosen, inputs, strict=True)):
        frames = len(one.target)
        index[row, :frames] = torch.from_numpy(classes)
        values[row, :frames] = torch.from_numpy(numbers_)
        targets[row, :frames] = torch.tensor(((one.target - scaling.mean) / scaling.scale).astype(np.float32))
    return Batch(index, values, lengths, targets)
