"""The gathered first layer against the dense product with one-hot windows, written out frame by frame in numpy."""

import numpy as np
import pytest
import torch

from visualspeech.features.streams import Layout
from visualspeech.models.batches import Batch
from visualspeech.models.frames import FrameStore, of_utterances
from visualspeech.models.gathered import GatheredLinear

NODES = 7
LAYOUTS = {
    "window": [Layout((5,), window=3)],
    "context": [Layout((5, 3, 2))],
    "phones and values": [Layout((5,), window=2), Layout((4, 3)), Layout((), 3), Layout((6,), 2, window=1)],
    "values in a window": [Layout((), 2, window=4)],
    "several columns in a window": [Layout((3, 4), 1, window=2)],
}


def streams(layouts, frames, generator):
    """Classes (frames, C) and values (frames, D) of all inputs side by side."""
    sizes = [size for layout in layouts for size in layout.sizes]
    index = (
        np.stack([generator.integers(0, size, frames) for size in sizes], axis=1) if sizes else np.zeros((frames, 0))
    )
    dimension = sum(layout.dimension for layout in layouts)
    return index.astype(np.int64), generator.normal(size=(frames, dimension)).astype(np.float32)


def inputs(layouts, index, values):
    """The vector x of every frame of one utterance, (T, width): one-hot windows, then windows of real values."""
    frames, rows = len(index), []
    for at in range(frames):
        ones, reals, column, value = [], [], 0, 0
        for layout in layouts:
            for near in range(at - layout.window, at + layout.window + 1):
                inside = 0 <= near < frames
                for number, size in enumerate(layout.sizes):
                    one = np.zeros(size)
                    if inside:
                        one[index[near, column + number]] = 1
                    ones.append(one)
                own = values[near, value : value + layout.dimension] if inside else np.zeros(layout.dimension)
                reals.append(own)
            column, value = column + len(layout.sizes), value + layout.dimension
        rows.append(np.concatenate([*ones, *reals]))
    return np.array(rows)


def utterances(layouts, lengths=(9, 4, 1), seed=0):
    generator = np.random.default_rng(seed)
    return [streams(layouts, length, generator) for length in lengths]


def given(parts):
    index, values = (torch.from_numpy(np.concatenate(side)) for side in zip(*parts, strict=True))
    return of_utterances(index, values, torch.tensor([len(one[0]) for one in parts]))


def weights_of(layer):
    """W (nodes, width) of the documented order of columns."""
    parts = [layer.classes.T] if hasattr(layer, "classes") else []
    return torch.cat([*parts, *([layer.values] if hasattr(layer, "values") else [])], dim=1)


@pytest.mark.parametrize("name", LAYOUTS)
def test_outputs_are_those_of_the_dense_product(name):
    layouts, parts = LAYOUTS[name], utterances(LAYOUTS[name])
    layer = GatheredLinear(layouts, NODES).double()
    frames = given([(index, values.astype(np.float64)) for index, values in parts])
    x = np.concatenate([inputs(layouts, *one) for one in parts])
    assert x.shape[1] == sum(layout.width for layout in layouts) == weights_of(layer).shape[1]
    expected = x @ weights_of(layer).detach().numpy().T + layer.bias.detach().numpy()
    np.testing.assert_allclose(layer(frames).detach().numpy(), expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", LAYOUTS)
def test_gradients_are_those_of_the_dense_product(name):
    layouts, parts = LAYOUTS[name], utterances(LAYOUTS[name], seed=1)
    layer = GatheredLinear(layouts, NODES)
    dense = torch.nn.Linear(weights_of(layer).shape[1], NODES)
    with torch.no_grad():
        dense.weight.copy_(weights_of(layer))
        dense.bias.copy_(layer.bias)
    x = torch.tensor(np.concatenate([inputs(layouts, *one) for one in parts]), dtype=torch.float32)
    direction = torch.randn(len(x), NODES)
    (torch.tanh(layer(given(parts))) * direction).sum().backward()
    (torch.tanh(dense(x)) * direction).sum().backward()
    found = [layer.classes.grad.T] if hasattr(layer, "classes") else []
    found = torch.cat([*found, *([layer.values.grad] if hasattr(layer, "values") else [])], dim=1)
    # Single precision: sums of some ten products in another order.
    torch.testing.assert_close(found, dense.weight.grad, rtol=1e-5, atol=1e-6)
    torch.testing.assert_close(layer.bias.grad, dense.bias.grad, rtol=1e-5, atol=1e-6)


def test_a_window_ends_with_the_utterance_and_may_be_longer_than_it():
    layouts = [Layout((4,), window=30)]
    layer, parts = GatheredLinear(layouts, NODES), utterances(layouts, (5, 3, 8))
    together = layer(given(parts))
    alone = torch.cat([layer(given([one])) for one in parts])
    torch.testing.assert_close(together, alone)
    # Of the 61 rows of a window, each frame adds one per frame of its own utterance.
    with torch.no_grad():
        layer.classes.fill_(1)
        layer.bias.zero_()
    assert layer(given(parts))[:, 0].tolist() == [5] * 5 + [3] * 3 + [8] * 8


@pytest.mark.parametrize("name", LAYOUTS)
def test_single_frames_and_whole_utterances_get_the_same_outputs(name):
    layouts, lengths = LAYOUTS[name], [9, 6, 2]
    layer, parts = GatheredLinear(layouts, NODES), utterances(LAYOUTS[name], lengths)
    index, values = (np.concatenate(side) for side in zip(*parts, strict=True))
    small = torch.from_numpy(index.astype(np.uint8))
    bounds = torch.tensor([0, 9, 15, 17])
    store = FrameStore(small, torch.from_numpy(values), torch.arange(17.0)[:, None], bounds)
    size = (len(lengths), max(lengths))
    padded = torch.full((*size, index.shape[1]), 1), torch.full((*size, values.shape[1]), 7.0)
    for row, one in enumerate(parts):
        for whole, own in zip(padded, one, strict=True):
            whole[row, : len(own)] = torch.from_numpy(own)
    batch = Batch(*padded, torch.tensor(lengths), torch.zeros(0))
    outputs = batch.laid_out(layer(batch.frames()))
    assert outputs.shape == (*size, NODES) and not outputs[1, 6:].any() and not outputs[2, 2:].any()
    expected = torch.cat([outputs[row, :length] for row, length in enumerate(lengths)])
    for given_ in store.batches(4):
        found = given_.laid_out(layer(given_.frames()))
        at = given_.targets[:, 0, 0].long()
        torch.testing.assert_close(found[:, 0], expected[at])


@pytest.mark.parametrize("name", LAYOUTS)
def test_shapes_are_known_without_a_layer(name):
    made = {key: tuple(values.shape) for key, values in GatheredLinear(LAYOUTS[name], 3).state_dict().items()}
    assert GatheredLinear.shapes(LAYOUTS[name], 3) == made


def test_weights_start_by_the_inputs_that_are_not_zero():
    torch.manual_seed(0)
    layer = GatheredLinear([Layout((41,), window=16), Layout((), 3)], 512)
    bound = 1 / np.sqrt(33 + 3)
    assert 0.99 * bound < layer.classes.abs().max() <= bound and 0.99 * bound < layer.values.abs().max() <= bound
    assert layer.classes.std().item() == pytest.approx(bound / np.sqrt(3), rel=0.01)
