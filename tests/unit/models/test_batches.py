from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, RATE, Values, utterances, with_stream
from visualspeech.errors import DataError
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models.batches import Content, Scaling, batch, batches, content
from visualspeech.models.training_settings import TrainingSettings

LENGTHS = np.random.default_rng(1).integers(10, 100, 50)
ORDER = np.random.default_rng(2).permutation(50)


def test_batches_hold_every_utterance_once_and_similar_lengths():
    result = batches(LENGTHS, TrainingSettings(batch_size=8), ORDER)
    assert sorted(np.concatenate(result)) == list(range(50))
    assert all((np.diff(LENGTHS[batch]) <= 0).all() for batch in result)
    assert [len(one) for one in result] == [8] * 6 + [2]
    assert len(batches(LENGTHS, TrainingSettings(batch_size=1), ORDER, least=16)) == 4


@pytest.mark.parametrize("frames", [1, 99, 100, 250, 1000, 100_000])
def test_the_batcher_of_frames_never_holds_more_than_its_bound(frames):
    result = batches(LENGTHS, TrainingSettings(batcher="frames", batch_frames=frames), ORDER)
    assert sorted(np.concatenate(result)) == list(range(50))
    for numbers in result:
        assert (np.diff(LENGTHS[numbers]) <= 0).all()
        # Padded to the longest; one utterance that is longer than the bound is a batch by itself.
        assert len(numbers) == 1 or len(numbers) * LENGTHS[numbers].max() <= frames
    if frames == 100_000:
        assert len(result) == 1


def test_the_batcher_of_frames_fills_its_batches():
    result = batches(LENGTHS, TrainingSettings(batcher="frames", batch_frames=1000), np.arange(50))
    padded = [len(numbers) * LENGTHS[numbers].max() for numbers in result]
    assert all(size + LENGTHS.max() > 1000 for size in padded[:-1])


def test_a_batch_is_scaled_sorted_and_zero_beyond_the_ends():
    examples = sorted(utterances(3), key=lambda one: -len(one.target))
    dense = [Stream(values=np.full((len(one.target), 2), 1.5, np.float32)) for one in examples]
    scaling = Scaling(np.full(4, 3.0), np.array([10.0, 1, 2, 5]))
    given = batch(with_stream(examples, dense), np.arange(3), scaling)
    assert given.lengths.tolist() == [len(one.target) for one in examples]
    for row, (streams, values, _) in enumerate(examples):
        frames = len(values)
        assert np.array_equal(given.index[row, :frames].numpy(), streams[0].index)
        assert (given.values[row, :frames] == 1.5).all()
        assert np.allclose(given.targets[row, :frames].numpy(), (values - 3) / [10, 1, 2, 5], atol=1e-6)
        for part in (given.index, given.values, given.targets):
            assert not part[row, frames:].any()
    assert (given.index.dtype, given.values.dtype, given.targets.dtype) == (torch.int64, torch.float32, torch.float32)


def test_streams_of_several_blocks_lie_side_by_side():
    index = (np.arange(5)[:, None], np.arange(10).reshape(5, 2))
    streams = (Stream(index=index[0]), Stream(values=np.ones((5, 3))), Stream(index[1], np.zeros((5, 1))))
    given = batch(
        [Example(streams, np.zeros((5, 1), np.float32), RATE)], np.arange(1), Scaling(np.zeros(1), np.ones(1))
    )
    assert np.array_equal(given.index[0].numpy(), np.column_stack(index))
    assert given.values[0].tolist() == [[1, 1, 1, 0]] * 5


def test_content_in_one_pass_against_all_frames_at_once():
    examples = utterances(5)
    frames = np.concatenate([one.target for one in examples]).astype(np.float64)
    found = content(examples, BLOCKS, "training")
    assert np.allclose(found.mean, frames.mean(axis=0))
    assert np.allclose(found.variance, frames.var(axis=0))
    assert found.lengths.tolist() == [len(one.target) for one in examples]
    assert found.digest == content(examples, BLOCKS, "other").digest
    assert found.digest != content(utterances(5, seed=3), BLOCKS, "training").digest


def dense(values):
    examples = utterances(1, frames=(12, 13))
    return content(with_stream(examples, [Stream(values=values)]), {**BLOCKS, "dense": Values(1)}, "training").digest


def test_dense_inputs_that_differ_in_type_or_in_one_byte_are_other_data():
    values = np.linspace(0, 1, 12, dtype=np.float32)[:, None]
    other = values.copy()
    other[5] = np.nextafter(other[5], np.float32(2))
    digests = [dense(one) for one in (values, values.astype(np.float64), other, values.view(np.int32))]
    assert len(set(digests)) == 4
    assert dense(np.asfortranarray(values.copy())) == digests[0]


def test_the_same_bytes_in_another_place_are_other_data():
    index, targets = np.zeros((4, 2), np.int16), np.zeros((4, 2), np.float32)
    blocks = {"a": Values(sizes=(3,)), "b": Values(sizes=(3,))}
    one = Example((Stream(index=index[:, :1]), Stream(index=index[:, :1] + 1)), targets, RATE)
    other = one._replace(streams=one.streams[::-1])
    assert content([one], blocks, "x").digest != content([other], blocks, "x").digest


def test_scaling_of_outputs():
    known = Content(np.array([3]), np.array([1.0, -2, 5]), np.array([4.0, 16, 0]), "")
    everything = Scaling.of(known, "global")
    assert np.allclose(everything.scale, np.sqrt(20 / 3)) and everything.mean.tolist() == [1, -2, 5]
    # What never varies is learned as it is.
    assert Scaling.of(known, "dimension").scale.tolist() == [2, 4, 1]
    nothing = Scaling.of(known, "none")
    assert nothing.scale.tolist() == [1, 1, 1] and not nothing.mean.any()
    assert Scaling.of(replace(known, variance=np.zeros(3)), "global").scale.tolist() == [1, 1, 1]


def test_the_unit_of_an_objective():
    known = Content(np.array([3]), np.zeros(2), np.array([9.0, 9]), "")
    assert Scaling.of(known, "global").unit(2) == pytest.approx(9)
    assert Scaling.of(known, "global").unit(0) == 1
    assert Scaling.of(replace(known, variance=np.array([1.0, 9])), "dimension").unit(2) == 1


def test_an_utterance_that_does_not_fit_its_block_is_named():
    short = with_stream(utterances(1), [Stream(values=np.zeros((20, 2), np.float32))])
    with pytest.raises(DataError, match="`dense`: a stream has 0 categorical and 2 real-valued columns, .* 0 and 1"):
        content(short, {**BLOCKS, "dense": Values(1)}, "training")
