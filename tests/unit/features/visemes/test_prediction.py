"""Visemes of a text: sums against plain regression, the best path against all paths, and who knows which utterance."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from tests.unit.features.visemes.speakers import PHONES, RATE, corpus
from visualspeech.errors import DataError
from visualspeech.features.labels import label_indices
from visualspeech.features.visemes.classes import POINTS, fit_classes
from visualspeech.features.visemes.prediction import (
    Labelled,
    best_path,
    digest_of,
    fit_text_model,
    fold_of,
)
from visualspeech.features.visemes.regression import Sums
from visualspeech.features.visemes.segmentation import gestures_of, resampled
from visualspeech.features.visemes.text_features import OFFSETS, frame_codes, indicators, number_of_codes

CLASSES, FOLDS = 8, 4
SOURCES = corpus(20)


def labelled(sources, classes=None):
    cut = [(one, gestures_of(one.parameters, RATE, 0.03, 0.06)) for one in sources]
    found = classes or fit_classes((resampled(one.parameters, own, POINTS) for one, own in cut), CLASSES, 1)
    return found, [
        Labelled(one.id, one.alignment, one.parameters, RATE, own, found.assign(one.parameters, own))
        for one, own in cut
    ]


FOUND, TRAINING = labelled(SOURCES)
MODEL = fit_text_model(lambda: TRAINING, PHONES, CLASSES, FOLDS)


def test_indicators_against_the_labels_of_the_frames():
    one, count = SOURCES[0], len(PHONES)
    codes = frame_codes(one.alignment, one.frames, RATE, PHONES)
    assert codes.shape == (one.frames, len(OFFSETS) + 5) and codes.max() < number_of_codes(count)
    left, phone, right, third = label_indices(one.alignment, one.frames, RATE, PHONES, "thirds").T.astype(int)
    middle = len(OFFSETS) // 2
    assert np.array_equal(codes[:, middle], middle * count + phone)
    # 20 ms are two frames at 100 Hz.
    assert np.array_equal(codes[2:, middle - 1] - (middle - 1) * count, phone[:-2])
    assert (codes[:2, 0] == 0).all() and (codes[-2:, len(OFFSETS) - 1] % count == 0).all()
    first = len(OFFSETS) * count
    assert np.array_equal(codes[:, len(OFFSETS)], first + left * 3 + third)
    assert np.array_equal(codes[:, -1], number_of_codes(count) - 3 * count**2 + (phone * count + right) * 3 + third)


def test_only_known_indicators_count():
    rows = indicators(np.array([[1, 5], [7, 5], [2, 3]]), np.array([5, 7])).toarray()
    assert rows.tolist() == [[1, 0], [1, 1], [0, 0]]


def test_sums_give_ridge_regression():
    from sklearn.linear_model import Ridge

    random = np.random.default_rng(1)
    codes, values = random.integers(0, 12, (200, 3)) + [0, 12, 24], random.normal(size=(200, 2))
    known = np.arange(36)
    sums = Sums.of(codes[:120], values[:120], known) + Sums.of(codes[120:], values[120:], known)
    weights, offset = sums.solve(3.0)
    rows = indicators(codes, known).toarray()
    peer = Ridge(3.0, fit_intercept=False).fit(rows, values - values.mean(axis=0))
    assert np.allclose(weights, peer.coef_.T) and np.allclose(offset, values.mean(axis=0))
    slow = np.square(values - offset - rows @ weights).sum(axis=0)
    assert np.allclose(sums.errors(weights, offset), slow)


def test_a_fold_is_what_regression_without_it_gives():
    """Subtracted sums against a fit that never sees the fold."""
    for fold in range(FOLDS):
        others = [one for one in TRAINING if MODEL.crossfit.fold_of(one.utterance) != fold]
        assert 0 < len(others) < len(TRAINING)
        codes = np.concatenate([frame_codes(one.alignment, len(one.values), RATE, PHONES) for one in others])
        wanted = [np.c_[one.values, np.eye(CLASSES)[one.classes[one.gestures.of_frames()]]] for one in others]
        weights, offsets = Sums.of(codes, np.concatenate(wanted), MODEL.known).solve(0.1 * RATE)
        assert np.allclose(MODEL.crossfit.weights[fold], weights, atol=2e-3)
        assert np.allclose(MODEL.crossfit.offsets[fold], offsets, atol=1e-4)


def test_cross_fitting_excludes_the_utterance():
    """A recording that is changed at random does not change what is predicted of it, and does change that of others."""
    name = TRAINING[3].utterance
    noise = np.random.default_rng(9).normal(0, 30, TRAINING[3].values.shape).astype(np.float32)
    changed = [replace(one, values=noise) if one.utterance == name else one for one in TRAINING]
    other = fit_text_model(lambda: changed, PHONES, CLASSES, FOLDS)
    fold = MODEL.crossfit.fold_of(name)
    differ = []
    for one in TRAINING:
        asked = one.alignment, len(one.values), RATE, PHONES, one.utterance
        differ.append(
            max(np.abs(a - b).max() for a, b in zip(MODEL.predict(*asked), other.predict(*asked), strict=True))
        )
        assert (differ[-1] < 1e-2) == (MODEL.crossfit.fold_of(one.utterance) == fold)
    # Whoever is not of the training is predicted by the model of all.
    asked = TRAINING[3].alignment, len(noise), RATE, PHONES
    assert np.abs(MODEL.predict(*asked)[0] - other.predict(*asked)[0]).max() > 0.1
    assert np.array_equal(MODEL.predict(*asked, "new")[0], MODEL.predict(*asked)[0])


def test_folds_are_even_and_belong_to_ids():
    assert sorted(np.bincount([MODEL.crossfit.fold_of(one.id) for one in SOURCES])) == [5] * 4
    turned = fit_text_model(lambda: TRAINING[::-1], PHONES, CLASSES, FOLDS)
    assert np.array_equal(turned.crossfit.training, MODEL.crossfit.training)
    assert np.allclose(turned.weights, MODEL.weights, atol=1e-3)
    digests = np.sort([digest_of(name) for name in "abc"])
    assert sorted(fold_of(name, digests, 3) for name in "abc") == [0, 1, 2] and fold_of("d", digests, 3) is None


def test_training_utterances_are_predicted_as_badly_as_new_ones():
    """The purpose of cross-fitting: errors of training streams are those of test streams."""
    noisy, new = corpus(16, seed=2, words=4), corpus(40, seed=77, words=4)
    noisy, new = (
        [replace(one, parameters=one.parameters + np.random.default_rng([n, 5]).normal(0, 6, 4).astype(np.float32))
         for n, one in enumerate(part)]
        for part in (noisy, new)
    )  # fmt: skip
    model = fit_text_model(lambda: labelled(noisy)[1], PHONES, CLASSES, 8)

    def error(sources, name):
        predicted = [model.predict(one.alignment, one.frames, RATE, PHONES, name(one))[0] for one in sources]
        return np.mean(
            [np.square(a - one.parameters).sum(axis=1).mean() for a, one in zip(predicted, sources, strict=True)]
        )

    known, left_out, unknown = (
        error(noisy, lambda one: ""),
        error(noisy, lambda one: one.id),
        error(new, lambda one: ""),
    )
    assert known < 0.9 * left_out and abs(left_out / unknown - 1) < 0.2
    assert model.error == pytest.approx(left_out, rel=1e-3)


def test_visemes_of_a_predictable_face_are_predicted():
    new = corpus(10, seed=50)
    same = frames = 0
    for one, known in zip(new, labelled(new, FOUND)[1], strict=True):
        values, shares = MODEL.predict(one.alignment, one.frames, RATE, PHONES)
        gestures = gestures_of(values, RATE, 0.03, 0.06)
        predicted = MODEL.classes_of(FOUND, values, shares, gestures)[gestures.of_frames()]
        same += (predicted == known.classes[known.gestures.of_frames()]).sum()
        frames += one.frames
    most = np.bincount(np.concatenate([one.classes[one.gestures.of_frames()] for one in TRAINING])).max()
    chance = most / sum(one.frames for one in SOURCES)
    assert same / frames > 2 * chance


def test_best_path_against_all_paths():
    random = np.random.default_rng(4)
    for _ in range(5):
        scores, follows = random.normal(size=(5, 3)), random.normal(size=(4, 3))
        paths = list(product(range(3), repeat=5))
        totals = [
            follows[-1, path[0]]
            + scores[np.arange(5), path].sum()
            + sum(follows[a, b] for a, b in zip(path[:-1], path[1:], strict=True))
            for path in paths
        ]
        assert tuple(best_path(scores, follows)) == paths[int(np.argmax(totals))]
    assert best_path(np.array([[0.0, 1.0]]), np.zeros((3, 2))).tolist() == [1]


def test_pairs_of_classes_are_counted():
    follows = np.exp(MODEL.follows.astype(float))
    assert np.allclose(follows.sum(axis=1), 1)
    starts = np.bincount([one.classes[0] for one in TRAINING], minlength=CLASSES)
    assert np.allclose(follows[-1], (starts + 0.05) / (starts + 0.05).sum())


def test_few_utterances():
    one = fit_text_model(lambda: TRAINING[:1], PHONES, CLASSES, FOLDS)
    assert one.crossfit is None and np.isfinite(one.weights).all() and one.error > 0
    assert len(fit_text_model(lambda: TRAINING[:3], PHONES, CLASSES, FOLDS).crossfit.weights) == 3
    with pytest.raises(DataError, match="no training utterance"):
        fit_text_model(lambda: [], PHONES, CLASSES, FOLDS)
