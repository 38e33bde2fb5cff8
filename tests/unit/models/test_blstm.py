import numpy as np
import pytest
import torch

from tests.unit.models.examples import utterances
from visualspeech.errors import SettingError
from visualspeech.features.labels import one_hot
from visualspeech.models.blstm import Stack, StackSettings, dropped, parse_stack


def stack(letters, phones=6, outputs=3, nodes=5, seed=1):
    torch.manual_seed(seed)
    return Stack(StackSettings(letters, nodes), phones, outputs).eval()


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def lstm(inputs, weights, suffix):
    """One direction, frame by frame, in plain numpy (gates in torch's order: input, forget, cell, output)."""
    inner, recurrent = weights[f"weight_ih_l0{suffix}"], weights[f"weight_hh_l0{suffix}"]
    bias = weights[f"bias_ih_l0{suffix}"] + weights[f"bias_hh_l0{suffix}"]
    hidden = cell = np.zeros(recurrent.shape[1])
    outputs = []
    for frame in inputs[::-1] if suffix else inputs:
        i, f, g, o = np.split(inner @ frame + recurrent @ hidden + bias, 4)
        cell = sigmoid(f) * cell + sigmoid(i) * np.tanh(g)
        hidden = sigmoid(o) * np.tanh(cell)
        outputs.append(hidden)
    return np.array(outputs[::-1] if suffix else outputs)


def slow_forward(module, labels, phones):
    frames = one_hot(labels, phones).astype(np.float64)
    for letter, layer in zip(module.letters, module.layers, strict=True):
        weights = {name: values.detach().numpy().astype(np.float64) for name, values in layer.named_parameters()}
        if letter == "F":
            frames = np.tanh(frames @ weights["weight"].T + weights["bias"])
        else:
            frames = np.concatenate([lstm(frames, weights, ""), lstm(frames, weights, "_reverse")], axis=1)
    return frames @ module.output.weight.detach().numpy().T + module.output.bias.detach().numpy()


@pytest.mark.parametrize("letters", ["F", "B", "FBB", "BFB"])
def test_every_utterance_of_a_padded_batch_against_plain_numpy(letters):
    module = stack(letters)
    examples = sorted((labels for labels, _ in utterances(4)), key=len, reverse=True)
    lengths = torch.tensor([len(labels) for labels in examples])
    # What stands in the padding must not matter: fill it with labels that mean something.
    batch = torch.full((4, int(lengths.max()), 4), 2)
    for row, labels in enumerate(examples):
        batch[row, : len(labels)] = torch.tensor(labels.astype(np.int64))
    with torch.inference_mode():
        outputs = module(batch, lengths).numpy()
    for row, labels in enumerate(examples):
        assert np.allclose(outputs[row, : len(labels)], slow_forward(module, labels, 6), atol=1e-5)
        assert not outputs[row, len(labels) :].any()


def test_input_vectors_are_those_of_the_features():
    labels = utterances(1)[0][0]
    assert np.array_equal(stack("F").encode(torch.tensor(labels.astype(np.int64))).numpy(), one_hot(labels, 6))


def test_gradient_by_finite_difference():
    module = stack("FB", nodes=3).double()
    labels = torch.tensor(np.stack([labels[:8] for labels, _ in utterances(2)]).astype(np.int64))
    lengths = torch.tensor([8, 5])
    truth = torch.randn(2, 8, 3, dtype=torch.float64)
    truth[1, 5:] = 0

    def error():
        from visualspeech.models.training import sum_of_squared_errors

        return sum_of_squared_errors(module(labels, lengths), truth)

    error().backward()
    generator = np.random.default_rng(1)
    for weights in module.parameters():
        place = tuple(int(generator.integers(size)) for size in weights.shape)
        with torch.no_grad():
            before = weights[place].item()
            weights[place] = before + 1e-5
            above = error().item()
            weights[place] = before - 1e-5
            below = error().item()
            weights[place] = before
        assert weights.grad[place].item() == pytest.approx((above - below) / 2e-5, rel=1e-5, abs=1e-7)


def test_names():
    assert parse_stack("FBB-128") == StackSettings("FBB", 128)
    assert parse_stack("FBB-128").name == "FBB-128"


@pytest.mark.parametrize("name", ["FXB-128", "fbb-128", "FBB-0", "FBB", "-12", "FBB-1.5"])
def test_names_that_are_no_stack(name):
    with pytest.raises(SettingError):
        parse_stack(name)


@pytest.mark.parametrize("nodes", [0, -3, True, 1.5])
def test_widths_that_are_no_width(nodes):
    with pytest.raises(SettingError, match="networks.nodes"):
        StackSettings("F", nodes)


def test_dropped_values_keep_their_mean_and_pass_the_gradient_of_those_that_stay():
    torch.manual_seed(1)
    values = torch.ones(400, 500, requires_grad=True)
    result = dropped(values, 0.3)
    # 200,000 draws: five standard deviations of the share are 0.005.
    assert abs((result == 0).double().mean().item() - 0.3) < 0.005
    assert torch.allclose(result[result != 0], torch.tensor(1 / 0.7))
    assert abs(result.mean().item() - 1) < 0.01
    result.sum().backward()
    assert torch.equal(values.grad, result.detach())


def test_hidden_values_are_dropped_in_training_alone():
    torch.manual_seed(1)
    module = Stack(StackSettings("FB", 64), 6, 3, dropout=0.5)
    labels, lengths = torch.tensor(utterances(1)[0][0].astype(np.int64))[None], torch.tensor([len(utterances(1)[0][0])])
    assert not torch.equal(module(labels, lengths), module(labels, lengths))
    module.eval()
    assert torch.equal(module(labels, lengths), module(labels, lengths))
