from dataclasses import replace

import numpy as np
import pytest

from tests.unit.models.hmm.speech import PHONES, utterances
from visualspeech.models.hmm.mge import generation_error, gradient, refine
from visualspeech.models.hmm.model import HmmSettings
from visualspeech.models.hmm.training import fit_monophones, fit_tied

SETTINGS = HmmSettings(states=3, rate=50.0, min_frames=4, mdl_factor=0.5, mge_epochs=8)
TRAINING, VALIDATION = utterances(30), utterances(8, seed=7)


@pytest.fixture(scope="module")
def tied():
    return fit_tied(fit_monophones(TRAINING, PHONES, SETTINGS), TRAINING)


@pytest.fixture(scope="module")
def refined(tied):
    return refine(tied, TRAINING, VALIDATION)


def figures(hmm, figure):
    return [value for stage, _, name, value in hmm.about["history"] if (stage, name) == ("mge", figure)]


@pytest.mark.parametrize(("offset_weight", "reading"), [(1.0, "mean"), (0.0, "centre"), (0.2, "mean")])
@pytest.mark.parametrize("part", ["mean", "log_precision"])
def test_gradient_against_finite_differences(tied, part, offset_weight, reading):
    tied = replace(tied, settings=replace(SETTINGS, mge_offset_weight=offset_weight, reading=reading))
    examples = TRAINING[:2]
    slope = getattr(gradient(tied, examples), part)
    generator = np.random.default_rng(0)
    for _ in range(4):
        direction = generator.normal(size=slope.shape)
        if part == "mean":
            direction = direction * np.sqrt(tied.gaussians.variance)
        errors = []
        for step in (1e-4, -1e-4):
            mean, variance = tied.gaussians.mean, tied.gaussians.variance
            if part == "mean":
                moved = replace(tied.gaussians, mean=mean + step * direction)
            else:
                moved = replace(tied.gaussians, variance=variance * np.exp(-step * direction))
            errors.append(gradient(replace(tied, gaussians=moved), examples).error)
        assert np.isclose((errors[0] - errors[1]) / 2e-4, (slope * direction).sum(), rtol=1e-5)


def test_refinement_lowers_the_generation_error(tied, refined):
    assert generation_error(refined, TRAINING) < 0.98 * generation_error(tied, TRAINING)
    assert generation_error(refined, VALIDATION) < generation_error(tied, VALIDATION)
    assert {stage for stage, *_ in refined.about["history"]} == {"monophone", "tied", "mge"}


def test_the_epoch_of_least_validation_error_is_kept(refined):
    found = figures(refined, "validation_error")
    assert np.isclose(generation_error(refined, VALIDATION), min(found))
    worse = refine(replace(refined, settings=replace(SETTINGS, mge_learning_rate=5.0)), TRAINING, VALIDATION)
    assert generation_error(worse, VALIDATION) <= generation_error(refined, VALIDATION)
    assert len(figures(worse, "validation_error")) - len(found) == 1 + SETTINGS.mge_patience


@pytest.mark.parametrize("offset_weight", [1.0, 0.0, 0.2])
def test_generation_error_against_the_predictions(tied, offset_weight):
    hmm = replace(tied, settings=replace(SETTINGS, mge_offset_weight=offset_weight))
    total = 0.0
    for track, values, rate in VALIDATION:
        error = hmm.predict(track, len(values), rate) - values
        total += 0.5 * (np.var(error, axis=0).sum() + offset_weight * (error.mean(axis=0) ** 2).sum()) * len(values)
    frames = sum(len(values) for _, values, _ in VALIDATION)
    assert np.isclose(generation_error(hmm, VALIDATION), total / frames, rtol=1e-4)
    assert np.isclose(gradient(hmm, VALIDATION).error, total, rtol=1e-4)


def test_means_alone(tied):
    settings = replace(SETTINGS, mge_variances=False, mge_epochs=2)
    refined = refine(replace(tied, settings=settings), TRAINING, VALIDATION)
    assert np.array_equal(refined.gaussians.variance, tied.gaussians.variance)
    assert generation_error(refined, TRAINING) < generation_error(tied, TRAINING)


def test_same_input_same_result(tied, refined):
    again = refine(tied, TRAINING, VALIDATION)
    assert np.array_equal(again.gaussians.mean, refined.gaussians.mean)
    assert again.about == refined.about
