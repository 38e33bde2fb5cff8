import cv2
import numpy as np
import pytest

from tests.unit.face.heads import CENTRE, FOCAL, record
from visualspeech.face import camera

MATRIX = np.array([[FOCAL, 0, CENTRE[0]], [0, FOCAL, CENTRE[1]], [0, 0, 1]])


def test_rotation_matrices_agree_with_opencv_and_their_inverse():
    vectors = np.random.default_rng(0).normal(0, 0.8, (20, 3))
    vectors[0] = 0
    vectors[1] = [1e-9, 0, 0]
    matrices = camera.rotation_matrices(vectors)
    for vector, matrix in zip(vectors, matrices, strict=True):
        np.testing.assert_allclose(matrix, cv2.Rodrigues(vector)[0], atol=1e-12)
    np.testing.assert_allclose(camera.rotation_vectors(matrices), vectors, atol=1e-9)


def test_projection_agrees_with_opencv():
    recording = record(5, seed=1)
    for frame in range(5):
        expected, _ = cv2.projectPoints(
            recording.head, recording.rotation[frame], recording.translation[frame], MATRIX, None
        )
        seen = camera.project(
            recording.head, recording.rotation[[frame]], recording.translation[[frame]], FOCAL, CENTRE
        )
        np.testing.assert_allclose(seen[0], expected[:, 0], atol=1e-9)


def test_jacobian_agrees_with_finite_differences():
    seen = np.array([[12.0, -30.0, 700.0], [0.0, 4.0, 650.0]])
    analytic = camera.point_jacobian(seen, FOCAL)
    for axis in range(3):
        step = np.zeros(3)
        step[axis] = 1e-4
        high, low = seen + step, seen - step
        numeric = FOCAL * (high[:, :2] / high[:, 2:] - low[:, :2] / low[:, 2:]) / 2e-4
        np.testing.assert_allclose(analytic[..., axis], numeric, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("turn", [0.1, 0.6])
def test_pose_of_exact_points_is_found_again(turn):
    recording = record(30, seed=2, turn=turn, mouth=0)
    rotation, translation = camera.solve_pose(recording.points, recording.head, FOCAL, CENTRE, iterations=40)
    np.testing.assert_allclose(rotation, recording.rotation, atol=1e-6)
    np.testing.assert_allclose(translation, recording.translation, atol=1e-3)


def test_pose_of_noisy_points_is_as_good_as_opencvs():
    recording = record(25, seed=3, noise=0.7, mouth=0)
    rotation, translation = camera.solve_pose(recording.points, recording.head, FOCAL, CENTRE, robust=0)
    for frame in range(25):
        _, vector, place = cv2.solvePnP(recording.head, recording.points[frame], MATRIX, None)
        np.testing.assert_allclose(rotation[frame], vector[:, 0], atol=2e-4)
        np.testing.assert_allclose(translation[frame], place[:, 0], rtol=2e-3, atol=0.1)


def test_a_few_wrong_points_hardly_move_the_pose():
    recording = record(10, seed=4, noise=0.2, mouth=0)
    points = recording.points.copy()
    points[:, 5] += 40
    robust, _ = camera.solve_pose(points, recording.head, FOCAL, CENTRE)
    plain, _ = camera.solve_pose(points, recording.head, FOCAL, CENTRE, robust=0)
    error = np.abs(robust - recording.rotation).max()
    assert error < 0.2 * np.abs(plain - recording.rotation).max()


def test_translation_alone_fits_where_rotation_and_depth_are_given():
    recording = record(10, seed=5, mouth=0)
    found = camera.solve_translation(
        recording.points,
        recording.head,
        recording.rotation,
        recording.translation[:, 2],
        FOCAL,
        CENTRE,
        np.ones(68),
    )
    np.testing.assert_allclose(found, recording.translation, atol=1e-6)
