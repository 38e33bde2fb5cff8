"""Feed-forward networks that predict each frame from windows of their inputs (Thangthai et al. 2016, section 2)."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import torch
from torch import nn

from visualspeech.features.streams import Layout
from visualspeech.models.batches import Batch
from visualspeech.models.dnn_settings import DnnSettings
from visualspeech.models.fitting import fit_network
from visualspeech.models.frames import FrameBatch
from visualspeech.models.gathered import GatheredLinear
from visualspeech.models.layers import dropped
from visualspeech.models.network import Network, restore_network
from visualspeech.models.task import Fitted, Task
from visualspeech.models.training_settings import training_settings
from visualspeech.provenance import code_digest

FAMILY = "dnn"
_ACTIVATIONS = {"tanh": torch.tanh, "sigmoid": torch.sigmoid, "relu": torch.relu}


class Dnn(nn.Module):
    """Hidden layers of one width and a linear output layer; the first one gathers its inputs.

    Parameters
    ----------
    settings : the hidden layers
    layouts : columns and windows of the input streams
    outputs : dimension N of the targets
    dropout : share of hidden values set to zero in training
    """

    def __init__(self, settings: DnnSettings, layouts: Sequence[Layout], outputs: int, dropout: float = 0.0) -> None:
        super().__init__()
        nodes = settings.nodes
        self.activation, self.dropout = _ACTIVATIONS[settings.activation], dropout
        self.layers = nn.ModuleList([GatheredLinear(layouts, nodes)])
        self.layers.extend(nn.Linear(nodes, nodes) for _ in range(settings.layers - 1))
        self.output = nn.Linear(nodes, outputs)

    def forward(self, batch: Batch | FrameBatch) -> torch.Tensor:
        """Outputs (B, T, N) of a batch of utterances, zero in padded frames, or (B, 1, N) of single frames."""
        hidden = batch.frames()
        for layer in self.layers:
            hidden = self.activation(layer(hidden))
            hidden = dropped(hidden, self.dropout) if self.training else hidden
        return batch.laid_out(self.output(hidden))


def fit(task: Task) -> Fitted:
    """Train the network that the row asks for; raises as :func:`visualspeech.models.fitting.fit_network`."""
    settings = DnnSettings(**task.row.settings)
    training = training_settings({**task.row.training, "seed": task.row.seed})

    def build(layouts: Sequence[Layout], outputs: int) -> Dnn:
        return Dnn(settings, layouts, outputs, training.dropout)

    return fit_network(task, FAMILY, settings, training, build, [code_digest(__file__)])


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Network:
    """The network in a file's content; raises as :func:`visualspeech.models.network.restore_network`."""

    def build(own: Mapping, layouts: Sequence[Layout], outputs: int) -> Dnn:
        return Dnn(DnnSettings(**own), layouts, outputs)

    return restore_network(arrays, settings, path, FAMILY, build, weight_shapes)


def weight_shapes(settings: Mapping, layouts: Sequence[Layout], outputs: int) -> dict[str, tuple[int, ...]]:
    """Shape of each weight of a :class:`Dnn` by name, without making one.

    Raises
    ------
    SettingError, TypeError
        The settings are none of such a network.
    """
    made = DnnSettings(**settings)
    shapes = {f"layers.0.{name}": shape for name, shape in GatheredLinear.shapes(layouts, made.nodes).items()}
    for number in range(1, made.layers):
        shapes |= {f"layers.{number}.weight": (made.nodes, made.nodes), f"layers.{number}.bias": (made.nodes,)}
    return shapes | {"output.weight": (outputs, made.nodes), "output.bias": (outputs,)}
