"""Processor time of a bidirectional layer beside torch's own on packed utterances of equal and of unequal lengths.

Run: python -m benchmarks.recurrent [NODES] [ROUNDS]

Forward and backward of a layer of NODES units (128) for eight utterances, on one thread, in turns, ROUNDS times (20).
Prints milliseconds of both and the median of their ratios; processor time, which other work on the machine changes
little.
"""

import time
from collections.abc import Callable

import numpy as np
import torch
from torch.nn.utils.rnn import PackedSequence, pack_padded_sequence

from benchmarks.command import run_main
from visualspeech.models.layers import BidirectionalLstm
from visualspeech.models.training import one_thread

LENGTHS = {
    "equal": [75] * 8,
    "unequal": [80, 79, 78, 76, 75, 74, 70, 68],
    "far apart": [120, 110, 100, 80, 70, 60, 50, 40],
}


def seconds(function: Callable[[torch.Tensor, torch.Tensor], torch.Tensor], packed: PackedSequence) -> float:
    """Processor time of outputs and gradients."""
    begin = time.process_time()
    function(packed.data, packed.batch_sizes).square().sum().backward()
    return time.process_time() - begin


def main(nodes: int = 128, rounds: int = 20) -> None:
    torch.manual_seed(1)
    own = BidirectionalLstm(nodes, nodes)
    plain = torch.nn.LSTM(nodes, nodes, batch_first=True, bidirectional=True)

    def torchs(frames: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
        return plain(PackedSequence(frames, counts))[0].data

    for name, lengths in LENGTHS.items():
        batch = torch.randn(len(lengths), max(lengths), nodes)
        packed = pack_padded_sequence(batch, torch.tensor(lengths), batch_first=True)
        packed = packed._replace(data=packed.data.requires_grad_())
        with one_thread():
            times = np.array([(seconds(own, packed), seconds(torchs, packed)) for _ in range(rounds + 1)])[1:]
        of_own, of_torch = np.median(times, axis=0) * 1e3
        ratio = np.median(times[:, 1] / times[:, 0])
        print(f"{name} lengths: {of_own:.1f} ms, torch's packed layer {of_torch:.1f} ms, ratio {ratio:.2f}")


if __name__ == "__main__":
    run_main(main, __doc__)
