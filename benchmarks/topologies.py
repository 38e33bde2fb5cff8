"""Processor time of training each network of Table 2, and what all of them cost on a corpus of a given size.

Run: python -m benchmarks.topologies [frames of the training set] [epochs]

One epoch of each stack and width over the same synthetic utterances, the faster of two, on one thread; processor time,
so that other work on the machine matters little. Utterances have 75 frames, labels 3 x 32 + 3 entries, faces 80
parameters. Prints a row a stack: microseconds a frame and epoch at 128, 256 and 512 nodes, and weights in thousands;
then the hours of all 42 networks for the given corpus (default 23,550 frames, 40 epochs: GRID 400).
"""

import sys
import time

import numpy as np
from visualspeech.models.blstm import Stack, StackSettings

from visualspeech.evaluation.published_results import published
from visualspeech.models.training import train, training_settings

UTTERANCES, FRAMES, PHONES, OUTPUTS = 32, 75, 32, 80


def data(seed: int = 1) -> list[tuple[np.ndarray, np.ndarray]]:
    generator = np.random.default_rng(seed)
    labels = generator.integers(0, 3, (UTTERANCES, FRAMES, 4)).astype(np.int16)
    labels[:, :, :3] = generator.integers(0, PHONES, (UTTERANCES, FRAMES, 3))
    return list(zip(labels, generator.normal(size=(UTTERANCES, FRAMES, OUTPUTS)).astype(np.float32), strict=True))


def microseconds(stack: StackSettings, utterances) -> float:
    """Processor time of an epoch with its validation of a tenth, a training frame."""
    times = []
    for _ in range(2):
        start = time.process_time()
        train(stack, range(PHONES), utterances, utterances[:3], 25.0, training_settings(max_epochs=1))
        times.append(time.process_time() - start)
    return 1e6 * min(times) / (UTTERANCES * FRAMES)


def main(frames: int = 23_550, epochs: int = 40) -> None:
    paper, utterances = published("fan2015"), data()
    microseconds(StackSettings("F", 16), utterances)
    total = dict.fromkeys(paper.nodes, 0.0)
    for letters in sorted(paper.stacks, key=lambda name: (len(name), name)):
        row = []
        for nodes in paper.nodes:
            stack = StackSettings(letters, nodes)
            found = microseconds(stack, utterances)
            weights = sum(values.numel() for values in Stack(stack, PHONES, OUTPUTS).parameters())
            total[nodes] += found
            row.append(f"{found:8.0f} us {weights / 1000:6.0f}k")
        print(f"{letters:4}", *row, flush=True)
    for nodes, found in total.items():
        print(f"14 networks of {nodes} nodes: {1e-6 * found * frames * epochs / 3600:.2f} hours of one core")
    whole = 1e-6 * sum(total.values()) * frames * epochs / 3600
    print(
        f"all {len(paper.stacks) * len(paper.nodes)}, {frames} frames, {epochs} epochs: {whole:.2f} hours of one core"
    )


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
