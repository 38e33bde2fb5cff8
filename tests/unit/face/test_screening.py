import numpy as np
import pytest

from tests.unit.face.heads import record
from visualspeech.errors import RejectedUtterance
from visualspeech.face import screening
from visualspeech.face.tracker import LandmarkSettings

RATE = 25.0


def moving_pictures(frames=40, seed=0):
    """A smooth random picture that drifts, with a little noise as cameras have."""
    rng = np.random.default_rng(seed)
    import cv2

    still = cv2.GaussianBlur(rng.uniform(0, 255, (200, 260, 3)), (0, 0), 9)
    still = (still - still.mean()) * 8 + 120
    for frame in range(frames):
        part = still[frame % 50 : frame % 50 + 144, 20:200]
        yield np.clip(part + rng.normal(0, 2, part.shape), 0, 255).astype(np.uint8)


def measures(frames):
    watch = screening.FrameWatch()
    for _ in watch.through(frames):
        pass
    return watch.measures()


def check(frames):
    screening.check_frames(measures(frames), RATE)


def test_frames_pass_unchanged():
    frames = list(moving_pictures(5))
    assert all(a is b for a, b in zip(screening.FrameWatch().through(frames), frames, strict=True))


def test_good_pictures_are_accepted():
    check(moving_pictures())


def test_grey_frames_are_named():
    frames = list(moving_pictures())
    frames[3] = np.full_like(frames[3], 128)
    with pytest.raises(RejectedUtterance, match="1 frames show a single colour"):
        check(frames)


def test_frozen_pictures_are_named():
    frames = list(moving_pictures())
    frames[5:20] = [frames[5]] * 15
    with pytest.raises(RejectedUtterance, match="frozen for 0.56 s"):
        check(frames)
    frames = list(moving_pictures())
    frames[5:9] = [frames[5]] * 4
    check(frames)


def test_a_jump_is_named_and_a_fast_movement_is_not():
    frames = list(moving_pictures(80))
    with pytest.raises(RejectedUtterance, match="jumps at 2.00 s"):
        check(frames)  # the drift starts again at frame 50
    change = np.concatenate([np.ones(20), np.linspace(1, 12, 10), np.linspace(12, 1, 10), np.ones(20)])
    screening.check_frames(screening.FrameMeasures(np.full(60, 40.0), change), RATE)


def test_isolated_against_the_plain_way():
    values = np.random.default_rng(1).uniform(1, 3, 30)
    values[12] = 30
    plain = []
    for i in range(30):
        around = [values[j] for j in range(max(1, i - 4), min(30, i + 5)) if j != i]
        plain.append(values[i] / max(np.median(around), 0.5 * np.median(values[1:])))
    np.testing.assert_allclose(screening.isolated(values), plain)
    assert screening.isolated(values).argmax() == 12
    assert len(screening.isolated(np.zeros(2))) == 2


def test_landmarks_that_jump_are_named():
    points = record(60, seed=12, noise=0.2).points
    screening.check_points(points)
    points[30:] += [9, 0]
    with pytest.raises(RejectedUtterance, match="frame 30"):
        screening.check_points(points)


def test_one_odd_utterance_stands_out_of_the_corpus():
    errors = {f"u{i:02d}": 0.4 + 0.01 * (i % 5) for i in range(20)}
    assert screening.screen_rigid_errors(errors, errors) == {}
    refused = screening.screen_rigid_errors(errors | {"odd": 0.9}, errors)
    assert list(refused) == ["odd"] and "0.90 px" in refused["odd"].reason
    assert screening.screen_rigid_errors({"a": 0.1, "b": 5.0}, ["a", "b"]) == {}
    # Test utterances do not say what is usual.
    test = {f"t{i}": 0.9 for i in range(40)}
    assert list(screening.screen_rigid_errors(errors | test, errors)) == sorted(test)


def test_what_the_pictures_lack_is_named_before_the_missing_face():
    settings = LandmarkSettings(tracker="tests.unit.face.trackers:Blind")
    grey = [np.full((144, 180, 3), 128, np.uint8)] * 10
    with pytest.raises(RejectedUtterance, match="show a single colour"):
        screening.track_screened(grey, RATE, settings)
    with pytest.raises(RejectedUtterance, match="no face in any frame"):
        screening.track_screened(moving_pictures(), RATE, settings)


def test_blank_frames_are_counted_in_seconds():
    contrast = np.full(100, 40.0)
    contrast[50:54] = 0
    blank = screening.FrameMeasures(contrast, np.ones(100))
    settings = screening.ScreeningSettings(max_blank_seconds=0.1)
    screening.check_frames(blank, 100.0, settings)
    with pytest.raises(RejectedUtterance, match="4 frames show a single colour"):
        screening.check_frames(blank, 25.0, settings)
