import cv2
import numpy as np
import pytest

from visualspeech.animation.warping import backward_map, displacement, wendland


@pytest.fixture
def moving():
    random = np.random.default_rng(3)
    points = random.uniform(40, 110, (12, 2))
    return points, random.normal(0, 2, (12, 2))


def test_wendland_falls_from_one_to_zero_with_flat_ends():
    at = np.linspace(0, 1.5, 301)
    values = wendland(at)
    assert values[0] == 1 and np.all(values[at >= 1] == 0)
    assert np.all(np.diff(values) <= 0)
    slope = np.gradient(values, at)
    assert abs(slope[0]) < 0.1 and abs(slope[np.searchsorted(at, 1.0)]) < 1e-3


def test_displacement_meets_the_given_values(moving):
    points, moves = moving
    np.testing.assert_allclose(displacement(points, points, moves, 60.0, 0.0), moves, atol=1e-3)


def test_displacement_is_zero_beyond_the_reach(moving):
    points, moves = moving
    far = np.array([[500.0, 500.0], [-100.0, 20.0]])
    assert np.all(displacement(far, points, moves, 60.0, 0.02) == 0)


def test_displacement_agrees_with_a_plain_sum(moving):
    points, moves = moving
    place = np.array([70.0, 60.0])
    gram = np.array([[wendland(np.hypot(*(p - q)) / 60) for q in points] for p in points])
    coefficients = np.linalg.inv(gram + 0.02 * np.eye(len(points))) @ moves
    plain = sum(wendland(np.hypot(*(place - p)) / 60) * c for p, c in zip(points, coefficients, strict=True))
    np.testing.assert_allclose(displacement(place[None], points, moves, 60.0, 0.02)[0], plain, atol=1e-4)


def test_coarse_map_is_the_fine_map_to_a_tenth_of_a_pixel(moving):
    points, _ = moving
    moves = (points - 75) @ np.array([[0.05, 0.02], [-0.03, 0.08]])  # as smooth as a jaw
    coarse = backward_map((10, 20), (120, 100), points, moves, 60.0, 0.1, step=4)
    fine = backward_map((10, 20), (120, 100), points, moves, 60.0, 0.1, step=1)
    for a, b in zip(coarse, fine, strict=True):
        assert a.shape == (100, 120) and a.dtype == np.float32
        np.testing.assert_allclose(a, b, atol=0.1)


def test_a_dot_is_moved_to_where_it_is_wanted():
    picture = np.zeros((100, 120), np.float32)
    cv2.circle(picture, (50, 40), 3, 1.0, -1)
    x, y = backward_map((0, 0), (120, 100), np.array([[56.0, 45.0]]), np.array([[6.0, 5.0]]), 50.0, 0.0, step=2)
    moved = cv2.remap(picture, x, y, cv2.INTER_LINEAR)
    rows, columns = np.nonzero(moved > 0.5)
    assert abs(columns.mean() - 56) < 0.5 and abs(rows.mean() - 45) < 0.5
    assert moved[38, 47] == 0  # nothing stays behind


def test_nothing_moves_where_nothing_should():
    x, y = backward_map((5, 7), (20, 10), np.array([[10.0, 10.0]]), np.zeros((1, 2)), 30.0, 0.0, step=3)
    np.testing.assert_array_equal(x, np.broadcast_to(5 + np.arange(20.0), (10, 20)))
    np.testing.assert_array_equal(y, np.broadcast_to(7 + np.arange(10.0)[:, None], (10, 20)))
