"""Gestures: extrema of sinusoids that are known, and what holds of any recording."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.features.visemes.segmentation import Gestures, gestures_of, resampled, speed, stretched
from visualspeech.timing import frame_times

RATE = 200.0


@pytest.mark.parametrize("hertz", [2.0, 3.0, 5.0])
def test_gestures_of_a_sinusoid_end_where_it_turns(hertz):
    """cos(2 pi f t) stands still at every multiple of half a period; smoothing shrinks it and moves nothing."""
    times = frame_times(400, RATE)
    values = np.column_stack([30 * np.cos(2 * np.pi * hertz * times), np.full(400, 7.0)])
    found = gestures_of(values, RATE, 0.03, 0.06)
    turns = np.arange(1, 2 * hertz * 2) / (2 * hertz)
    turns = turns[(turns >= 0.06) & (turns <= 2.0 - 0.06)]
    assert len(found.starts) == 1 + len(turns)
    assert np.allclose((found.starts[1:] + 0.5) / RATE, turns, atol=1 / RATE)


def test_the_speed_of_a_line_is_its_slope_and_that_of_a_sinusoid_its_derivative():
    times = frame_times(600, RATE)
    line = times[:, None] * np.array([3.0, -4.0])
    assert np.allclose(speed(line, RATE, 0.02)[50:-50], 5.0, rtol=1e-3)  # the window is cut at 4 deviations
    sinusoid = np.sin(2 * np.pi * 3 * times)[:, None]
    # A Gaussian window of deviation s weakens a frequency f by exp(-(2 pi f s) ** 2 / 2).
    weaker = np.exp(-((2 * np.pi * 3 * 0.02) ** 2) / 2)
    expected = np.abs(2 * np.pi * 3 * np.cos(2 * np.pi * 3 * times)) * weaker
    assert np.allclose(speed(sinusoid, RATE, 0.02)[50:-50], expected[50:-50], atol=0.02 * expected.max())


def test_a_boundary_is_where_acceleration_along_the_motion_turns_positive():
    """The second route: the derivative of the speed changes its sign from - to + at every boundary."""
    values = np.cumsum(np.random.default_rng(1).normal(size=(500, 6)), axis=0)
    found = gestures_of(values, RATE, 0.05, 0.0)
    slope = np.diff(speed(values, RATE, 0.05))
    turning = np.flatnonzero((slope[:-1] < 0) & (slope[1:] >= 0)) + 1
    assert found.starts[1:].tolist() == turning.tolist() and len(turning) > 10


def test_gestures_cover_the_utterance_and_none_is_too_short():
    for seed in range(20):
        frames = int(np.random.default_rng(seed).integers(1, 400))
        values = np.random.default_rng(seed).normal(size=(frames, 3))
        found = gestures_of(values, 100.0, 0.02, 0.08)
        assert found.starts[0] == 0 and found.lengths.sum() == frames == len(found.of_frames())
        assert len(found.starts) == 1 or found.lengths.min() >= 8
        assert np.array_equal(np.bincount(found.of_frames()), found.lengths)


@pytest.mark.parametrize("frames", [1, 2, 7, 15])
def test_an_utterance_shorter_than_two_gestures_is_one(frames):
    found = gestures_of(np.random.default_rng(0).normal(size=(frames, 3)), 100.0, 0.02, 0.08)
    assert found.starts.tolist() == [0] and found.lengths.tolist() == [frames]


def test_a_face_at_rest_has_gestures():
    assert gestures_of(np.zeros((100, 3)), 100.0, 0.04, 0.06).starts[0] == 0


@pytest.mark.parametrize("values", [np.zeros((0, 3)), np.full((9, 3), np.nan), np.zeros(9)])
def test_what_cannot_be_cut(values):
    with pytest.raises(DataError, match="cannot be cut into gestures"):
        gestures_of(values, 100.0, 0.04, 0.06)


def test_shapes_of_gestures():
    """A line is a line at any length; a gesture that has as many frames as points is its own shape."""
    values = np.arange(24.0)[:, None] * np.array([1.0, 2.0])
    gestures = Gestures(np.array([0, 16]), 24)
    shapes = resampled(values, gestures, 8)
    assert np.allclose(shapes[0, :, 0], np.arange(8) * 2 + 0.5) and np.allclose(shapes[1], values[16:])
    again = stretched(shapes, gestures.lengths)
    assert np.allclose(again[16:], values[16:])
    # Beyond the first and the last point the shape is constant.
    assert np.allclose(again[1:15], values[1:15]) and np.allclose(again[0], shapes[0, 0])


def test_a_gesture_of_one_frame_has_a_shape():
    assert np.allclose(
        resampled(np.array([[3.0], [4.0]]), Gestures(np.array([0, 1]), 2), 8)[:, :, 0], [[3] * 8, [4] * 8]
    )
