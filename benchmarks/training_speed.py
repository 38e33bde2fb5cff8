"""Frames a second of training FBB-128 beside a bare torch loop over the same batches.

Run: python benchmarks/training_speed.py

The bare loop has the same layers on ready-made one-hot tensors without padding, and no validation, checkpoint or
clipping, so the ratio is what everything else costs. Both in one process, on one thread, in turns.
"""

import time

import numpy as np
import torch
from torch import nn

from visualspeech.features.labels import one_hot
from visualspeech.models.blstm import StackSettings
from visualspeech.models.network import one_thread
from visualspeech.models.training import train, training_settings

UTTERANCES, FRAMES, PHONES, OUTPUTS, ROUNDS = 160, 75, 40, 80, 3


def data(seed: int = 1) -> list[tuple[np.ndarray, np.ndarray]]:
    generator = np.random.default_rng(seed)
    labels = generator.integers(0, 3, (UTTERANCES, FRAMES, 4)).astype(np.int16)
    labels[:, :, :3] = generator.integers(0, PHONES, (UTTERANCES, FRAMES, 3))
    return list(zip(labels, generator.normal(size=(UTTERANCES, FRAMES, OUTPUTS)).astype(np.float32), strict=True))


class Bare(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(3 * PHONES + 3, 128)
        self.blstm = nn.LSTM(128, 128, num_layers=2, batch_first=True, bidirectional=True)
        self.last = nn.Linear(256, OUTPUTS)

    def forward(self, frames):
        return self.last(self.blstm(torch.tanh(self.first(frames)))[0])


def bare_epoch(utterances, batch: int) -> float:
    torch.manual_seed(1)
    model = Bare()
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-3)
    inputs = torch.tensor(one_hot(np.stack([labels for labels, _ in utterances]), PHONES))
    targets = torch.tensor(np.stack([values for _, values in utterances]))
    start = time.perf_counter()
    for first in range(0, UTTERANCES, batch):
        optimiser.zero_grad()
        (0.5 * (model(inputs[first : first + batch]) - targets[first : first + batch]).square().sum()).backward()
        optimiser.step()
    return time.perf_counter() - start


def our_epoch(utterances, batch: int) -> float:
    settings = training_settings(max_epochs=1, batch=batch)
    result = train(StackSettings("FBB", 128), range(PHONES), utterances, utterances[:1], 25.0, settings)
    return result.curve[0][3]


def main() -> None:
    utterances = data()
    with one_thread():
        for batch in (4, 8, 16):
            pairs = [(our_epoch(utterances, batch), bare_epoch(utterances, batch)) for _ in range(ROUNDS + 1)][1:]
            ours, bare = np.median(pairs, axis=0)
            frames = UTTERANCES * FRAMES
            print(
                f"batch {batch}: ours {frames / ours:,.0f} frames/s, bare loop {frames / bare:,.0f} frames/s, "
                f"ratio {np.median([b / o for o, b in pairs]):.2f}"
            )


if __name__ == "__main__":
    main()
