"""Stacks of feed-forward (F), bidirectional LSTM (B) and gated convolutional (C) layers, named by their letters.

FBB, BFF, ... are those of Fan 2015, section 4; C is a layer of WaveNet (van den Oord et al. 2016). Windows of inputs
are read by the first layer, which must be F.
"""

from collections.abc import Mapping, Sequence
from itertools import accumulate
from pathlib import Path

import numpy as np
import torch
from torch import nn
from torch.nn.utils.rnn import PackedSequence, pack_padded_sequence, pad_packed_sequence

from visualspeech.features.streams import Layout
from visualspeech.fields import setting_error
from visualspeech.models.batches import Batch
from visualspeech.models.fitting import fit_network
from visualspeech.models.gathered import GatheredLinear
from visualspeech.models.layers import BidirectionalLstm, GatedConvolution, dilations, dropped
from visualspeech.models.network import Network, restore_network
from visualspeech.models.stack_settings import StackSettings
from visualspeech.models.task import Fitted, Task
from visualspeech.models.training_settings import training_settings
from visualspeech.provenance import code_digest
from visualspeech.storage.models import read_model

FAMILY = "stack"


class Stack(nn.Module):
    """A stack over one-hot and real-valued inputs, with a linear output layer (Fan 2015, Fig. 3 and Eq. 12).

    Utterances of one batch (B of them, T = the longest) may have different lengths: padded frames reach no layer, and
    the output there is zero.

    Parameters
    ----------
    settings : the hidden layers
    layouts : columns and windows of the input streams; the classes of all of them come first, then their values
    outputs : dimension N of the targets
    dropout : share of hidden values set to zero in training
    """

    def __init__(self, settings: StackSettings, layouts: Sequence[Layout], outputs: int, dropout: float = 0.0) -> None:
        super().__init__()
        self.gathers = reads_windows(settings, layouts)
        sizes = [size for layout in layouts for size in layout.sizes]
        self.offsets = torch.tensor([0, *accumulate(sizes[:-1])][: len(sizes)], dtype=torch.int64)
        self.classes = sum(sizes)
        self.letters = settings.letters
        self.dropout = dropout
        self.layers = nn.ModuleList()
        width = sum(layout.width for layout in layouts)
        for letter, dilation in zip(settings.letters, dilations(settings.letters), strict=True):
            if letter == "F":
                gathered = self.gathers and not self.layers
                layer = GatheredLinear(layouts, settings.nodes) if gathered else nn.Linear(width, settings.nodes)
                self.layers.append(layer)
                width = settings.nodes
            elif letter == "C":
                self.layers.append(GatedConvolution(width, settings.nodes, dilation, dropout))
                width = settings.nodes
            else:
                self.layers.append(BidirectionalLstm(width, settings.direction_nodes))
                width = 2 * settings.direction_nodes
        self.output = nn.Linear(width, outputs)

    def forward(self, batch: Batch) -> torch.Tensor:
        """Outputs (B, T, N) of a batch."""
        packed, layers = self._inputs(batch), list(zip(self.letters, self.layers, strict=True))
        # From here on only real frames exist: (frames of the batch, features), in the packed order.
        frames = packed.data
        if self.gathers:
            frames, layers = self._activated(frames), layers[1:]
        for letter, layer in layers:
            if letter == "C":
                frames = layer(frames, packed.batch_sizes)
            elif letter == "F":
                frames = self._activated(layer(frames))
            else:
                frames = layer(frames, packed.batch_sizes)
                frames = dropped(frames, self.dropout) if self.training else frames
        values = PackedSequence(self.output(frames), packed.batch_sizes)
        return pad_packed_sequence(values, batch_first=True, total_length=batch.index.shape[1])[0]

    def _activated(self, frames: torch.Tensor) -> torch.Tensor:
        frames = torch.tanh(frames)
        return dropped(frames, self.dropout) if self.training else frames

    def _inputs(self, batch: Batch) -> PackedSequence:
        """What the first layer reads, or if it gathers windows, what it makes of them before its non-linearity."""
        if self.gathers:
            first = batch.laid_out(self.layers[0](batch.frames()))
            return pack_padded_sequence(first, batch.lengths, batch_first=True)
        inputs = []
        if self.classes:
            packed = pack_padded_sequence(batch.index, batch.lengths, batch_first=True)
            inputs.append(self.encode(packed.data))
        if batch.values.shape[2]:
            packed = pack_padded_sequence(batch.values, batch.lengths, batch_first=True)
            inputs.append(packed.data)
        frames = torch.cat(inputs, dim=1) if len(inputs) > 1 else inputs[0]
        return PackedSequence(frames, packed.batch_sizes)

    def encode(self, index: torch.Tensor) -> torch.Tensor:
        """One-hot vectors of class indices side by side: (frames, C) to (frames, classes); 3K + 3 in Fan 2015, 3.1."""
        ones = torch.zeros(len(index), self.classes, dtype=self.output.weight.dtype)
        return ones.scatter_(1, index + self.offsets, 1.0)


def fit(task: Task) -> Fitted:
    """Train the stack of a row.

    Raises
    ------
    DataError, SettingError
        As :func:`visualspeech.models.fitting.fit_network`.
    """
    settings = StackSettings(**task.row.settings)
    training = training_settings(task.row.training, seed=task.row.seed)

    def build(layouts: Sequence[Layout], outputs: int) -> Stack:
        return Stack(settings, layouts, outputs, training.dropout)

    return fit_network(task, FAMILY, settings, training, build, [code_digest(__file__)])


def load(path: str | Path) -> Network:
    """Read a saved stack; raises as :func:`visualspeech.models.network.restore_network`."""
    return restore(*read_model(path), path)


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Network:
    """The stack in a file's content; raises as :func:`visualspeech.models.network.restore_network`."""

    def build(own: Mapping, layouts: Sequence[Layout], outputs: int) -> Stack:
        return Stack(StackSettings(**own), layouts, outputs)

    return restore_network(arrays, settings, path, FAMILY, build, weight_shapes)


def reads_windows(settings: StackSettings, layouts: Sequence[Layout]) -> bool:
    """Whether an input has a window.

    Raises
    ------
    SettingError
        It has, and the first layer is not a feed-forward one.
    """
    if not any(layout.window for layout in layouts):
        return False
    if not settings.letters.startswith("F"):
        rule = "letters of which the first is F, which reads windows of inputs"
        raise setting_error(StackSettings, "letters", settings.letters, rule)
    return True


def weight_shapes(settings: Mapping, layouts: Sequence[Layout], outputs: int) -> dict[str, tuple[int, ...]]:
    """Shape of each weight of a :class:`Stack` by name, without making one.

    Raises
    ------
    SettingError, TypeError
        The settings are none of a stack.
    """
    made, width, shapes = StackSettings(**settings), sum(layout.width for layout in layouts), {}
    gathers = reads_windows(made, layouts)
    for number, letter in enumerate(made.letters):
        if gathers and not number:
            own = GatheredLinear.shapes(layouts, made.nodes)
            shapes |= {f"layers.0.{name}": shape for name, shape in own.items()}
            width = made.nodes
            continue
        if letter == "F":
            shapes |= {f"layers.{number}.weight": (made.nodes, width), f"layers.{number}.bias": (made.nodes,)}
            width = made.nodes
            continue
        if letter == "C":
            own = GatedConvolution.shapes(width, made.nodes)
            shapes |= {f"layers.{number}.{name}": shape for name, shape in own.items()}
            width = made.nodes
            continue
        gates = 4 * made.direction_nodes
        own = {"weight_ih": (gates, width), "weight_hh": (gates, made.direction_nodes), "bias_ih": (gates,)}
        for name, shape in {**own, "bias_hh": (gates,)}.items():
            shapes |= {f"layers.{number}.{name}_l0{direction}": shape for direction in ("", "_reverse")}
        width = 2 * made.direction_nodes
    return shapes | {"output.weight": (outputs, width), "output.bias": (outputs,)}
