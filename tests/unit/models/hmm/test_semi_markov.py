"""Explicit state durations inside phones, against every path one by one."""

from itertools import combinations

import numpy as np
import pytest
from scipy.stats import norm

from visualspeech.models.hmm import semi_markov as module
from visualspeech.models.hmm.semi_markov import duration_density, expected_durations, semi_markov


def enumerated(density, mean, variance):
    """Probabilities of the states, expected durations and their squares, and log-likelihood, path by path."""
    frames, states = density.shape
    gamma, first, second, total = np.zeros((frames, states)), np.zeros(states), np.zeros(states), 0.0
    for cuts in combinations(range(1, frames), states - 1):
        path = np.searchsorted(cuts, np.arange(frames), side="right")
        spent = np.bincount(path, minlength=states)
        chance = norm.pdf(spent, mean, np.sqrt(variance)).prod()
        chance *= np.exp(density[np.arange(frames), path].sum())
        total += chance
        gamma[np.arange(frames), path] += chance
        first += chance * spent
        second += chance * spent**2
    return gamma / total, first / total, second / total, np.log(total)


def chains(seed=0, count=4, frames=9, states=3):
    generator = np.random.default_rng(seed)
    return (
        2 * generator.normal(size=(count, frames, states)),
        generator.uniform(0.5, 5, size=(count, states)),
        generator.uniform(0.2, 6, size=(count, states)),
    )


@pytest.mark.parametrize(("frames", "states"), [(9, 3), (3, 3), (8, 5), (5, 1), (7, 2), (1, 1)])
@pytest.mark.parametrize("largest", [1 << 21, 1])
def test_against_all_paths(monkeypatch, frames, states, largest):
    monkeypatch.setattr(module, "_LARGEST", largest)
    density, mean, variance = chains(frames, 4, frames, states)
    gamma, squares, likelihood = semi_markov(density, mean, variance)
    for number in range(4):
        expected, first, second, total = enumerated(density[number], mean[number], variance[number])
        assert np.allclose(gamma[number], expected, atol=1e-12)
        assert np.allclose(gamma[number].sum(axis=0), first)
        assert np.allclose(squares[number], second)
        assert np.isclose(likelihood[number], total, rtol=1e-12)


def test_each_phone_is_in_its_place():
    density, mean, variance = chains(4, 1, 27, 3)
    density, lengths = density[0], np.array([7, 2, 5, 1, 7, 5])
    mean, variance = (np.random.default_rng(seed).uniform(0.5, 4, (6, 3)) for seed in (5, 6))
    gamma, squares, likelihood = expected_durations(density, lengths, mean, variance)
    total, paths = 0.0, {1: [0, 2], 3: [1]}
    for phone, (end, length) in enumerate(zip(np.cumsum(lengths), lengths, strict=True)):
        own = density[end - length : end]
        if phone in paths:
            path = np.eye(3)[paths[phone]]
            spent = path.sum(axis=0)
            chance = norm.logpdf(spent, mean[phone], np.sqrt(variance[phone])).sum() + (own * path).sum()
            expected = path, spent, spent**2, chance
        else:
            expected = enumerated(own, mean[phone], variance[phone])
        assert np.allclose(gamma[end - length : end], expected[0], atol=1e-12)
        assert np.allclose(gamma[end - length : end].sum(axis=0), expected[1])
        assert np.allclose(squares[phone], expected[2])
        total += expected[3]
    assert np.isclose(likelihood, total, rtol=1e-12)


def test_no_underflow_in_long_phones():
    density, mean, variance = chains(3, 2, 700, 5)
    gamma, squares, likelihood = semi_markov(density - 500, mean, np.full((2, 5), 0.01))
    assert np.isfinite(likelihood).all() and np.isfinite(squares).all()
    assert np.allclose(gamma.sum(axis=2), 1, atol=1e-9)


def test_durations_decide_where_observations_do_not():
    flat = np.zeros((1, 12, 3))
    gamma, squares, _ = semi_markov(flat, np.array([[2.0, 7.0, 3.0]]), np.full((1, 3), 0.01))
    assert np.allclose(gamma[0].sum(axis=0), [2, 7, 3], atol=1e-6) and np.allclose(squares, [[4, 49, 9]], atol=1e-5)
    gamma, _, _ = semi_markov(flat, np.array([[2.0, 2.0, 2.0]]), np.array([[0.01, 8.0, 0.01]]))
    assert np.allclose(gamma[0].sum(axis=0), [2, 8, 2], atol=0.1)


def test_duration_density_against_scipy():
    assert np.isclose(duration_density(np.array(3), np.array(2.0), np.array(4.0)), norm.logpdf(3, 2, 2))


def test_durations_are_learned_from_phones_whose_states_are_hidden():
    """Expectation and maximisation from equal durations, on phones drawn from a model of known ones."""
    generator = np.random.default_rng(0)
    spent = np.stack([generator.integers(*span, size=400) for span in ((1, 3), (7, 12), (2, 6))], axis=1)
    lengths = spent.sum(axis=1)
    state = np.repeat(np.tile(np.arange(3), 400), spent.ravel())
    density = norm.logpdf(generator.normal(state)[:, None], np.arange(3))  # poses one deviation apart
    mean, variance, before = np.full(3, 5.0), np.full(3, 9.0), -np.inf
    for _ in range(60):
        given = np.tile(mean, (400, 1)), np.tile(variance, (400, 1))
        gamma, squares, likelihood = expected_durations(density, lengths, *given)
        assert likelihood > before - 1e-9 * abs(likelihood)
        before = likelihood
        mean = gamma.sum(axis=0) / 400
        variance = squares.mean(axis=0) - mean**2
    assert np.abs(mean - spent.mean(axis=0)).max() < 0.35
    assert np.abs(np.sqrt(variance) - spent.std(axis=0)).max() < 0.35
