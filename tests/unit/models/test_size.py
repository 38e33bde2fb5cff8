"""Numbers of parameters of models from the arrays of their files."""

import numpy as np
import torch

from visualspeech.models.size import parameter_count


def test_a_network_has_its_weights_and_biases():
    module = torch.nn.Sequential(torch.nn.Linear(7, 5), torch.nn.Tanh(), torch.nn.Linear(5, 3))
    arrays = {f"weights.{name}": values.numpy() for name, values in module.state_dict().items()}
    counted = sum(values.numel() for values in module.parameters())
    other = {"mean": np.zeros(3), "scale": np.ones(3), "blocks.0.text.weights": np.zeros((9, 9))}
    assert parameter_count(arrays | other) == counted == 7 * 5 + 5 + 5 * 3 + 3


def test_other_models_have_their_real_numbers():
    arrays = {
        "gaussians.mean": np.zeros((4, 6)),
        "gaussians.variance": np.ones((4, 6)),
        "tying.roots": np.zeros(5, int),
    }
    assert parameter_count(arrays) == 48
    assert parameter_count({"mean": np.zeros(3, np.float32)}) == 3


def test_members_are_counted_with_what_is_made_of_them():
    network = {"weights.a": np.zeros((2, 3)), "mean": np.zeros(9)}
    inner = {f"members.0.{name}": values for name, values in network.items()} | {"members.1.mean": np.zeros(9)}
    outer = {f"members.0.{name}": values for name, values in inner.items()} | {"factor": np.zeros(2)}
    assert (parameter_count(inner), parameter_count(outer)) == (15, 17)
