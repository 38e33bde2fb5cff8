import numpy as np
import torch

from tests.unit.models.examples import PHONES, utterances
from visualspeech.models.batches import batch, batches, content


def test_batches_hold_every_utterance_once_and_similar_lengths():
    lengths = np.random.default_rng(1).integers(10, 100, 50)
    result = batches(lengths, 8, np.random.default_rng(2).permutation(50))
    assert sorted(np.concatenate(result)) == list(range(50))
    assert all((np.diff(lengths[batch]) <= 0).all() for batch in result)


def test_a_batch_is_scaled_sorted_and_zero_beyond_the_ends():
    examples = sorted(utterances(3), key=lambda pair: -len(pair[0]))
    labels, lengths, targets = batch(examples, np.arange(3), np.full(4, 3.0), 10.0)
    assert lengths.tolist() == [len(values) for _, values in examples]
    for row, (indices, values) in enumerate(examples):
        assert np.array_equal(labels[row, : len(values)].numpy(), indices)
        assert np.allclose(targets[row, : len(values)].numpy(), (values - 3) / 10, atol=1e-6)
        assert not targets[row, len(values) :].any() and not labels[row, len(values) :].any()
    assert labels.dtype == torch.int64


def test_content_in_one_pass_against_all_frames_at_once():
    examples = utterances(5)
    frames = np.concatenate([values for _, values in examples]).astype(np.float64)
    found = content(examples, len(PHONES), "training")
    assert np.allclose(found.mean, frames.mean(axis=0))
    assert np.isclose(found.deviation, np.sqrt(frames.var(axis=0).mean()))
    assert found.digest == content(examples, len(PHONES), "other").digest
    assert found.digest != content(utterances(5, seed=3), len(PHONES), "training").digest
