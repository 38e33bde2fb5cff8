"""Convolutions and recurrent layers: against torch's own convolution, what they reach, and frames that do not exist."""

import numpy as np
import pytest
import torch
from torch.nn.utils.rnn import PackedSequence, pack_padded_sequence, pad_packed_sequence

from visualspeech.features.streams import Layout
from visualspeech.models.batches import Batch
from visualspeech.models.layers import DILATIONS, BidirectionalLstm, GatedConvolution, dilations, dropped, neighbours
from visualspeech.models.stack import Stack
from visualspeech.models.stack_settings import StackSettings

LENGTHS = torch.tensor([11, 7, 7, 2, 1])


def counts(lengths=LENGTHS):
    return torch.tensor([int((lengths > time).sum()) for time in range(int(lengths.max()))])


def convolved(layer, values):
    """The layer on one utterance (T, inputs) by torch's dilated convolution, zeros beside the utterance."""
    x = values if layer.projection is None else layer.projection(values)
    nodes = x.shape[1]
    kernel = layer.gates.weight.reshape(2 * nodes, 3, nodes).permute(0, 2, 1)
    both = torch.nn.functional.conv1d(
        x.T[None], kernel, layer.gates.bias, padding=layer.dilation, dilation=layer.dilation
    )[0].T
    gated = torch.tanh(both[:, :nodes]) * torch.sigmoid(both[:, nodes:])
    return x + gated @ layer.residual.weight.T + layer.residual.bias


@pytest.mark.parametrize("inputs", [4, 6])
@pytest.mark.parametrize("dilation", [1, 3, 8])
def test_a_layer_is_torchs_convolution_of_each_utterance(inputs, dilation):
    torch.manual_seed(dilation)
    layer = GatedConvolution(inputs, 4, dilation).double().eval()
    values = torch.randn(len(LENGTHS), int(LENGTHS.max()), inputs, dtype=torch.float64)
    packed = pack_padded_sequence(values, LENGTHS, batch_first=True)
    found = pad_packed_sequence(packed._replace(data=layer(packed.data, packed.batch_sizes)), batch_first=True)[0]
    for row, length in enumerate(LENGTHS.tolist()):
        torch.testing.assert_close(found[row, :length], convolved(layer, values[row, :length]), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("distance", [1, 2, 6, 20])
def test_neighbours_are_frames_of_the_same_utterance(distance):
    packed = pack_padded_sequence(
        torch.stack(torch.meshgrid(torch.arange(5), torch.arange(11), indexing="ij"), dim=2), LENGTHS, batch_first=True
    )
    assert torch.equal(packed.batch_sizes, counts())
    places = {tuple(one): number for number, one in enumerate(packed.data.tolist())}
    before, after = neighbours(packed.batch_sizes, distance)
    for number, (utterance, time) in enumerate(packed.data.tolist()):
        assert before[number] == places.get((utterance, time - distance), len(places))
        assert after[number] == places.get((utterance, time + distance), len(places))


def test_dilations_grow_over_a_run_of_convolutions():
    assert dilations("CCC") == [1, 2, 4] and dilations("FCB") == [0, 1, 0]
    assert dilations("CCFCC") == [1, 2, 0, 1, 2]
    assert dilations("C" * (len(DILATIONS) + 2)) == [*DILATIONS, 1, 2]
    assert dilations("FBB") == [0, 0, 0]


@pytest.mark.parametrize("letters", ["C", "CC", "CCC", "CFC", "CCCCCC"])
def test_a_stack_sees_as_far_as_its_dilations_reach(letters):
    torch.manual_seed(1)
    module = Stack(StackSettings(letters, 6), [Layout(dimension=2)], 3).double().eval()
    reach, frames = sum(dilations(letters)), 61
    values = torch.randn(1, frames, 2, dtype=torch.float64)
    changed = values.clone()
    changed[0, 30] += 1.0
    outputs = [
        module(Batch(torch.zeros(1, frames, 0, dtype=torch.int64), one, torch.tensor([frames]), torch.zeros(0)))[0]
        for one in (values, changed)
    ]
    differ = torch.nonzero((outputs[0] != outputs[1]).any(dim=1)).ravel()
    assert differ.min() == 30 - reach and differ.max() == 30 + reach


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
    assert torch.equal(dropped(values, 0.0), values)


def test_the_residual_connection_is_not_dropped():
    torch.manual_seed(1)
    layer = GatedConvolution(3, 3, 1, dropout=0.999999)
    x = torch.randn(4, 3)
    found = layer(x, torch.tensor([1, 1, 1, 1]))
    np.testing.assert_allclose(found.detach().numpy(), (x + layer.residual.bias).detach().numpy(), atol=1e-6)


@pytest.mark.parametrize("bias", [True, False])
@pytest.mark.parametrize("lengths", [[7, 7, 7], [9, 6, 6, 1], [5], [3, 2, 1]])
def test_a_bidirectional_layer_is_torchs_on_packed_utterances(lengths, bias):
    torch.manual_seed(3)
    layer = BidirectionalLstm(4, 3, bias).double()
    plain = torch.nn.LSTM(4, 3, bias=bias, batch_first=True, bidirectional=True).double()
    plain.load_state_dict(layer.state_dict())
    batch = torch.randn(len(lengths), lengths[0], 4, dtype=torch.float64)
    packed = pack_padded_sequence(batch, torch.tensor(lengths), batch_first=True)
    weight = torch.randn(sum(lengths), 6, dtype=torch.float64)
    results = []
    for outputs in (
        lambda frames: layer(frames, packed.batch_sizes),
        lambda frames: plain(PackedSequence(frames, packed.batch_sizes))[0].data,
    ):
        frames = packed.data.clone().requires_grad_()
        module = layer if not results else plain
        values = outputs(frames)
        (values.tanh() * weight).sum().backward()
        results.append([values.detach(), frames.grad, *(one.grad for one in module.parameters())])
    for own, torchs in zip(*results, strict=True):
        torch.testing.assert_close(own, torchs, rtol=1e-12, atol=1e-13)
