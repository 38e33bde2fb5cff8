"""What the width of a B layer means, in both readings, by its weights and through a saved network."""

import numpy as np
import pytest
import torch

from visualspeech.errors import SettingError
from visualspeech.models.blstm import Stack, StackSettings, parse_stack
from visualspeech.models.network import Network


def parameters(letters, nodes, b_nodes, phones=5, outputs=3):
    return sum(values.numel() for values in Stack(StackSettings(letters, nodes, b_nodes), phones, outputs).parameters())


def expected(letters, nodes, b_nodes, phones=5, outputs=3):
    """Counted by hand: an LSTM has four gates, each with weights of inputs and state and torch's two biases."""
    width, total = 3 * phones + 3, 0
    for letter in letters:
        if letter == "F":
            total, width = total + nodes * (width + 1), nodes
        else:
            own = nodes if b_nodes == "direction" else nodes // 2
            total, width = total + 2 * 4 * own * (width + own + 2), 2 * own
    return total + outputs * (width + 1)


@pytest.mark.parametrize("letters", ["B", "FBB", "BFB", "FF"])
@pytest.mark.parametrize("b_nodes", ["direction", "layer"])
def test_weights_are_counted(letters, b_nodes):
    assert parameters(letters, 8, b_nodes) == expected(letters, 8, b_nodes)


def test_a_layer_of_twice_the_width_is_a_direction():
    torch.manual_seed(0)
    one = Stack(StackSettings("B", 4, "direction"), 5, 3)
    torch.manual_seed(0)
    other = Stack(StackSettings("B", 8, "layer"), 5, 3)
    for a, b in zip(one.parameters(), other.parameters(), strict=True):
        torch.testing.assert_close(a, b, rtol=0, atol=0)


def test_a_saved_network_keeps_its_reading(tmp_path):
    stack = parse_stack("FB-6-s2", "layer")
    weights = {name: values.numpy() for name, values in Stack(stack, 4, 2).state_dict().items()}
    network = Network(stack, ("sil", "a", "b", "c"), weights, np.zeros(2, np.float32), 1.0, 25.0)
    network.save(tmp_path / "n.safetensors")
    again = Network.load(tmp_path / "n.safetensors")
    labels = np.array([[0, 1, 2, 0], [0, 1, 2, 1], [1, 2, 3, 0]], np.int16)
    np.testing.assert_array_equal(again.predict(labels), network.predict(labels))
    assert again.stack.direction_nodes == 3


def test_wrong_widths_are_named():
    with pytest.raises(SettingError, match="is odd"):
        StackSettings("FB", 5, "layer")
    StackSettings("FF", 5, "layer")
    with pytest.raises(SettingError, match="b_nodes: both.*direction, layer"):
        StackSettings("FB", 4, "both")
