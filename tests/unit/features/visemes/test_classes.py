"""Classes of gestures: planted ones are found, and what k-means must hold is checked by hand."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.features.visemes.classes import POINTS, ShapeSample, VisemeClasses, fit_classes
from visualspeech.features.visemes.segmentation import Gestures, resampled

SHAPES = np.random.default_rng(3).normal(0, 20, (5, POINTS, 4))
COUNTS = (40, 30, 20, 15, 10)


def planted(noise=1.0, seed=1):
    """Gestures of five shapes, shuffled: shapes (G, POINTS, 4) and their classes."""
    random = np.random.default_rng(seed)
    members = random.permutation(np.repeat(np.arange(5), COUNTS))
    return (SHAPES[members] + random.normal(0, noise, (len(members), POINTS, 4))).astype(np.float32), members


def test_planted_classes_are_found():
    shapes, members = planted()
    found = fit_classes(np.split(shapes, 7 * np.arange(1, 10)), 5, seed=1)
    assert found.counts.tolist() == list(COUNTS)  # the most frequent first
    assert np.abs(found.means - SHAPES).max() < 4 * 1.0 / np.sqrt(min(COUNTS))
    assert np.array_equal(found.distances(shapes).argmin(axis=1), members)


def test_the_means_are_those_of_the_gestures_nearest_to_them():
    """The fixed point of k-means, by another route than its library's."""
    shapes = np.random.default_rng(5).normal(size=(300, POINTS, 3)).astype(np.float32)
    found = fit_classes([shapes], 7, seed=2)
    nearest = np.square(shapes[:, None] - found.means).sum(axis=(2, 3)).argmin(axis=1)
    for number in range(7):
        assert np.allclose(found.means[number], shapes[nearest == number].mean(axis=0), atol=1e-5)


def test_distances_are_those_of_the_definition():
    found = VisemeClasses(SHAPES.astype(np.float32) + 1000, np.ones(5, np.int64))
    shapes = (np.random.default_rng(6).normal(0, 20, (9, POINTS, 4)) + 1000).astype(np.float32)
    slow = [[np.square(one - mean).sum(axis=1).mean() for mean in found.means.astype(float)] for one in shapes]
    assert np.allclose(found.distances(shapes), slow, rtol=1e-5)


def test_assignment_and_reconstruction_of_an_utterance():
    found = VisemeClasses(SHAPES.astype(np.float32), np.ones(5, np.int64))
    gestures, members = Gestures(np.arange(0, 4 * POINTS, POINTS), 4 * POINTS), np.array([2, 0, 4, 2])
    values = SHAPES[members].reshape(-1, 4)
    assert found.assign(values, gestures).tolist() == members.tolist()
    assert np.allclose(found.reconstruct(members, gestures), values, atol=1e-4)


def test_the_seed_decides():
    shapes = np.random.default_rng(7).normal(size=(400, POINTS, 3)).astype(np.float32)
    one, same, other = (fit_classes([shapes], 20, seed=seed).means for seed in (1, 1, 2))
    assert np.array_equal(one, same) and not np.array_equal(one, other)


def test_more_classes_than_gestures():
    shapes, _ = planted()
    assert len(fit_classes([shapes], len(shapes), seed=1)) == len(shapes)
    with pytest.raises(DataError, match=r"`classes: 160` asks .* than there are gestures: .* have 115"):
        fit_classes([shapes], 160, seed=1)
    with pytest.raises(DataError, match="no training utterance"):
        fit_classes([], 5, seed=1)


def test_equal_gestures_make_classes_too():
    found = fit_classes([np.ones((10, POINTS, 2), np.float32)], 3, seed=1)
    assert np.isfinite(found.means).all() and found.counts.sum() == 10


def test_a_large_corpus_is_thinned_evenly():
    sample, numbers = ShapeSample(limit=10), np.arange(83, dtype=np.float32)
    for part in np.split(numbers, [1, 2, 30, 31, 60]):
        sample.add(part[:, None, None])
    kept = sample.shapes()[:, 0, 0]
    assert sample.gestures == 83 and len(kept) <= 10
    assert np.array_equal(kept, np.arange(0, 83, kept[1]))


def test_resampled_gestures_do_not_depend_on_their_length():
    values = np.sin(np.linspace(0, 1, 60))[:, None]
    whole, half = (resampled(values[::step], Gestures(np.array([0]), len(values[::step])), POINTS) for step in (1, 2))
    assert np.abs(whole - half).max() < 0.02
