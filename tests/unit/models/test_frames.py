"""All frames of a corpus in memory, and single frames of it in random order."""

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, utterances, with_stream
from visualspeech.features.streams import Layout, Stream
from visualspeech.models.frames import FrameStore, index_type, of_utterances

MEAN, SCALE = np.arange(4.0), np.array([1.0, 2.0, 4.0, 8.0])


def stored(examples, layouts=None):
    lengths = np.array([len(one.target) for one in examples])
    return FrameStore.of(examples, lengths, layouts or [BLOCKS["tri"].layout], MEAN, SCALE)


def test_neighbours_outside_the_utterance_are_marked_and_replaced_by_the_frame_itself():
    frames = of_utterances(torch.zeros(5, 1), torch.zeros(5, 0), torch.tensor([3, 2]))
    numbers, inside = frames.around(1)
    assert numbers.tolist() == [[0, 0, 1], [0, 1, 2], [1, 2, 2], [3, 3, 4], [3, 4, 4]]
    assert inside.tolist() == [
        [False, True, True],
        [True, True, True],
        [True, True, False],
        [False, True, True],
        [True, True, False],
    ]


def test_every_frame_comes_once_an_epoch_with_its_own_utterance():
    examples = utterances(6)
    store, lengths = stored(examples), [len(one.target) for one in examples]
    torch.manual_seed(3)
    batches = list(store.batches(10))
    at = torch.cat([one.frames().at for one in batches]).tolist()
    assert sorted(at) == list(range(sum(lengths))) and at != sorted(at)
    assert [len(one.lengths) for one in batches[:-1]] == [10] * (len(batches) - 1)
    starts = np.cumsum([0, *lengths])
    targets = np.concatenate([(one.target - MEAN) / SCALE for one in examples])
    labels = np.concatenate([one.streams[0].index for one in examples])
    for one in batches:
        frames = one.frames()
        utterance = np.searchsorted(starts, frames.at.numpy(), side="right") - 1
        assert (
            frames.first.tolist() == starts[utterance].tolist()
            and frames.end.tolist() == starts[utterance + 1].tolist()
        )
        np.testing.assert_allclose(one.targets[:, 0], targets[frames.at], rtol=1e-6)
        np.testing.assert_array_equal(frames.index[frames.at], labels[frames.at])
        assert one.lengths.eq(1).all()


def test_the_order_follows_from_the_seed():
    store, orders = stored(utterances(4)), []
    for seed in (1, 1, 2):
        torch.manual_seed(seed)
        orders.append([one.frames().at.tolist() for one in store.batches(16)])
    assert orders[0] == orders[1] != orders[2]


def test_classes_are_kept_in_bytes_and_values_and_targets_in_single_precision():
    examples = utterances(3)
    values = [Stream(values=np.ones((len(one.target), 5))) for one in examples]
    store = stored(with_stream(examples, values), [BLOCKS["tri"].layout, Layout((), 5)])
    assert (store.index.dtype, store.values.dtype, store.targets.dtype) == (torch.uint8, torch.float32, torch.float32)
    frames = sum(len(one.target) for one in examples)
    assert store.index.nbytes + store.values.nbytes + store.targets.nbytes == frames * (4 + 4 * 5 + 4 * 4)


@pytest.mark.parametrize(
    ("classes", "kind"), [(1, np.uint8), (256, np.uint8), (257, np.int16), (32768, np.int16), (32769, np.int32)]
)
def test_the_smallest_type_that_holds_all_classes(classes, kind):
    assert index_type(classes) is kind
