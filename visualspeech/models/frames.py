"""Frames with the utterances around them, and single frames of a whole corpus in random order."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from visualspeech.features.examples import Example
from visualspeech.features.streams import Layout, joined


@dataclass(frozen=True)
class Frames:
    """Frames that a network is asked for, among those of some utterances.

    Parameters
    ----------
    index : (F, C) whole numbers of any type, classes of the categorical inputs, one utterance after the other
    values : (F, D) float32, real-valued inputs
    at : (M,) int64, the frames that are asked for
    first, end : (M,) int64, the first frame of the utterance of each, and the frame after its last one
    """

    index: torch.Tensor
    values: torch.Tensor
    at: torch.Tensor
    first: torch.Tensor
    end: torch.Tensor

    def around(self, window: int) -> tuple[torch.Tensor, torch.Tensor]:
        """The frames from ``window`` before to ``window`` after each: their numbers, and whether its utterance has
        them, (M, 2 window + 1) each; a frame that it has not is replaced by the one that is asked for."""
        numbers = self.at[:, None] + torch.arange(-window, window + 1)
        inside = (numbers >= self.first[:, None]) & (numbers < self.end[:, None])
        return torch.where(inside, numbers, self.at[:, None]), inside


def of_utterances(index: torch.Tensor, values: torch.Tensor, lengths: torch.Tensor) -> Frames:
    """All frames of utterances that lie behind each other: (F, C) and (F, D) of utterances of ``lengths`` (B,)."""
    ends = lengths.cumsum(0)
    first, end = (torch.repeat_interleave(bound, lengths) for bound in (ends - lengths, ends))
    return Frames(index, values, torch.arange(len(index)), first, end)


@dataclass(frozen=True)
class FrameBatch:
    """Single frames of one update; to an objective, each is an utterance of one frame.

    Parameters
    ----------
    given : the frames
    lengths : (B,) int64, ones
    targets : (B, 1, N) float32, scaled
    """

    given: Frames
    lengths: torch.Tensor
    targets: torch.Tensor

    def frames(self) -> Frames:
        """The frames that outputs are asked for."""
        return self.given

    def laid_out(self, outputs: torch.Tensor) -> torch.Tensor:
        """Outputs (B, N) of the frames as those of utterances, (B, 1, N)."""
        return outputs[:, None]


@dataclass(frozen=True)
class FrameStore:
    """All frames of a corpus in memory, in the smallest types that hold them; windows are cut as they are needed.

    Parameters
    ----------
    index : (F, C) classes, in bytes where all inventories fit one
    values : (F, D) float32
    targets : (F, N) float32, scaled
    bounds : (M + 1,) int64, first frame of each utterance, and F
    """

    index: torch.Tensor
    values: torch.Tensor
    targets: torch.Tensor
    bounds: torch.Tensor

    @classmethod
    def of(
        cls,
        examples: Sequence[Example],
        lengths: np.ndarray,
        layouts: Sequence[Layout],
        mean: np.ndarray,
        scale: np.ndarray,
    ) -> "FrameStore":
        """The frames of utterances, each of which is read once.

        Parameters
        ----------
        examples : utterances, with ``lengths`` (M,)
        layouts : of their streams
        mean, scale : (N,); targets are kept as (target - mean) / scale
        """
        total = int(lengths.sum())
        sizes = [size for layout in layouts for size in layout.sizes]
        index = np.zeros((total, len(sizes)), index_type(max(sizes, default=1)))
        values = np.zeros((total, sum(layout.dimension for layout in layouts)), np.float32)
        targets = np.zeros((total, len(mean)), np.float32)
        bounds = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
        for number, (first, end) in enumerate(zip(bounds[:-1], bounds[1:], strict=True)):
            example = examples[number]
            index[first:end], values[first:end] = joined(example.streams)
            targets[first:end] = (example.target - mean) / scale
        return cls(*(torch.from_numpy(one) for one in (index, values, targets, bounds)))

    def batches(self, size: int) -> Iterator[FrameBatch]:
        """All frames once, in an order by torch's random numbers, ``size`` at a time; the last batch may be smaller."""
        for at in torch.randperm(len(self.targets)).split(size):
            utterance = torch.searchsorted(self.bounds, at, right=True) - 1
            given = Frames(self.index, self.values, at, self.bounds[utterance], self.bounds[utterance + 1])
            yield FrameBatch(given, torch.ones_like(at), self.targets[at][:, None])


def index_type(classes: int) -> type:
    """The smallest type for the numbers of so many classes that torch reads."""
    return next(one for one in (np.uint8, np.int16, np.int32) if classes - 1 <= np.iinfo(one).max)
