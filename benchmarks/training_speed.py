"""Frames per second of training FBB-128 beside a bare torch loop over the same batches; two threads beside two jobs.

Run: python -m benchmarks.training_speed [ROUNDS]

The bare loop has the same layers on prepared one-hot tensors without padding, and no dropout, validation, checkpoint or
gradient clipping, so the ratio is what everything else costs. Both in one process, on one thread, in turns, ROUNDS
times (5); prints the median ratio of the pairs, of wall clock and of processor time (which other work on the machine
changes less). Then two networks: two jobs of one thread side by side, as the workflow trains them, beside one job after
the other on two threads.
"""

import multiprocessing
import time
from contextlib import contextmanager
from unittest import mock

import numpy as np
import torch
from torch import nn

from benchmarks.command import run_main
from benchmarks.synthetic import examples, task
from visualspeech.features.labels import one_hot
from visualspeech.models.stack import fit
from visualspeech.models.training import one_thread

UTTERANCES, FRAMES, PHONES, OUTPUTS = 160, 75, 40, 80


def data() -> list:
    """The utterances."""
    return examples(UTTERANCES, FRAMES, PHONES, OUTPUTS)


class Bare(nn.Module):
    def __init__(self) -> None:
        super().__init__()
        self.first = nn.Linear(3 * PHONES + 3, 128)
        self.blstm = nn.LSTM(128, 128, num_layers=2, batch_first=True, bidirectional=True)
        self.last = nn.Linear(256, OUTPUTS)

    def forward(self, frames):
        return self.last(self.blstm(torch.tanh(self.first(frames)))[0])


def clocks() -> np.ndarray:
    """Seconds of wall clock and of this process's processor time."""
    return np.array([time.perf_counter(), time.process_time()])


def bare_epoch(utterances, batch: int) -> np.ndarray:
    torch.manual_seed(1)
    model = Bare()
    optimiser = torch.optim.Adam(model.parameters(), lr=1e-3)
    inputs = torch.tensor(one_hot(np.stack([one.streams[0].index for one in utterances]), PHONES))
    targets = torch.tensor(np.stack([one.target for one in utterances]))
    begin = clocks()
    for first in range(0, UTTERANCES, batch):
        optimiser.zero_grad()
        (0.5 * (model(inputs[first : first + batch]) - targets[first : first + batch]).square().sum()).backward()
        optimiser.step()
    return clocks() - begin


def our_epoch(utterances, batch: int, epochs: int = 1) -> np.ndarray:
    training = {"max_epochs": epochs, "batch_size": batch}
    given = task({"letters": "FBB", "nodes": 128}, training, PHONES, utterances, utterances[:1])
    begin = clocks()
    fit(given)
    return clocks() - begin


@contextmanager
def two_threads():
    before = torch.get_num_threads()
    torch.set_num_threads(2)
    yield
    torch.set_num_threads(before)


def one_job(barrier) -> None:
    utterances = data()
    our_epoch(utterances, 8)
    barrier.wait()
    our_epoch(utterances, 8, 2)
    barrier.wait()


def two_jobs() -> float:
    """Seconds of two networks that are trained side by side, each on one thread."""
    context = multiprocessing.get_context("spawn")
    barrier = context.Barrier(3)
    jobs = [context.Process(target=one_job, args=(barrier,)) for _ in range(2)]
    for job in jobs:
        job.start()
    barrier.wait()
    begin = time.perf_counter()
    barrier.wait()
    seconds = time.perf_counter() - begin
    for job in jobs:
        job.join()
    return seconds


def one_after_the_other() -> float:
    """Seconds of two networks that are trained one after the other, each on two threads."""
    utterances = data()
    with mock.patch("visualspeech.models.training.one_thread", two_threads):
        our_epoch(utterances, 8)
        return sum(our_epoch(utterances, 8, 2)[0] for _ in range(2))


def main(rounds: int = 5) -> None:
    utterances = data()
    with one_thread():
        for batch in (4, 8, 16):
            pairs = [(our_epoch(utterances, batch), bare_epoch(utterances, batch)) for _ in range(rounds + 1)][1:]
            ours, bare = np.median(pairs, axis=0)
            frames = UTTERANCES * FRAMES
            wall, processor = np.median([b / o for o, b in pairs], axis=0)
            print(
                f"batch {batch}: ours {frames / ours[0]:,.0f} frames/s, bare loop {frames / bare[0]:,.0f} frames/s, "
                f"ratio {wall:.2f} (of processor time {processor:.2f})"
            )
    pairs = [(two_jobs(), one_after_the_other()) for _ in range(min(3, rounds))]
    jobs, threads = np.median(pairs, axis=0)
    print(
        f"two networks: two jobs of one thread {jobs:.2f} s, two threads one after the other {threads:.2f} s, "
        f"ratio {np.median([t / j for j, t in pairs]):.2f}"
    )


if __name__ == "__main__":
    run_main(main, __doc__)
