"""Blinks by the eye aspect ratio: the scalars of the module, on drawn eyes and on GRID's recordings."""

import numpy as np
import pytest

from tests.paths import grid_root
from tests.unit.animation.faces import points68
from visualspeech.face.blinks import blinks, double_blinks, eye_opening, eyes_closed

RATE = 25.0


def eyes(openings):
    """Landmarks (T, 68, 2) of faces whose eyes are 20 wide and open by shares of 8 pixels."""
    points = np.repeat(points68()[None], len(openings), axis=0)
    for eye in (36, 42):
        across, up = np.array([0, 6, 14, 20, 14, 6]), np.array([0, -4, -4, 0, 4, 4])
        for frame, opening in enumerate(openings):
            points[frame, eye : eye + 6] = np.stack([100 + across + eye, 100 + opening * up], axis=1)
    return points


def blinking(*frames, length=75):
    """Openings of a recording with closed eyes in these frames."""
    openings = np.ones(length)
    openings[list(frames)] = 0.3
    return eyes(openings)


def test_the_opening_is_the_eye_aspect_ratio():
    """Height over width, which neither size nor roll of the face changes."""
    points = eyes([1, 0.5])
    np.testing.assert_allclose(eye_opening(points), [8 / 20, 4 / 20])
    angle = 0.4
    turned = 3 * points @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    np.testing.assert_allclose(eye_opening(turned), [8 / 20, 4 / 20])


def test_eyes_below_a_share_of_the_median_are_closed():
    assert np.flatnonzero(eyes_closed(blinking(4, 5, 30))).tolist() == [4, 5, 30]
    openings = np.ones(20)
    openings[3] = 0.75
    assert not eyes_closed(eyes(openings)).any() and eyes_closed(eyes(openings), 0.8).sum() == 1


def test_runs_of_closed_eyes_are_blinks():
    closed = np.array([1, 1, 0, 0, 1, 0, 1, 1], bool)
    assert blinks(closed).tolist() == [[0, 2], [4, 5], [6, 8]]
    assert blinks(np.zeros(4, bool)).shape == (0, 2) and blinks(np.ones(4, bool)).tolist() == [[0, 4]]


@pytest.mark.parametrize(
    ("frames", "count"),
    [
        ((), 0),
        ((10, 11, 12), 0),
        ((10, 11, 15, 16), 1),  # 0.12 s apart
        ((10, 22), 1),  # 0.44 s
        ((10, 24), 0),  # 0.52 s
        ((10, 14, 18), 2),
    ],
)
def test_two_blinks_within_half_a_second_are_double(frames, count):
    assert double_blinks(blinking(*frames), RATE) == count


def test_the_time_between_blinks_is_in_seconds():
    assert double_blinks(blinking(10, 40), 25.0) == 0 and double_blinks(blinking(10, 40), 100.0) == 1


@pytest.mark.skipif(grid_root() is None, reason="GRID is not here (set GRID_ROOT)")
@pytest.mark.parametrize(("name", "found"), [("bbaf5a", [7, 14, 42, 49]), ("bbbf6n", [39, 46])])
def test_blinks_of_grid_are_found_where_they_are_seen(name, found):
    """First frames of the blinks, as seen in the frames themselves; both recordings blink twice at once."""
    from visualspeech.face.screening import track_recording

    landmarks, rate = track_recording(grid_root() / "s1" / f"{name}.mpg", 0, 0)
    starts = blinks(eyes_closed(landmarks.points))[:, 0]
    for frame in found:
        assert np.abs(starts - frame).min() <= 1
    assert double_blinks(landmarks.points, rate) >= len(found) // 2
