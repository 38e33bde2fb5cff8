from itertools import combinations

import numpy as np

from visualspeech.models.hmm.chains import even_states, expected_states, forward_backward, timed_states


def paths(frames, states):
    """All ways to share out frames over states that follow each other, each with one frame at least."""
    for cuts in combinations(range(1, frames), states - 1):
        yield np.searchsorted(cuts, np.arange(frames), side="right")


def enumerated(density, stay):
    """Every path's probability, one by one."""
    frames, states = density.shape
    gamma, total = np.zeros((frames, states)), 0.0
    for path in paths(frames, states):
        spent = np.bincount(path, minlength=states)
        chance = np.prod(stay ** (spent - 1)) * np.prod(1 - stay)
        chance *= np.exp(density[np.arange(frames), path].sum())
        total += chance
        gamma[np.arange(frames), path] += chance
    return gamma / total, np.log(total)


def chains(seed=0, count=4, frames=9, states=3):
    generator = np.random.default_rng(seed)
    return 3 * generator.normal(size=(count, frames, states)), generator.uniform(0.05, 0.95, size=(count, states))


def test_forward_backward_against_all_paths():
    density, stay = chains()
    lengths = np.array([9, 3, 6, 4])
    gamma, likelihood = forward_backward(density, lengths, stay)
    for number, length in enumerate(lengths):
        expected, total = enumerated(density[number, :length], stay[number])
        assert np.allclose(gamma[number, :length], expected, atol=1e-12)
        assert not gamma[number, length:].any()
        assert np.isclose(likelihood[number], total, rtol=1e-12)


def test_forward_backward_against_hmmlearn():
    from hmmlearn.hmm import GaussianHMM

    density, stay = chains(1, 1, 12, 4)
    means, deviation = np.array([[0.0], [1.0], [3.0], [-1.0]]), 0.7
    observed = np.random.default_rng(2).normal(size=(12, 1))
    log_density = -0.5 * ((observed - means.T) / deviation) ** 2 - np.log(deviation * np.sqrt(2 * np.pi))
    # The end is a fifth state that emits a value of its own.
    model = GaussianHMM(5, "diag", init_params="", params="")
    model.startprob_ = np.eye(5)[0]
    model.transmat_ = np.diag([*stay[0], 1.0]) + np.diag(1 - stay[0], 1)
    model.means_ = np.vstack([means, [[1e3]]])
    model.covars_ = np.full((5, 1), deviation**2)
    likelihood, gamma = model.score_samples(np.vstack([observed, [[1e3]]]))
    ours, total = forward_backward(log_density[None], np.array([12]), stay)
    assert np.allclose(gamma[:-1, :-1], ours[0], atol=1e-8)
    assert np.isclose(total[0] - np.log(deviation * np.sqrt(2 * np.pi)), likelihood)


def test_no_underflow_in_long_chains():
    density, stay = chains(3, 2, 2000, 5)
    gamma, likelihood = forward_backward(density - 500, np.array([2000, 1500]), stay)
    assert np.isfinite(likelihood).all()
    assert np.allclose(gamma[0].sum(axis=1), 1) and np.allclose(gamma[1, :1500].sum(axis=1), 1)


def test_expected_states_puts_each_phone_in_its_place():
    generator = np.random.default_rng(4)
    lengths = np.array([2, 7, 1, 5])
    density, stay = generator.normal(size=(15, 3)), generator.uniform(0.2, 0.8, size=(4, 3))
    result, likelihood = expected_states(density, lengths, stay)
    first, one = enumerated(density[2:9], stay[1])
    second, other = enumerated(density[10:], stay[3])
    assert np.allclose(result[2:9], first) and np.allclose(result[10:], second)
    short = [0, 1, 9]
    assert np.array_equal(result[short].argmax(axis=1), [0, 2, 1])
    expected = one + other + sum(density[at, state] for at, state in zip(short, [0, 2, 1], strict=True))
    assert np.isclose(likelihood, expected)


def test_even_states():
    assert even_states(np.array([5, 3, 1, 10]), 5).tolist() == [*range(5), 0, 2, 4, 2, *np.repeat(range(5), 2)]


def test_durations_fill_the_phone_and_stretch_where_they_vary():
    mean, variance = np.array([[2.0, 2.0, 2.0]]), np.array([[0.01, 8.0, 0.01]])
    assert np.bincount(timed_states(np.array([20]), mean, variance)).tolist() == [2, 16, 2]
    assert np.bincount(timed_states(np.array([6]), mean, variance)).tolist() == [2, 2, 2]
    # Far too short: no duration is negative, each state keeps a share.
    assert len(timed_states(np.array([2]), mean, variance)) == 2
