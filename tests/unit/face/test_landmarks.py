from dataclasses import replace

import numpy as np
import pytest

from tests.paths import grid_root
from visualspeech.errors import RejectedUtterance
from visualspeech.face.dlib_tracker import DlibTracker
from visualspeech.face.landmarks import fill_gaps, longest_run, smooth, track
from visualspeech.face.tracker import LandmarkSettings, TrackedVideo

RATE = 25.0
STILL = replace(LandmarkSettings(), smoothing=0.0)


@pytest.fixture(scope="module")
def portrait():
    """A public-domain portrait (the face about 110 pixels wide), without the rest of the photograph."""
    from skimage.data import astronaut

    return np.ascontiguousarray(astronaut()[20:260, 110:350])


@pytest.fixture(scope="module")
def reference(portrait):
    return track([portrait] * 3, STILL, rate=RATE).points[-1]


def moved(picture, x, y, scale=1.0, angle=0.0):
    """The picture moved by (x, y) pixels after scaling and turning it around its middle; and that map, (2, 3)."""
    import cv2

    matrix = cv2.getRotationMatrix2D((120, 120), angle, scale)
    matrix[:, 2] += x, y
    return cv2.warpAffine(picture, matrix, (240, 240), borderMode=cv2.BORDER_REPLICATE), matrix


def frames_of(portrait, count=12):
    return [moved(portrait, 1.5 * np.sin(i / 3), 0.7 * i / 3)[0] for i in range(count)]


def test_points_follow_a_face_that_moves_turns_and_grows(portrait, reference):
    path = [(0.6 * i, -0.35 * i, 1 + 0.006 * i, 0.5 * i) for i in range(30)]
    pictures, maps = zip(*(moved(portrait, *step) for step in path), strict=True)
    result = track(pictures, STILL, rate=RATE)
    assert result.points.shape == (30, 68, 2) and result.points.dtype == np.float32
    assert result.detected.all() and result.findings == () and (result.width, result.height) == (240, 240)
    expected = np.stack([reference @ matrix[:, :2].T + matrix[:, 2] for matrix in maps])
    error = np.linalg.norm(result.points - expected, axis=2)
    assert np.median(error) < 0.7 and error.mean() < 1.0


def test_frames_that_are_views_with_padded_rows_give_the_same_points(portrait):
    padded = np.zeros((240, 256, 3), np.uint8)
    padded[:, :240] = portrait
    one = track([portrait] * 2, STILL, rate=RATE).points
    np.testing.assert_array_equal(track([padded[:, :240]] * 2, STILL, rate=RATE).points, one)


def test_a_face_of_any_size_is_found(portrait):
    import cv2

    for scale in (0.5, 3.0):
        picture = cv2.resize(portrait, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        big = track([picture] * 2, STILL, rate=RATE)
        same = track([portrait] * 2, STILL, rate=RATE).points[-1] * scale + (scale - 1) / 2
        assert big.detected.all()
        assert np.linalg.norm(big.points[-1] - same, axis=1).mean() < 2 * max(scale, 1)


def test_a_few_frames_without_a_face_are_interpolated_and_flagged(portrait):
    frames = frames_of(portrait, 20)
    blank = np.random.default_rng(0).integers(0, 255, portrait.shape).astype(np.uint8)
    whole = track(frames, STILL, rate=RATE).points
    holed = [blank if i in (8, 9) else frame for i, frame in enumerate(frames)]
    result = track(holed, STILL, rate=RATE)
    assert np.flatnonzero(~result.detected).tolist() == [8, 9]
    assert "2 of 20" in result.findings[0]
    np.testing.assert_allclose(result.points[8], whole[7] + (whole[10] - whole[7]) / 3, atol=1.0)
    assert np.linalg.norm(result.points - whole, axis=2).mean() < 0.6


def test_the_face_is_found_again_elsewhere(portrait):
    wide = np.full((240, 480, 3), 90, np.uint8)
    left, right = wide.copy(), wide.copy()
    left[:, :240] = portrait
    right[:, 240:] = portrait
    result = track([left] * 5 + [right] * 5, STILL, rate=RATE)
    assert result.detected.all()
    shift = result.points[-1] - result.points[4]
    np.testing.assert_allclose(shift.mean(0), [240, 0], atol=1.0)


def test_too_few_faces_are_a_reason_to_reject(portrait):
    blank = np.full_like(portrait, 128)
    with pytest.raises(RejectedUtterance, match="no face in any frame"):
        track([blank] * 5, rate=RATE)
    with pytest.raises(RejectedUtterance, match="no face in 4 of 12"):
        track(frames_of(portrait, 8) + [blank] * 4, rate=RATE)
    with pytest.raises(RejectedUtterance, match="no face for 0.44 s"):
        track([portrait] * 60 + [blank] * 11, STILL, rate=RATE)


def test_of_two_faces_the_larger_is_followed(portrait):
    import cv2

    small = cv2.resize(portrait, None, fx=0.8, fy=0.8, interpolation=cv2.INTER_AREA)
    both = np.full((240, 440, 3), 100, np.uint8)
    both[24:216, :192] = small
    both[:, 200:] = portrait
    result = track([both] * 30, STILL, rate=RATE)
    assert result.points[:, :, 0].min() > 200
    assert "2 faces" in result.findings[0]


def test_empty_and_changing_recordings_are_rejected(portrait):
    with pytest.raises(RejectedUtterance, match="no video frames"):
        track([], rate=RATE)
    with pytest.raises(RejectedUtterance, match="size"):
        track([portrait, portrait[:200]], rate=RATE)


def test_gaps_and_runs_against_the_plain_way():
    points = np.random.default_rng(1).normal(size=(8, 2, 2))
    detected = np.array([False, True, False, False, True, True, True, False])
    filled = fill_gaps(np.where(detected[:, None, None], points, np.nan), detected)
    np.testing.assert_array_equal(filled[detected], points[detected])
    np.testing.assert_allclose(filled[2], points[1] * 2 / 3 + points[4] / 3)
    np.testing.assert_allclose(filled[0], points[1])
    np.testing.assert_allclose(filled[7], points[6])
    assert longest_run(~detected) == 2
    assert longest_run(np.ones(4, bool)) == 4 and longest_run(np.zeros(4, bool)) == 0


def test_smoothing_keeps_straight_motion_and_calms_noise():
    line = np.arange(40.0)[:, None, None] * np.ones((1, 3, 2))
    np.testing.assert_allclose(smooth(line, 0.5)[5:-5], line[5:-5], atol=1e-9)
    assert smooth(line, 0.0) is line
    noise = np.random.default_rng(2).normal(size=(400, 3, 2))
    kernel = np.exp(-0.5 * (np.arange(-2, 3) / 0.5) ** 2)
    kernel /= kernel.sum()
    plain = sum(kernel[k] * noise[k : 396 + k] for k in range(5))
    np.testing.assert_allclose(smooth(noise, 0.5)[2:-2], plain, atol=1e-9)


def test_smoothing_and_detection_mean_the_same_at_any_frame_rate():
    """One movement seen at 25 and at 100 frames a second."""
    settings = LandmarkSettings(tracker="tests.unit.face.trackers:Oscillating", smoothing=0.2)
    at = {r: track([np.zeros((4, 5, 3), np.uint8)] * (4 * r), settings, rate=r).points[:, 0, 0] for r in (25, 100)}
    slow = at[100].reshape(-1, 4).mean(axis=1)
    np.testing.assert_allclose(at[25][25:-25], slow[25:-25], atol=0.5)
    assert np.ptp(at[25][25:-25]) < 60  # of 100
    videos = [TrackedVideo("", rate) for rate in (25.0, 100.0, 0.1)]
    assert [DlibTracker(LandmarkSettings(), video)._search_every for video in videos] == [25, 100, 1]


@pytest.mark.skipif(grid_root() is None, reason="GRID is not here (set GRID_ROOT)")
def test_a_grid_recording_is_tracked_steadily():
    from visualspeech.media.reading import read_frames

    file = sorted((grid_root() / "s1").glob("*.mpg"))[0]
    result = track(read_frames(file), rate=RATE)
    assert result.points.shape == (75, 68, 2) and result.detected.all()
    assert np.linalg.norm(np.diff(result.points[:, 27:36], 2, axis=0), axis=2).mean() <= 0.5
