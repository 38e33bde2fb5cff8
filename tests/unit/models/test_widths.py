"""What the width of a B layer means, in both readings, by its weights and through a saved network."""

from dataclasses import asdict

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS
from visualspeech.errors import SettingError
from visualspeech.features.streams import Layout, Stream
from visualspeech.models import stack
from visualspeech.models.batches import Scaling
from visualspeech.models.network import Network
from visualspeech.models.stack import Stack
from visualspeech.models.stack_settings import StackSettings

FIVE_PHONES = [Layout((5, 5, 5, 3))]


def parameters(letters, nodes, b_nodes, outputs=3):
    module = Stack(StackSettings(letters, nodes, b_nodes), FIVE_PHONES, outputs)
    return sum(values.numel() for values in module.parameters())


def expected(letters, nodes, b_nodes, phones=5, outputs=3):
    """Counted by hand: an LSTM has four gates, each with weights of inputs and state and torch's two biases."""
    width, total = 3 * phones + 3, 0
    for letter in letters:
        if letter == "F":
            total, width = total + nodes * (width + 1), nodes
        elif letter == "C":
            # Two gates over three frames, a map back to the residual stream, and one to the width where it differs.
            total += nodes * (width + 1) if width != nodes else 0
            total, width = total + 2 * nodes * (3 * nodes + 1) + nodes * (nodes + 1), nodes
        else:
            own = nodes if b_nodes == "direction" else nodes // 2
            total, width = total + 2 * 4 * own * (width + own + 2), 2 * own
    return total + outputs * (width + 1)


@pytest.mark.parametrize("letters", ["B", "FBB", "BFB", "FF", "CCC", "FCB", "BC", "CCCCCC"])
@pytest.mark.parametrize("b_nodes", ["direction", "layer"])
def test_weights_are_counted(letters, b_nodes):
    assert parameters(letters, 8, b_nodes) == expected(letters, 8, b_nodes)


def test_real_values_widen_the_first_layer():
    one, other = (Stack(StackSettings("B", 4), layouts, 3) for layouts in (FIVE_PHONES, [*FIVE_PHONES, Layout((), 7)]))
    added = sum(p.numel() for p in other.parameters()) - sum(p.numel() for p in one.parameters())
    assert added == 2 * 4 * 4 * 7


def test_a_layer_of_twice_the_width_is_a_direction():
    torch.manual_seed(0)
    one = Stack(StackSettings("B", 4, "direction"), FIVE_PHONES, 3)
    torch.manual_seed(0)
    other = Stack(StackSettings("B", 8, "layer"), FIVE_PHONES, 3)
    for a, b in zip(one.parameters(), other.parameters(), strict=True):
        torch.testing.assert_close(a, b, rtol=0, atol=0)


def test_a_saved_network_keeps_its_reading(tmp_path):
    settings = StackSettings("FB", 6, "layer")
    module = Stack(settings, [BLOCKS["tri"].layout], 2)
    network = Network("stack", asdict(settings), module, Scaling(np.zeros(2), np.ones(2)), BLOCKS, 25.0)
    network.save(tmp_path / "n.safetensors")
    again = stack.load(tmp_path / "n.safetensors")
    streams = [Stream(index=np.array([[0, 1, 2, 0], [0, 1, 2, 1], [1, 2, 3, 0]], np.int16))]
    np.testing.assert_array_equal(again.predict(streams), network.predict(streams))
    assert StackSettings(**again.settings).direction_nodes == 3
    assert again.module.layers[1].hidden_size == 3


def test_wrong_widths_are_named():
    with pytest.raises(SettingError, match="must be even: with `b_nodes: layer`"):
        StackSettings("FB", 5, "layer")
    StackSettings("FF", 5, "layer")
    with pytest.raises(SettingError, match="b_nodes: both.*direction, layer"):
        StackSettings("FB", 4, "both")
