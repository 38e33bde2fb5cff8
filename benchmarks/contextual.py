"""A simulated corpus with the contextual features of phones and dynamic visemes of Thangthai et al. 2016, Table 1."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.examples import Example
from visualspeech.features.streams import Layout, Stream
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task

RATE, WINDOW = 100.0, 0.16  # Hz; seconds before and after a frame
PHONES, VISEMES, CLASSES, OUTPUTS = 41, 160, 57, 90  # outputs are static, delta and delta-delta parameters
SEGMENT = 8  # frames of a phone, or of a dynamic viseme, on average
POSITIONS, NUMBERS = 12, 16  # of start, middle, end; counts and spans


@dataclass(frozen=True)
class Simulated:
    """A block with the columns ``layout``."""

    layout: Layout
    kind: ClassVar[str] = "simulated"


BLOCKS = {
    "ph": Simulated(Layout((PHONES,))),
    "dv": Simulated(Layout((VISEMES,))),
    "contexts": Simulated(Layout((PHONES,) * 5 + (VISEMES,) * 5 + (3,) * POSITIONS)),
    "values": Simulated(Layout((), CLASSES + NUMBERS)),
}
WINDOWS = {"ph": WINDOW, "dv": WINDOW}


class Corpus(Sequence):
    """Utterances of random segments; the first ones again and again, so that a long corpus takes no memory.

    Parameters
    ----------
    count, frames : utterances, and frames of each
    seed : of all of them
    different : number of different ones at most
    """

    def __init__(self, count: int, frames: int, seed: int = 1, different: int = 32) -> None:
        self.count = count
        self.utterances = [_utterance(frames, [seed, number]) for number in range(min(count, different))]

    def __len__(self) -> int:
        return self.count

    def __getitem__(self, number: int) -> Example:
        if not 0 <= number < self.count:
            raise IndexError(number)
        return self.utterances[number % len(self.utterances)]


def _utterance(frames: int, seed: list[int]) -> Example:
    random = np.random.default_rng(seed)
    segment = np.cumsum(random.random(frames) < 1 / SEGMENT)

    def classes(*sizes):
        drawn = [random.integers(0, size, segment[-1] + 1, dtype=np.uint8) for size in sizes]
        return np.stack(drawn, axis=1)[segment]

    values = random.random((segment[-1] + 1, CLASSES + NUMBERS), np.float32)[segment]
    streams = [Stream(index=classes(*BLOCKS[name].layout.sizes)) for name in ("ph", "dv", "contexts")]
    target = random.standard_normal((frames, OUTPUTS), np.float32)
    return Example((*streams, Stream(values=values)), target, RATE)


def task(settings: dict, training: dict, learned: Sequence[Example], validation: Sequence[Example]) -> Task:
    """A network of these settings to be trained on such utterances with these settings of training."""
    own = {"batcher": "shuffled_frames", "objective": "mse", "scaling": "dimension", **training}
    row = ModelRow("benchmark", "benchmark", "dnn", settings, tuple(BLOCKS), own, windows=WINDOWS)
    return Task(row, BLOCKS, learned, validation)
