"""Frames per second of the gathered first layer beside the dense product, and of the training that it is part of.

Run: python -m benchmarks.gathered [NODES] [ROUNDS]

Input: phones and dynamic visemes in a window of 33 frames, five of each in context, positions, acoustic classes and
counts, of a simulated corpus. Layer: forward of a mini-batch of 1,024 frames into NODES units (1,024). The gathered
layer cuts its windows out of the flat corpus; the dense product is given its one-hot inputs ready made. Training: whole
epochs of a network of three hidden layers, with mini-batches of 100 and of 1,024 frames; there the dense layer makes
its one-hot inputs from the same windows. Each pair in turns, ROUNDS times (5), on one thread; processor time, which
other work on the machine changes little.
"""

import time
from collections.abc import Callable
from unittest import mock

import numpy as np
import torch
from torch.nn.functional import linear

from benchmarks.command import run_main
from benchmarks.contextual import BLOCKS, RATE, WINDOWS, Corpus, task
from visualspeech.models import dnn
from visualspeech.models.frames import Frames, FrameStore
from visualspeech.models.gathered import GatheredLinear
from visualspeech.models.network import layouts_of
from visualspeech.models.training import one_thread

BATCH, FRAMES, UTTERANCES, PART = 1024, 1000, 20, 4


class DenseLinear(GatheredLinear):
    """The same layer as a product with one-hot inputs."""

    def inputs(self, frames: Frames) -> torch.Tensor:
        """(M, width) of the M frames that are asked for."""
        rows, inside, values = self._inputs(frames)
        ones = torch.zeros(len(rows), len(self.classes))
        ones.scatter_(1, rows, inside.float())
        return torch.cat([ones, values], dim=1)

    def product(self, inputs: torch.Tensor) -> torch.Tensor:
        classes, values = inputs.split([len(self.classes), self.values.shape[1]], dim=1)
        return linear(classes, self.classes.T, self.bias) + linear(values, self.values)

    def forward(self, frames: Frames) -> torch.Tensor:
        return self.product(self.inputs(frames))


def seconds(function: Callable[[], object]) -> float:
    """Processor time of a call."""
    begin = time.process_time()
    function()
    return time.process_time() - begin


def pairs(rounds: int, one: Callable[[], object], other: Callable[[], object]) -> np.ndarray:
    """Seconds of both calls, (rounds, 2), in turns; the first turn does not count."""
    return np.array([(seconds(one), seconds(other)) for _ in range(rounds + 1)])[1:]


def shown(name: str, frames: int, times: np.ndarray) -> None:
    gathered, dense = frames / np.median(times, axis=0)
    ratio = np.median(times[:, 1] / times[:, 0])
    print(f"{name}: gathered {gathered:,.0f} frames/s, dense {dense:,.0f} frames/s, ratio {ratio:.1f}", flush=True)


def layer(nodes: int, rounds: int) -> None:
    """Print the forward pass of the first layer alone."""
    corpus, layouts = Corpus(UTTERANCES, FRAMES), layouts_of(BLOCKS, WINDOWS, RATE)
    lengths = np.full(UTTERANCES, FRAMES)
    outputs = corpus[0].target.shape[1]
    store = FrameStore.of(corpus, lengths, layouts, np.zeros(outputs), np.ones(outputs))
    gathered, dense = GatheredLinear(layouts, nodes), DenseLinear(layouts, nodes)
    dense.load_state_dict(gathered.state_dict())
    frames = next(store.batches(BATCH)).frames()
    with torch.inference_mode():
        ready = dense.inputs(frames)
        furthest = (gathered(frames) - dense.product(ready)).abs().max().item()
        print(f"{ready.shape[1]:,} inputs, {nodes:,} units; largest difference of an output {furthest:.1e}")
        repeated = range(5)
        times = pairs(
            rounds, lambda: [gathered(frames) for _ in repeated], lambda: [dense.product(ready) for _ in repeated]
        )
    shown("layer, forward", 5 * BATCH, times)


def training(nodes: int, rounds: int, batch: int) -> None:
    """Print whole epochs of training."""
    learned, validation = Corpus(PART, FRAMES), Corpus(1, 100, seed=2)
    given = task({"layers": 3, "nodes": nodes}, {"max_epochs": 1, "batch_frames": batch}, learned, validation)

    def dense():
        with mock.patch("visualspeech.models.dnn.GatheredLinear", DenseLinear):
            dnn.fit(given)

    shown(f"training, {batch:,} frames per update", PART * FRAMES, pairs(rounds, lambda: dnn.fit(given), dense))


def main(nodes: int = 1024, rounds: int = 5) -> None:
    with one_thread():
        layer(nodes, rounds)
        for batch in (100, BATCH):
            training(nodes, rounds, batch)


if __name__ == "__main__":
    run_main(main, __doc__)
