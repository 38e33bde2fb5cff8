"""Stacks of feed-forward (F) and bidirectional LSTM (B) layers, named by their letters: FBB, BFF, ... (Fan 2015, 4)."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate

import torch
from torch import nn
from torch.nn.utils.rnn import PackedSequence, pack_padded_sequence, pad_packed_sequence

from visualspeech.errors import SettingError
from visualspeech.naming import parse_name
from visualspeech.speech.phones import STATES

WIDTHS = ("direction", "layer")


@dataclass(frozen=True)
class StackSettings:
    """Hidden layers of a network.

    Parameters
    ----------
    letters : one letter a hidden layer, from the input up: F feed-forward (tanh), B bidirectional LSTM
    nodes : width of a layer: nodes of F, nodes of B as ``b_nodes`` says
    b_nodes : what the width of a B layer counts: the nodes of one ``direction`` (it hands twice as many on), or those
        of the whole ``layer`` (half of them a direction). Fan 2015 does not say; Sadoughi and Busso (2017) count
        directions
    """

    letters: str = "FBB"
    nodes: int = 128
    b_nodes: str = "direction"

    def __post_init__(self) -> None:
        if not re.fullmatch("[FB]+", str(self.letters)):
            raise SettingError(
                f"`networks.stacks: {self.letters}`: a stack is named by the letters F (feed-forward) and B (BLSTM), "
                "one a hidden layer from the input up, for example FBB."
            )
        if not isinstance(self.nodes, int) or isinstance(self.nodes, bool) or self.nodes < 1:
            raise SettingError(f"`networks.nodes: {self.nodes}` must be a whole number of at least 1, for example 128.")
        if self.b_nodes not in WIDTHS:
            raise SettingError(f"`networks.b_nodes: {self.b_nodes}` must be one of {', '.join(WIDTHS)}.")
        if self.b_nodes == "layer" and "B" in self.letters and self.nodes % 2:
            raise SettingError(
                f"`networks.nodes: {self.nodes}` is odd; with `networks.b_nodes: layer` the two directions of a B "
                "layer share its nodes. Give an even number."
            )

    @property
    def direction_nodes(self) -> int:
        """Nodes of one direction of a B layer."""
        return self.nodes if self.b_nodes == "direction" else self.nodes // 2

    @property
    def name(self) -> str:
        return f"{self.letters}-{self.nodes}"


def parse_stack(name: str, b_nodes: str = "direction") -> StackSettings:
    """Settings of a stack from its name (:mod:`visualspeech.naming`): ``FBB-128``.

    Raises
    ------
    SettingError
        The name has no such form, or no such stack can be.
    """
    parts = parse_name(name)
    return StackSettings(parts.letters, parts.nodes, b_nodes)


class Stack(nn.Module):
    """A stack over label indices, with a linear output layer (Fan 2015, Fig. 3 and Eq. 12).

    Utterances of one batch (N of them, T = the longest) may have different lengths: padded frames reach neither
    direction of a BLSTM layer, and the output there is zero.

    Parameters
    ----------
    settings : the hidden layers
    phones, outputs : size K of the inventory, dimension N of the appearance
    dropout : share of hidden values set to zero in training
    parts : number of values of each part that labels have beyond the paper's four
    """

    def __init__(
        self, settings: StackSettings, phones: int, outputs: int, dropout: float = 0.0, parts: Sequence[int] = ()
    ) -> None:
        super().__init__()
        sizes = [phones, phones, phones, STATES, *parts]
        self.offsets = torch.tensor([0, *accumulate(sizes[:-1])])
        self.inputs = sum(sizes)
        self.letters = settings.letters
        self.dropout = dropout
        self.layers = nn.ModuleList()
        width = self.inputs
        for letter in settings.letters:
            if letter == "F":
                self.layers.append(nn.Linear(width, settings.nodes))
                width = settings.nodes
            else:
                self.layers.append(nn.LSTM(width, settings.direction_nodes, batch_first=True, bidirectional=True))
                width = 2 * settings.direction_nodes
        self.output = nn.Linear(width, outputs)

    def forward(self, labels: torch.Tensor, lengths: torch.Tensor) -> torch.Tensor:
        """Labels (N, T, 4 + parts) int64 and lengths (N,) int64, descending, to outputs (N, T, outputs)."""
        packed = pack_padded_sequence(labels, lengths, batch_first=True)
        # From here on only real frames exist: (frames of the batch, features), in the packed order.
        frames = self.encode(packed.data)
        for letter, layer in zip(self.letters, self.layers, strict=True):
            if letter == "F":
                frames = torch.tanh(layer(frames))
            else:
                frames = layer(PackedSequence(frames, packed.batch_sizes))[0].data
            if self.training and self.dropout:
                frames = dropped(frames, self.dropout)
        values = PackedSequence(self.output(frames), packed.batch_sizes)
        return pad_packed_sequence(values, batch_first=True, total_length=labels.shape[1])[0]

    def encode(self, labels: torch.Tensor) -> torch.Tensor:
        """One-hot vectors of label indices: (frames, 4) to the 3K + 3 of the paper (3.1); a part more, a block more."""
        ones = torch.zeros(len(labels), self.inputs, dtype=self.output.weight.dtype)
        return ones.scatter_(1, labels + self.offsets, 1.0)


def dropped(values: torch.Tensor, share: float) -> torch.Tensor:
    """Values with a random share of them zero and the others larger by 1 / (1 - share), as in training with dropout.

    The same as :func:`torch.nn.functional.dropout` with other random numbers: uniform ones, which a processor draws
    three times as fast as torch's Bernoulli ones; those were a tenth of an update.
    """
    return values * torch.rand_like(values).ge_(share).mul_(1 / (1 - share))
