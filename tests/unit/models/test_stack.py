from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, PHONES, utterances, with_stream
from tests.unit.models.test_gathered import inputs
from visualspeech.errors import SettingError
from visualspeech.features.labels import one_hot
from visualspeech.features.streams import Layout, Stream
from visualspeech.models.batches import Batch, Scaling, batch
from visualspeech.models.layers import dilations
from visualspeech.models.objectives import objective_of
from visualspeech.models.stack import Stack, weight_shapes
from visualspeech.models.stack_settings import MAX_LAYERS, StackSettings
from visualspeech.models.training_settings import OBJECTIVES, training_settings

LABELS = BLOCKS["tri"].layout
DENSE = Layout(dimension=2)


def stack(letters, outputs=3, nodes=5, seed=1, layouts=(LABELS,)):
    torch.manual_seed(seed)
    return Stack(StackSettings(letters, nodes), layouts, outputs).eval()


def padded(examples, outputs=4, fill=True):
    """A batch of utterances, longest first, whose padding holds what must not matter."""
    order = np.argsort([-len(one.target) for one in examples], kind="stable")
    result = batch(examples, order, Scaling(np.zeros(outputs), np.ones(outputs)))
    for row, length in enumerate(result.lengths.tolist() if fill else []):
        result.index[row, length:] = 2
        result.values[row, length:] = 7.0
    return [examples[number] for number in order], result


def dense_utterances(number, seed=0):
    generator = np.random.default_rng(seed)
    examples = utterances(number, seed)
    streams = [Stream(values=generator.normal(size=(len(one.target), 2)).astype(np.float32)) for one in examples]
    return with_stream(examples, streams)


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


def gated_convolution(inputs, weights, dilation):
    """Frame by frame, in plain numpy; the gates' weights are those of the frame before, the frame and the one after."""
    x = inputs @ weights["projection.weight"].T + weights["projection.bias"] if "projection.bias" in weights else inputs
    outputs = []
    for time in range(len(x)):
        taps = [x[at] if 0 <= at < len(x) else np.zeros(x.shape[1]) for at in (time - dilation, time, time + dilation)]
        filters, gates = np.split(weights["gates.weight"] @ np.concatenate(taps) + weights["gates.bias"], 2)
        gated = np.tanh(filters) * sigmoid(gates)
        outputs.append(x[time] + weights["residual.weight"] @ gated + weights["residual.bias"])
    return np.array(outputs)


def slow_forward(module, streams):
    frames = one_hot(streams[0].index, len(PHONES)).astype(np.float64)
    frames = np.column_stack([frames, *(one.values for one in streams[1:])])
    for letter, layer, dilation in zip(module.letters, module.layers, dilations(module.letters), strict=True):
        weights = {name: values.detach().numpy().astype(np.float64) for name, values in layer.named_parameters()}
        if letter == "F":
            frames = np.tanh(frames @ weights["weight"].T + weights["bias"])
        elif letter == "C":
            frames = gated_convolution(frames, weights, dilation)
        else:
            frames = np.concatenate([lstm(frames, weights, ""), lstm(frames, weights, "_reverse")], axis=1)
    return frames @ module.output.weight.detach().numpy().T + module.output.bias.detach().numpy()


@pytest.mark.parametrize("dense", [False, True])
@pytest.mark.parametrize("letters", ["F", "B", "C", "FBB", "BFB", "CCC", "FCB", "BCCF"])
def test_every_utterance_of_a_padded_batch_against_plain_numpy(letters, dense):
    module = stack(letters, layouts=(LABELS, DENSE) if dense else (LABELS,))
    examples, given = padded(dense_utterances(4) if dense else utterances(4))
    with torch.inference_mode():
        outputs = module(given).numpy()
    for row, one in enumerate(examples):
        assert np.allclose(outputs[row, : len(one.target)], slow_forward(module, one.streams), atol=1e-5)
        assert not outputs[row, len(one.target) :].any()


@pytest.mark.parametrize("letters", ["CCC", "FCB", "CCCCCC"])
def test_an_utterance_alone_and_in_a_padded_batch(letters):
    module = stack(letters, layouts=(LABELS, DENSE))
    examples, given = padded(dense_utterances(5, seed=3))
    with torch.inference_mode():
        outputs = module(given)
        for row, one in enumerate(examples):
            alone = module(padded([one])[1])[0]
            torch.testing.assert_close(outputs[row, : len(alone)], alone, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("letters", ["F", "FB", "FCB"])
def test_windows_are_those_of_a_dense_first_layer(letters):
    layouts = (replace(LABELS, window=2), DENSE)
    module = stack(letters, layouts=layouts).double()
    examples, given = padded(dense_utterances(4))
    outputs = module(replace(given, values=given.values.double())).detach().numpy()
    plain = stack(letters, layouts=(Layout(dimension=sum(one.width for one in layouts)),)).double()
    weights = module.state_dict()
    first = torch.cat([weights.pop("layers.0.classes").T, weights.pop("layers.0.values")], dim=1)
    plain.load_state_dict({**weights, "layers.0.weight": first})
    for row, one in enumerate(examples):
        x = inputs(layouts, one.streams[0].index.astype(np.int64), one.streams[1].values)
        alone = Batch(torch.zeros(1, len(x), 0), torch.tensor(x)[None], torch.tensor([len(x)]), torch.zeros(0))
        np.testing.assert_allclose(outputs[row, : len(x)], plain(alone)[0].detach().numpy(), atol=1e-6)
        assert not outputs[row, len(x) :].any()


def test_a_stack_without_windows_has_the_weights_of_any_stack():
    assert set(stack("F").state_dict()) == {"layers.0.weight", "layers.0.bias", "output.weight", "output.bias"}


def test_windows_without_a_feed_forward_layer_are_a_sentence():
    with pytest.raises(SettingError, match="`models.letters: BF` must be letters of which the first is F"):
        stack("BF", layouts=(replace(LABELS, window=2),))


def test_input_vectors_are_those_of_the_features():
    labels = utterances(1)[0].streams[0].index
    assert np.array_equal(stack("F").encode(torch.tensor(labels.astype(np.int64))).numpy(), one_hot(labels, 6))


def test_classes_of_several_blocks_lie_beside_each_other():
    labels = utterances(1)[0].streams[0].index
    part = np.arange(len(labels)) % 4
    index = torch.tensor(np.column_stack([labels, part]).astype(np.int64))
    found = stack("F", layouts=(LABELS, Layout(sizes=(4,)))).encode(index).numpy()
    np.testing.assert_array_equal(found[:, :-4], one_hot(labels, len(PHONES)))
    np.testing.assert_array_equal(found[:, -4:], np.eye(4)[part])


def test_real_values_alone():
    module = stack("FB", layouts=(Layout(dimension=3),))
    values = torch.randn(1, 6, 3)
    given = Batch(torch.zeros(1, 6, 0, dtype=torch.int64), values, torch.tensor([6]), torch.zeros(0))
    assert module(given).shape == (1, 6, 3)
    assert module.layers[0].weight.shape[1] == 3


@pytest.mark.parametrize("letters", ["FB", "CCB"])
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_gradient_by_finite_difference(objective, letters):
    module = stack(letters, nodes=3, outputs=4, layouts=(LABELS, DENSE)).double()
    given = padded(dense_utterances(2))[1]
    given = Batch(given.index, given.values.double(), given.lengths, given.targets.double())

    def error():
        return objective_of(training_settings(objective=objective)).loss(module(given), given.targets, given.lengths)

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


@pytest.mark.parametrize("letters", ["FXB", "fbb", "", "FBB-128", "F B", "F" * (MAX_LAYERS + 1)])
def test_letters_that_are_no_stack(letters):
    with pytest.raises(SettingError, match="must be of this form: Hidden layers .* for example FBB"):
        StackSettings(letters, 128)


@pytest.mark.parametrize("nodes", [0, -3, True, 1.5, 4097])
def test_widths_that_are_no_width(nodes):
    with pytest.raises(SettingError, match="models.nodes"):
        StackSettings("F", nodes)


@pytest.mark.parametrize("letters", ["FB", "C"])
def test_hidden_values_are_dropped_in_training_alone(letters):
    torch.manual_seed(1)
    module = Stack(StackSettings(letters, 64), [LABELS], 3, dropout=0.5)
    given = padded(utterances(1))[1]
    assert not torch.equal(module(given), module(given))
    module.eval()
    assert torch.equal(module(given), module(given))


@pytest.mark.parametrize("letters", ["F", "B", "FBB", "BFBF", "CCF", "BCCB"])
@pytest.mark.parametrize("b_nodes", ["direction", "layer"])
def test_shapes_of_the_weights_are_known_without_a_network(letters, b_nodes):
    settings = {"letters": letters, "nodes": 6, "b_nodes": b_nodes}
    layouts = (replace(LABELS, window=2 if letters[0] == "F" else 0), DENSE)
    made = Stack(StackSettings(**settings), layouts, 3).state_dict()
    assert weight_shapes(settings, layouts, 3) == {name: tuple(values.shape) for name, values in made.items()}
