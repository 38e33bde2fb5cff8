from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.unit.face.heads import CENTRE, FOCAL, SIZE, record
from visualspeech.errors import DataError
from visualspeech.face import pose as poses
from visualspeech.face.head import HeadModel, PoseSettings, fit_head
from visualspeech.face.tracker import RIGID

estimate = partial(poses.estimate, rate=25.0)
SHARP = PoseSettings(rotation_smoothing=0, translation_smoothing=0)


@pytest.fixture(scope="module")
def speaker():
    recording = record(250, seed=10, noise=0.3)
    return recording, fit_head(recording.points, SIZE)


def true_head(recording) -> HeadModel:
    return HeadModel(
        points3d=recording.head,
        rigid=RIGID,
        weights=np.ones(len(RIGID)),
        focal=FOCAL,
        centre=CENTRE,
        offset=np.array([90.0, 80.0]),
        size=(180, 180),
        settings=SHARP,
    )


def test_to_image_undoes_to_frontal(speaker):
    recording, head = speaker
    pose = estimate(recording.points, head)
    frontal = poses.to_frontal(recording.points, pose, head)
    np.testing.assert_allclose(poses.to_image(frontal, pose, head), recording.points, atol=1e-9)


def test_true_pose_gives_the_true_movement_of_the_mouth():
    recording = record(50, seed=11)
    head = true_head(recording)
    pose = estimate(recording.points, head)
    np.testing.assert_allclose(pose.rotation, recording.rotation, atol=1e-6)
    frontal = poses.to_frontal(recording.points, pose, head)
    np.testing.assert_allclose(frontal, recording.moving[..., :2] + head.offset, atol=1e-3)


def test_movement_of_the_head_is_taken_out_and_that_of_the_mouth_kept(speaker):
    recording, head = speaker
    pose = estimate(recording.points, head)
    frontal = poses.to_frontal(recording.points, pose, head)
    assert poses.rigid_error(frontal, head) < 0.5
    assert poses.rigid_error(recording.points, replace(head, rigid=RIGID)) > 10
    opening = frontal[:, 57, 1] - frontal[:, 51, 1]
    truth = recording.moving[:, 57, 1] - recording.moving[:, 51, 1]
    assert np.corrcoef(opening, truth)[0, 1] > 0.98
    slope = np.polyfit(truth, opening, 1)[0]
    assert 0.9 < slope < 1.1


def test_smoothing_calms_the_pose(speaker):
    recording, head = speaker

    def unrest(settings):
        return np.abs(np.diff(estimate(recording.points, head, settings).rotation, 2, axis=0)).mean()

    assert unrest(head.settings) < 0.25 * unrest(SHARP)


def test_noise_of_the_pose_hardly_leaks_into_the_jaw(speaker):
    """The jaw, far from the rigid points, must shake little more than under the true pose, and less than after a
    similarity transform of each frame."""
    recording, head = speaker
    frontal = poses.to_frontal(recording.points, estimate(recording.points, head), head)
    true_pose = poses.Pose(recording.rotation, recording.translation)
    truth = poses.to_frontal(recording.points, true_pose, true_head(recording))
    similar = similarity(recording.points, head.mean_points, head.rigid)

    def unrest(points):
        return np.linalg.norm(np.diff(points[:, :5], 2, axis=0), axis=2).mean()

    assert unrest(frontal) < 1.15 * unrest(truth)
    assert unrest(frontal) < unrest(similar)


def similarity(points, goal, rigid):
    """Each frame moved, turned and scaled so that its rigid points fit the goal best, as complex numbers."""
    seen, wanted = points[..., 0] + 1j * points[..., 1], goal[:, 0] + 1j * goal[:, 1]
    middle, aim = seen[:, rigid].mean(1, keepdims=True), wanted[rigid].mean()
    there = seen[:, rigid] - middle
    factor = (there.conj() @ (wanted[rigid] - aim)) / (np.abs(there) ** 2).sum(1)
    moved = (seen - middle) * factor[:, None] + aim
    return np.stack([moved.real, moved.imag], axis=-1)


def test_points_made_of_landmarks_take_depths_made_of_theirs(speaker):
    recording, head = speaker
    pose = estimate(recording.points, head)
    mix = np.zeros((2, 68))
    mix[0, [48, 4]] = 0.5
    mix[1, [33, 51]] = 0.5
    derived = mix @ head.points3d
    frontal = poses.to_frontal(mix @ recording.points, pose, head, derived)
    np.testing.assert_allclose(poses.to_image(frontal, pose, head, derived[:, 2]), mix @ recording.points, atol=1e-9)
    # Perspective bends straight lines in depth a little, so this is close and not equal.
    np.testing.assert_allclose(frontal, mix @ poses.to_frontal(recording.points, pose, head), atol=0.5)
    with pytest.raises(DataError, match="depths"):
        poses.to_frontal(mix @ recording.points, pose, head)


def test_one_frame_of_a_pose_is_a_pose(speaker):
    recording, head = speaker
    pose = estimate(recording.points, head)
    one = pose[-1]
    assert len(one) == 1 and len(pose[2:5]) == 3
    whole = poses.to_frontal(recording.points, pose, head)
    np.testing.assert_allclose(poses.to_frontal(recording.points[-1:], one, head)[0], whole[-1], atol=1e-9)


def test_very_short_utterances_have_a_pose(speaker):
    recording, head = speaker
    for frames in (1, 2, 3):
        assert np.isfinite(estimate(recording.points[:frames], head).translation).all()
    with pytest.raises(DataError):
        estimate(recording.points[:, :20], head)


def test_frontal_image_shows_what_lies_at_the_landmarks(speaker):
    """A picture whose grey level is a smooth function of the place must show, at every frontal landmark, the grey level
    of the landmark in the picture."""
    recording, head = speaker
    pose = estimate(recording.points, head)
    down, across = np.indices((SIZE[1], SIZE[0]))
    frame = np.stack([across / 2, down / 2, (across + down) / 4], axis=-1).round().astype(np.uint8)
    picture = poses.frontal_image(frame, pose[7], head)
    assert picture.shape == (head.size[1], head.size[0], 3) and picture.dtype == np.uint8
    frontal = poses.to_frontal(recording.points[7:8], pose[7], head)[0].round().astype(int)
    seen = picture[frontal[:, 1], frontal[:, 0]].astype(float)
    expected = np.stack([recording.points[7, :, 0] / 2, recording.points[7, :, 1] / 2], axis=1)
    assert np.abs(seen[:, :2] - expected).max() < 2.5  # half pixels, rounded grey levels, smoothed depths
