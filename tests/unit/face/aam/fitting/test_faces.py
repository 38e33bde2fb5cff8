from functools import cache

import cv2
import numpy as np
import pytest

from tests.unit.face.aam.faces import POINTS, smooth_picture
from tests.unit.face.heads import CENTRE, FOCAL, SIZE, record
from visualspeech.errors import DataError
from visualspeech.face.aam import model as aams
from visualspeech.face.aam.fitting import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.faces import PoseView, fit_faces
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference, paint
from visualspeech.face.aam.rows import ArrayRows
from visualspeech.face.drift import FaceReference
from visualspeech.face.head import HeadModel, PoseSettings
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import Pose, to_frontal
from visualspeech.face.tracker import RIGID

FRAMES = 12


@cache
def speaker():
    """A recording with its head and poses; the AAM and reference of other recordings of the same head."""
    recording = record(200, seed=4)
    size = {"offset": np.array([90.0, 80.0]), "size": (180, 180), "settings": PoseSettings()}
    head = HeadModel(recording.head, RIGID, np.ones(len(RIGID)), FOCAL, CENTRE, **size)
    pose = Pose(recording.rotation, recording.translation)
    frontal = POINTS.select(to_frontal(recording.points, pose, head))
    frontal = frontal + np.random.default_rng(0).normal(0, 0.05, frontal.shape)
    reference = fit_reference([frontal], POINTS, ReferenceSettings(texture_pixels=2500))
    x, y = reference.pixels[:, 1], reference.pixels[:, 0]
    lips = np.isin(POINTS.triangles, POINTS.regions["lips"]).all(axis=1)[reference.triangle]
    mean = np.tile(120 + 45 * np.sin(0.13 * x + 0.05 * y) + 30 * np.cos(0.15 * y - 0.06 * x) - 40 * lips, 3)
    modes = np.tile(np.array([np.sin(0.11 * x), np.cos(0.12 * y)]), (1, 3))
    textures = mean + np.random.default_rng(1).normal(0, 5, (len(frontal), 2)) @ modes
    textures = textures + np.random.default_rng(5).normal(0, 1.5, textures.shape)
    settings = aams.AamSettings(shape={"components": 4}, texture={"components": 2}, appearance={"components": 4})
    shapes = to_vector(frontal)
    corpus = FaceReference(shapes.mean(axis=0).astype(np.float32), mean.astype(np.float32))
    aam = aams.fit(shapes, ArrayRows(textures), POINTS, settings, corpus)
    return recording, head, pose, aam, reference, textures


def scene(light: float = 0.0):
    """Frames (FRAMES) of the recording, landmarks 68 as tracked (a few pixels off), poses, and the true 51 points."""
    recording, _, pose, _, reference, textures = speaker()
    chosen = np.arange(0, 10 * FRAMES, 10)
    truth = POINTS.select(recording.points[chosen])
    backdrop = smooth_picture(SIZE[1], SIZE[0])
    noise = np.random.default_rng(3).normal(0, 2, (FRAMES, *backdrop.shape))
    frames = [paint(textures[t] + light, at, reference, backdrop) for t, at in zip(chosen, truth, strict=True)]
    frames = [np.clip(np.rint(frame + n), 0, 255).astype(np.uint8) for frame, n in zip(frames, noise, strict=True)]
    moved = np.random.default_rng(2).normal(0, 1.5, (FRAMES, 1, 2))
    return frames, recording.points[chosen] + moved, pose[chosen], truth


def run(frames, landmarks, pose, light=0.0, **settings):
    _, head, _, aam, reference, _ = speaker()
    model = FittingModel.of_aam(aam, reference, FittingSettings(**{"scales": (1,), **settings}))
    own = FaceReference(aam.drift.shape, aam.drift.texture + np.float32(light))
    return fit_faces(frames, landmarks, pose, head, model, reference, (own, aam.drift))


@pytest.mark.parametrize("start", ["landmarks", "last_frame"])
def test_faces_of_a_turning_head_are_found(start):
    frames, landmarks, pose, truth = scene()
    found = run(frames, landmarks, pose, start=start, batch_size=5)
    assert not found.diverged.any()
    assert np.linalg.norm(POINTS.select(landmarks) - truth, axis=2).mean() > 1.5
    assert np.linalg.norm(found.points - truth, axis=2).mean(axis=1).max() < 0.4
    _, head, _, aam, reference, textures = speaker()
    assert found.shape.shape == (FRAMES, 102) and found.texture.dtype == np.uint8
    frontal = to_vector(POINTS.select(to_frontal(speaker()[0].points[:120:10], pose, head)))
    np.testing.assert_allclose(found.shape, frontal, atol=1.5)
    assert np.abs(found.texture - textures[: 10 * FRAMES : 10]).mean() < 6


def test_light_of_the_recording_is_no_error():
    frames, landmarks, pose, truth = scene(light=20.0)
    found = run(frames, landmarks, pose, light=20.0)
    assert not found.diverged.any()
    assert np.linalg.norm(found.points - truth, axis=2).mean() < 0.3


def test_the_tracker_stands_in_where_fitting_diverges():
    frames, landmarks, pose, _ = scene()
    frames[4] = np.random.default_rng(0).integers(0, 256, frames[4].shape, dtype=np.uint8)
    found = run(frames, landmarks, pose)
    assert np.flatnonzero(found.diverged).tolist() == [4]
    np.testing.assert_allclose(found.points[4], POINTS.select(landmarks[4]), atol=1e-4)
    _, head, *_ = speaker()
    np.testing.assert_allclose(
        found.shape[4], to_vector(POINTS.select(to_frontal(landmarks, pose, head)))[4], atol=1e-3
    )


def test_the_view_inverts_itself():
    recording, head, pose, *_ = speaker()
    points, rows = POINTS.select(recording.points[:7]), np.arange(7)
    view = PoseView(pose[rows], head, POINTS, np.full((51, 2), 0.7))
    np.testing.assert_allclose(view.to_image(view.to_model(points, rows), rows), points, atol=1e-9)
    some = rows[2:5]
    np.testing.assert_allclose(view.to_image(view.to_model(points[some], some), some), points[some], atol=1e-9)


def test_frames_landmarks_and_poses_must_be_as_many():
    frames, landmarks, pose, _ = scene()
    for wrong in (
        (frames[:-1], landmarks, pose),
        ([*frames, frames[0]], landmarks, pose),
        (frames, landmarks, pose[:3]),
    ):
        with pytest.raises(DataError):
            run(*wrong)


def test_colour_is_fitted_as_luminance():
    from visualspeech.face.aam.fitting.model import grey

    colours = np.random.default_rng(0).integers(0, 256, (1, 50, 3), dtype=np.uint8)
    picture = cv2.cvtColor(colours, cv2.COLOR_RGB2GRAY)[0]
    np.testing.assert_allclose(grey(colours[0].T.reshape(-1)), picture, atol=0.6)
