"""Small seeded utterances that a model can learn: appearance is a smoothed sum over the phones around a frame."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.examples import Example
from visualspeech.features.streams import Layout, Stream
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task

PHONES = ("sil", "a", "b", "c", "d", "e")
BLOCKS = {"tri": TriphoneState(PHONES)}
RATE = 25.0


@dataclass(frozen=True)
class Values:
    """A block of ``dimension`` real values and one class for each of ``sizes``, as far as training asks."""

    kind: ClassVar[str] = "values"

    dimension: int = 0
    sizes: tuple[int, ...] = ()

    @property
    def layout(self) -> Layout:
        return Layout(self.sizes, self.dimension)


def utterances(number, seed=0, outputs=4, frames=(12, 30), noise=0.1):
    """Utterances of one stream, of the block in ``BLOCKS``."""
    table = np.random.default_rng(99).normal(size=(len(PHONES), outputs))
    generator = np.random.default_rng(seed)
    result = []
    for _ in range(number):
        length = int(generator.integers(*frames))
        phones = generator.integers(0, len(PHONES), length // 6 + 2)
        triphones = np.stack([np.r_[0, phones[:-1]], phones, np.r_[phones[1:], 0]], axis=1)
        states = np.tile(np.repeat([0, 1, 2], 2), len(phones))
        labels = np.column_stack([np.repeat(triphones, 6, axis=0), states])[:length].astype(np.int16)
        values = table[labels[:, 1]] + 0.5 * table[labels[:, 0]] + 0.5 * table[labels[:, 2]]
        values = 10 * (values + noise * generator.normal(size=values.shape)) + 3
        result.append(Example((Stream(index=labels),), values.astype(np.float32), RATE))
    return result


def with_stream(examples, streams):
    """The same utterances with one more stream each."""
    return [one._replace(streams=(*one.streams, stream)) for one, stream in zip(examples, streams, strict=True)]


def task(family, settings=None, training=(), validation=(), blocks=None, options=None, seed=1, **more):
    """A task of one row; ``options`` are its settings of training, ``more`` goes to the task."""
    blocks = BLOCKS if blocks is None else blocks
    row = ModelRow("model", "Model", family, settings or {}, tuple(blocks), options or {}, seed)
    return Task(row, blocks, training, validation, **more)
