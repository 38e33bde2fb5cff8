"""Random utterances for measuring how fast networks train: labels of triphones and states, and targets."""

import numpy as np

from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task
from visualspeech.speech.phones import STATES

RATE = 25.0  # Hz


def examples(utterances: int, frames: int, phones: int, outputs: int, seed: int = 1) -> list[Example]:
    """Utterances of one length: random triphone states, targets (frames, outputs) of unit variance."""
    generator = np.random.default_rng(seed)
    labels = generator.integers(0, STATES, (utterances, frames, 4)).astype(np.int16)
    labels[:, :, :3] = generator.integers(0, phones, (utterances, frames, 3))
    targets = generator.normal(size=(utterances, frames, outputs)).astype(np.float32)
    return [Example((Stream(index=one),), target, RATE) for one, target in zip(labels, targets, strict=True)]


def block(phones: int) -> TriphoneState:
    """The input block that reads the labels of :func:`examples`."""
    return TriphoneState(tuple(map(str, range(phones))))


def task(settings: dict, training: dict, phones: int, learned: list[Example], validation: list[Example]) -> Task:
    """A stack of these settings to be trained on such utterances with these settings of training."""
    row = ModelRow("benchmark", "benchmark", "stack", settings, ("labels",), training)
    return Task(row, {"labels": block(phones)}, learned, validation)
