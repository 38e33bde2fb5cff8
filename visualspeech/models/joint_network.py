"""Networks with a linear output layer per region of the face (Sadoughi and Busso 2017, Fig. 3 and 4).

From the input up: a feed-forward layer of rectified linear units, BLSTM layers, a linear layer per region. The first
``shared`` hidden layers are common to all regions, the others each region has for itself.
"""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import torch
from torch import nn
from torch.nn.utils.rnn import PackedSequence, pack_padded_sequence, pad_packed_sequence

from visualspeech.features.streams import Layout
from visualspeech.models.batches import Batch
from visualspeech.models.gathered import GatheredLinear
from visualspeech.models.joint_settings import JointSettings, check_regions
from visualspeech.models.layers import BidirectionalLstm, dropped
from visualspeech.models.trajectory.windows import WINDOWS


class Blstm(nn.Module):
    """A bidirectional LSTM layer with one bias vector per gate, as in Keras, which the paper used; torch has two.

    Every frame has a constant 1 behind its values: the last column of ``weight_ih`` is the bias.

    Parameters
    ----------
    width : of the input
    nodes : of each direction; outputs are those of both, forward first
    """

    def __init__(self, width: int, nodes: int) -> None:
        super().__init__()
        self.lstm = BidirectionalLstm(width + 1, nodes, bias=False)

    def forward(self, frames: torch.Tensor, counts: torch.Tensor) -> torch.Tensor:
        """Outputs (frames, 2 nodes) of (frames, width) in packed order (:mod:`visualspeech.models.layers`)."""
        return self.lstm(torch.cat([frames, frames.new_ones(len(frames), 1)], dim=1), counts)

    @staticmethod
    def shapes(width: int, nodes: int) -> dict[str, tuple[int, ...]]:
        """Shape of each weight by name, without making a layer."""
        own = {"weight_ih_l0": (4 * nodes, width + 1), "weight_hh_l0": (4 * nodes, nodes)}
        return {f"lstm.{name}{way}": shape for way in ("", "_reverse") for name, shape in own.items()}


class Joint(nn.Module):
    """A network whose regions share their first hidden layers, or none.

    Parameters
    ----------
    settings : the hidden layers
    layouts : columns and windows of the input streams
    regions : columns of the outputs by region; each column is in one
    dropout : share of hidden values set to zero in training, after each hidden layer
    """

    def __init__(
        self,
        settings: JointSettings,
        layouts: Sequence[Layout],
        regions: Mapping[str, Sequence[int]],
        dropout: float = 0.0,
    ) -> None:
        super().__init__()
        nodes, hidden = settings.nodes, settings.layers + 1
        widths = [nodes, *[2 * nodes] * settings.layers]

        def made(numbers) -> list[nn.Module]:
            return [Blstm(widths[n - 1], nodes) if n else GatheredLinear(layouts, nodes) for n in numbers]

        self.dropout = dropout
        self.shared = nn.ModuleList(made(range(settings.shared)))
        self.regions = nn.ModuleList(
            nn.ModuleList([*made(range(settings.shared, hidden)), nn.Linear(widths[-1], len(columns))])
            for columns in regions.values()
        )
        # Where each output is among those of all regions side by side.
        self.places = torch.tensor([column for columns in regions.values() for column in columns]).argsort()
        if settings.initialisation == "glorot":
            initialise(self, sum(layout.width for layout in layouts))

    def forward(self, batch: Batch) -> torch.Tensor:
        """Outputs (B, T, N) of a batch, zero in padded frames."""
        length, found = batch.index.shape[1], []
        counts = (torch.arange(length)[:, None] < batch.lengths).sum(dim=1)
        common = self._through(self.shared, None, batch, counts)
        for *layers, output in self.regions:
            found.append(output(self._through(layers, common, batch, counts)))
        values = PackedSequence(torch.cat(found, dim=1)[:, self.places], counts)
        return pad_packed_sequence(values, batch_first=True, total_length=length)[0]

    def _through(
        self, layers: Iterable[nn.Module], frames: torch.Tensor | None, batch: Batch, counts: torch.Tensor
    ) -> torch.Tensor | None:
        """Outputs (frames, nodes) in packed order of hidden layers; the first layer of all reads the batch itself."""
        for layer in layers:
            if isinstance(layer, GatheredLinear):
                rows = batch.laid_out(torch.relu(layer(batch.frames())))
                frames = pack_padded_sequence(rows, batch.lengths, batch_first=True).data
            else:
                frames = layer(frames, counts)
            frames = dropped(frames, self.dropout) if self.training else frames
        return frames


def initialise(module: nn.Module, inputs: int) -> None:
    """Draw all weights as Glorot and Bengio (2010), Eq. 16; biases are 0, those of forget gates 1.

    As Keras, the gates of an LSTM count as one matrix: of ``nodes`` inputs, it has 4 ``nodes`` outputs.

    Parameters
    ----------
    inputs : of the first layer
    """

    def draw(weights: torch.Tensor, width: int, outputs: int) -> None:
        nn.init.uniform_(weights, -np.sqrt(6 / (width + outputs)), np.sqrt(6 / (width + outputs)))

    with torch.no_grad():
        for layer in module.modules():
            if isinstance(layer, GatheredLinear):
                for name, weights in layer.named_parameters():
                    nn.init.zeros_(weights) if name == "bias" else draw(weights, inputs, len(layer.bias))
            elif isinstance(layer, nn.LSTM):
                nodes = layer.hidden_size
                for name, weights in layer.named_parameters():
                    draw(weights, weights.shape[1] - name.startswith("weight_ih"), 4 * nodes)
                    if name.startswith("weight_ih"):  # gates in torch's order: input, forget, cell, output
                        weights[:, -1] = 0
                        weights[nodes : 2 * nodes, -1] = 1
            elif isinstance(layer, nn.Linear):
                draw(layer.weight, layer.in_features, layer.out_features)
                nn.init.zeros_(layer.bias)


def output_columns(regions: Mapping[str, Sequence[int]], settings: JointSettings, outputs: int) -> dict[str, list[int]]:
    """Columns of a network's outputs by region, from those of the coding's parameters: its deltas are in its region.

    Regions come in the order of their names: a file does not keep another one.

    Raises
    ------
    ValueError
        As :func:`visualspeech.models.joint_settings.check_regions`, or the outputs are no values and their deltas.
    """
    kinds = len(WINDOWS) if settings.trajectory == "mlpg" else 1
    if outputs % kinds:
        raise ValueError(f"{outputs} outputs are no static, delta and delta-delta parameters")
    check_regions(regions, outputs // kinds)
    return {
        name: [kind * (outputs // kinds) + column for kind in range(kinds) for column in columns]
        for name, columns in sorted(regions.items())
    }


def stored(own: Mapping, outputs: int) -> tuple[JointSettings, dict[str, list[int]]]:
    """Settings of a file, and the columns of the outputs by region."""
    made = JointSettings(**{name: value for name, value in own.items() if name != "regions"})
    return made, output_columns(own.get("regions"), made, outputs)


def weight_shapes(settings: Mapping, layouts: Sequence[Layout], outputs: int) -> dict[str, tuple[int, ...]]:
    """Shape of each weight of a :class:`Joint` by name, without making one.

    Parameters
    ----------
    settings : as in a file, with ``regions``

    Raises
    ------
    SettingError, TypeError, ValueError
        The settings are none of such a network.
    """
    made, regions = stored(settings, outputs)
    nodes, shapes = made.nodes, {}
    for number in range(made.layers + 1):
        width = nodes if number == 1 else 2 * nodes
        own = Blstm.shapes(width, nodes) if number else GatheredLinear.shapes(layouts, nodes)
        shared = number < made.shared
        places = (
            [f"shared.{number}"] if shared else [f"regions.{n}.{number - made.shared}" for n in range(len(regions))]
        )
        shapes |= {f"{place}.{name}": shape for place in places for name, shape in own.items()}
    last = made.layers + 1 - made.shared
    for number, columns in enumerate(regions.values()):
        shapes[f"regions.{number}.{last}.weight"] = (len(columns), 2 * nodes)
        shapes[f"regions.{number}.{last}.bias"] = (len(columns),)
    return shapes
