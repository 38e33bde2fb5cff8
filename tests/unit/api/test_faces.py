"""Faces in a few calls: what is passed on between them, and mistakes."""

import numpy as np
import pytest

from tests.unit.animation.faces import draw
from tests.unit.face import heads
from visualspeech import (
    AamSettings,
    DataError,
    RejectedUtterance,
    SettingError,
    TrackedFace,
    align,
    fit_aam,
    fit_head,
    normalise_pose,
    sample_faces,
    track,
)
from visualspeech.face.aam.reference import ReferenceSettings
from visualspeech.face.point_sets import read_point_set, to_points
from visualspeech.face.pose import rigid_error

FRAMES = 30


@pytest.fixture(scope="module")
def tracked():
    points = heads.record(FRAMES, seed=4, mouth=5).points
    return TrackedFace(points.astype(np.float32), np.ones(FRAMES, bool), 25.0, heads.SIZE)


def frames(tracked):
    return [draw(points) for points in tracked.points]


def test_the_movement_of_the_head_is_removed(tracked):
    frontal = normalise_pose(tracked)
    assert frontal.points.shape == (FRAMES, 68, 2) and frontal.rotation.shape == frontal.translation.shape == (
        FRAMES,
        3,
    )
    before = tracked.points - tracked.points.mean(axis=(0, 1)) + frontal.points.mean(axis=(0, 1))
    assert rigid_error(frontal.points, frontal.head) < 0.2 * rigid_error(before, frontal.head)
    again = normalise_pose(tracked, fit_head([tracked, tracked]))
    assert again.points.shape == frontal.points.shape and frontal.rate == 25


def test_an_appearance_model_gives_the_faces_back(tracked):
    frontal = normalise_pose(tracked)
    faces = sample_faces(frames(tracked), tracked, frontal, settings=ReferenceSettings(texture_pixels=400))
    assert faces.shapes.shape == (FRAMES, 102) and faces.textures.shape == (FRAMES, 3 * faces.reference.size)
    assert np.allclose(to_points(faces.shapes), read_point_set("lower_face_51").select(frontal.points))
    exact = AamSettings(shape={"energy": 0.9999}, texture={"energy": 0.9999}, appearance={"energy": 0.9999})
    aam = fit_aam(faces.shapes, faces.textures, settings=exact)
    shapes, textures = aam.decode(aam.encode(faces.shapes, faces.textures).appearance)
    assert np.abs(shapes - faces.shapes).max() < 1 and np.abs(textures - faces.textures).mean() < 2
    same = fit_aam(to_points(faces.shapes), faces.textures, settings=exact)
    assert np.allclose(same.shape_mean, aam.shape_mean)
    shared = sample_faces(frames(tracked), tracked, frontal, reference=faces.reference)
    assert np.array_equal(shared.textures, faces.textures)


def test_mistakes_are_reported(tracked, tmp_path):
    with pytest.raises(DataError, match="frames need their frame rate"):
        track(frames(tracked))
    with pytest.raises(RejectedUtterance, match="no video frames"):
        track([], rate=25)
    with pytest.raises(RejectedUtterance, match="nowhere.mp4: the file does not exist. Correct its name"):
        track(tmp_path / "nowhere.mp4")
    with pytest.raises(RejectedUtterance, match="nowhere.wav: the file does not exist. Correct its name"):
        align(tmp_path / "nowhere.wav", "Hello.")
    with pytest.raises(RejectedUtterance, match="^there is no speech in the sound. Check the microphone"):
        align(np.zeros(16_000, np.int16), "Hello.")
    with pytest.raises(DataError, match="at least one tracked recording"):
        fit_head([])
    other = TrackedFace(tracked.points, tracked.detected, 25.0, (64, 64))
    with pytest.raises(DataError, match="different frame sizes"):
        fit_head([tracked, other])
    frontal = normalise_pose(tracked)
    with pytest.raises(DataError, match="29 frames in the recording but landmarks for 30"):
        sample_faces(frames(tracked)[1:], tracked, frontal)
    with pytest.raises(SettingError, match="no point set 'lips'"):
        sample_faces(frames(tracked), tracked, frontal, points="lips")


@pytest.mark.parametrize(
    ("shapes", "textures", "said"),
    [
        (np.zeros((5, 102)), np.zeros((5, 4)), r"textures are \(faces, 3 x pixels\), not \(5, 4\)"),
        (np.zeros((5, 100)), np.zeros((5, 6)), "expected shape vectors of the 51 points"),
        (np.zeros((5, 102)), np.zeros((6, 6)), "5 training shapes but 6 training textures"),
        (np.full((5, 102), np.nan), np.zeros((5, 6)), "no finite number"),
        (np.zeros((0, 102)), np.zeros((0, 6)), "textures are"),
        (np.zeros((5, 102)), np.zeros((5, 6)), None),
    ],
)
def test_arrays_that_are_no_faces_are_refused(shapes, textures, said):
    with pytest.raises(DataError, match=said):
        fit_aam(shapes, textures)
