import numpy as np
import pytest

from visualspeech.models.trajectory.generation import generate
from visualspeech.models.trajectory.windows import observations, stacked, unstacked, window_matrix


def gaussians(frames, width=2, seed=0):
    generator = np.random.default_rng(seed)
    return generator.normal(size=(frames, 3 * width)), np.exp(generator.normal(size=(frames, 3 * width)))


@pytest.mark.parametrize(("frames", "step"), [(1, 1), (2, 1), (3, 4), (9, 1), (30, 4)])
def test_windows_are_their_matrix(frames, step):
    values = np.random.default_rng(1).normal(size=(frames, 2))
    seen = observations(values, step)
    assert np.allclose(window_matrix(frames, step) @ values, stacked(seen))
    assert np.array_equal(unstacked(stacked(seen)), seen)


def test_windows_of_a_parabola():
    time = np.arange(20.0)[:, None]
    seen = observations(3 * time**2 + time, 2)[2:-2]
    inner = time[2:-2]
    expected = np.hstack([3 * inner**2 + inner, 2 * (6 * inner + 1), np.full_like(inner, 4 * 6.0)])
    assert np.allclose(seen, expected)


@pytest.mark.parametrize(("frames", "step"), [(1, 1), (2, 3), (5, 4), (12, 1), (40, 4)])
def test_generation_against_dense_least_squares(frames, step):
    means, precisions = gaussians(frames)
    matrix = window_matrix(frames, step).toarray()
    mean, root = stacked(means), np.sqrt(stacked(precisions))
    expected = [
        np.linalg.lstsq(root[:, n : n + 1] * matrix, root[:, n] * mean[:, n], rcond=None)[0]
        for n in range(mean.shape[1])
    ]
    assert np.allclose(generate(means, precisions, step).values, np.array(expected).T, atol=1e-9)


def test_gaussians_of_a_real_stream_give_it_back():
    values = np.random.default_rng(3).normal(size=(25, 3))
    seen = observations(values, 2)
    assert np.allclose(generate(seen, np.full_like(seen, 7.0), 2).values, values)


def test_back_is_the_transposed_solution():
    means, precisions = gaussians(15)
    trajectory = generate(means, precisions, 2)
    error = np.random.default_rng(5).normal(size=trajectory.values.shape)
    shift = np.random.default_rng(6).normal(size=means.shape)
    moved = generate(means + shift, precisions, 2).values - trajectory.values
    # Generation is linear in the means: <error, A shift> = <A' error, shift>.
    assert np.isclose((error * moved).sum(), (precisions * trajectory.back(error) * shift).sum())
