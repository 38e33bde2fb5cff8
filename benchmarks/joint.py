"""Parameters and training speed of joint and separate networks, in frames per second of processor time.

Run: python -m benchmarks.joint [NODES] [ROUNDS]

Networks of NODES (128) units on 44 random inputs and 138 outputs in regions of 57, 36 and 45 (Sadoughi and Busso 2017),
on utterances of 360 frames in batches of at most 4,096. One thread; the median of ROUNDS (3) epochs of each, in turns.
A separate network counts a frame once, when the networks of all regions have seen it.
"""

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from benchmarks.command import run_main
from visualspeech.features.examples import Example
from visualspeech.features.streams import Layout, Stream
from visualspeech.models.joint import fit
from visualspeech.models.joint_settings import JointSettings, cell_name, parameter_count
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Task

UTTERANCES, FRAMES, INPUTS, OUTPUTS = 22, 360, 44, 138
REGIONS = {"upper": range(57), "middle": range(57, 93), "lower": range(93, 138)}
TRAINING = {"objective": "ccc", "batcher": "frames", "max_epochs": 1, "dropout": 0.2, "scaling": "none"}


@dataclass(frozen=True)
class Values:
    """A block of real values, as far as training asks."""

    kind: ClassVar[str] = "values"
    layout: ClassVar[Layout] = Layout(dimension=INPUTS)


def data() -> list[Example]:
    """The utterances."""
    random = np.random.default_rng(1)
    size = (UTTERANCES, FRAMES)
    inputs = random.normal(size=(*size, INPUTS)).astype(np.float32)
    targets = random.normal(size=(*size, OUTPUTS)).astype(np.float32)
    return [Example((Stream(values=x),), y, 120.0) for x, y in zip(inputs, targets, strict=True)]


def seconds(settings: dict, examples: list[Example]) -> float:
    """Processor time of an epoch."""
    row = ModelRow("benchmark", "benchmark", "joint", settings, ("speech",), TRAINING)
    begin = time.process_time()
    fit(Task(row, {"speech": Values()}, examples, examples[:1], regions=REGIONS))
    return time.process_time() - begin


def main(nodes: int = 128, rounds: int = 3) -> None:
    examples = data()
    rows = [{"layers": layers, "nodes": nodes, "shared": shared} for layers in (1, 2) for shared in (0, 2)]
    taken = np.array([[seconds(row, examples) for row in rows] for _ in range(rounds + 1)][1:])
    for row, middle in zip(rows, np.median(taken, axis=0), strict=True):
        count = parameter_count(JointSettings(**row), [Values.layout], REGIONS)
        print(f"{cell_name(row)}: {count:,} parameters, {UTTERANCES * FRAMES / middle:,.0f} frames/s")


if __name__ == "__main__":
    run_main(main, __doc__)
