from functools import partial

import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.face import drift
from visualspeech.face.drift import DriftSettings, FaceReference

reference_of = partial(drift.reference_of, rate=25.0)


def _utterance(frames=40, seed=0):
    generator = np.random.default_rng(seed)
    shape = generator.normal(100, 5, (frames, 102)).astype(np.float32)
    return shape, generator.integers(0, 256, (frames, 30), dtype=np.uint8)


def test_reference_is_the_mean_of_the_frames_that_the_method_names():
    shape, texture = _utterance()
    silent = np.arange(40) < 12
    means = reference_of(shape, texture)
    np.testing.assert_allclose(means.shape, shape.mean(axis=0), rtol=1e-5)
    np.testing.assert_allclose(means.texture, texture.mean(axis=0), rtol=1e-5)
    quiet = reference_of(shape, texture, silent, DriftSettings("silence"))
    np.testing.assert_allclose(quiet.texture, texture[:12].mean(axis=0), rtol=1e-5)
    none = reference_of(shape, texture, settings=DriftSettings("none"))
    assert not none.shape.any() and not none.texture.any()


def test_without_enough_silence_the_clip_mean_serves():
    shape, texture = _utterance()
    silent = np.arange(40) < 4
    found = reference_of(shape, texture, silent, DriftSettings("silence", min_silent_seconds=0.2))
    np.testing.assert_array_equal(found.texture, reference_of(shape, texture).texture)


@pytest.mark.parametrize(("rate", "enough"), [(25.0, 5), (100.0, 20)])
def test_enough_silence_is_a_time_and_not_a_number_of_frames(rate, enough):
    shape, texture = _utterance()
    for frames in (enough - 1, enough):
        found = reference_of(shape, texture, np.arange(40) < frames, DriftSettings("silence"), rate=rate)
        expected = texture[:frames] if frames == enough else texture
        np.testing.assert_allclose(found.texture, expected.mean(axis=0), rtol=1e-5)


@pytest.mark.parametrize("method", drift.METHODS)
def test_a_change_of_seat_and_light_leaves_no_trace(method):
    shape, texture = _utterance()
    silent = np.arange(40) % 3 == 0
    settings = DriftSettings(method)
    corpus = FaceReference(np.full(102, 3, np.float32), np.full(30, 9, np.float32))
    moved, lit = shape + 7, texture / 2.0 + 20  # half the range, so that light can be added without clipping
    one = drift.remove(shape, texture / 2.0, reference_of(shape, texture / 2.0, silent, settings), corpus)
    two = drift.remove(moved, lit, reference_of(moved, lit, silent, settings), corpus)
    same = [np.allclose(a, b, atol=1e-3) for a, b in zip(one, two, strict=True)]
    assert same == [method != "none"] * 2


def test_restoring_is_the_inverse_of_removing():
    shape, texture = _utterance()
    own = reference_of(shape, texture)
    corpus = drift.corpus_reference([own, reference_of(*_utterance(seed=1))])
    back = drift.restore(*drift.remove(shape, texture, own, corpus), own, corpus)
    np.testing.assert_allclose(back[0], shape, atol=1e-3)
    np.testing.assert_allclose(back[1], texture, atol=1e-3)
    np.testing.assert_array_equal(drift.remove_shape(shape, own, corpus), drift.remove(shape, texture, own, corpus)[0])


def test_removing_moves_the_reference_onto_the_corpus_and_keeps_the_movement():
    shape, texture = _utterance()
    own = reference_of(shape, texture)
    corpus = FaceReference(np.zeros(102, np.float32), np.full(30, 50, np.float32))
    moved, lit = drift.remove(shape, texture, own, corpus)
    np.testing.assert_allclose(lit.mean(axis=0), 50, atol=1e-3)
    np.testing.assert_allclose(np.diff(moved, axis=0), np.diff(shape, axis=0), atol=1e-3)


def test_corpus_reference_counts_every_utterance_once_and_without_drift_is_zero():
    one, two = (FaceReference(np.full(102, x, np.float32), np.full(30, x, np.float32)) for x in (1, 4))
    assert drift.corpus_reference(iter([one, one, two])).shape[0] == 2
    settings = DriftSettings("none")
    nothing = drift.corpus_reference(reference_of(*_utterance(seed=s), None, settings) for s in range(3))
    assert not nothing.texture.any()


def test_what_does_not_fit_is_refused():
    shape, texture = _utterance()
    with pytest.raises(SettingError, match="`drift.method: median` must be one of clip_mean"):
        DriftSettings("median")
    with pytest.raises(DataError, match="40 shapes and 39"):
        reference_of(shape, texture[1:])
    with pytest.raises(DataError, match="silent frames"):
        reference_of(shape, texture, None, DriftSettings("silence"))
    with pytest.raises(DataError, match="no training utterances"):
        drift.corpus_reference([])
