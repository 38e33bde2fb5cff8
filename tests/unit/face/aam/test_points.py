import numpy as np
import pytest

from tests.unit.face.aam.faces import generic_face, moving_faces
from visualspeech.errors import DataError
from visualspeech.face.aam import points as p


def _areas(points):
    a, b, c = points[p.TRIANGLES].transpose(1, 0, 2)
    return ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2


def test_tracked_points_are_taken_as_they_are_and_the_others_are_means():
    face = generic_face()
    lower = p.lower_face(face)
    assert lower.shape == (51, 2)
    np.testing.assert_array_equal(lower[p.JAW], face[:17])
    np.testing.assert_array_equal(lower[p.NOSE], face[27:36])
    np.testing.assert_array_equal(lower[p.LIPS], face[48:68])
    np.testing.assert_allclose(lower[46], (face[1] + face[30]) / 2)
    np.testing.assert_allclose(lower[50], (face[8] + face[57]) / 2)


def test_points_move_with_every_affine_map():
    faces = moving_faces(5)
    turn, shift = np.array([[0.9, 0.2], [-0.3, 1.1]]), np.array([4.0, -7.0])
    np.testing.assert_allclose(p.lower_face(faces @ turn + shift), p.lower_face(faces) @ turn + shift, atol=1e-9)


def test_mesh_tiles_the_outline_without_overlap_and_keeps_the_lips():
    face = p.lower_face(generic_face(0.1))
    areas = _areas(face)
    x, y = face[p.OUTLINE].T
    outline = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert np.all(areas > 0)
    assert areas.sum() == pytest.approx(outline, rel=1e-12)
    edges = {frozenset((int(t[i]), int(t[i - 1]))) for t in p.TRIANGLES for i in range(3)}
    for ring in (np.arange(26, 38), np.arange(38, 46), p.OUTLINE):
        assert all(frozenset((int(ring[i]), int(ring[i - 1]))) in edges for i in range(len(ring)))


def test_mesh_is_symmetric_off_the_midline():
    mirror = [*range(16, -1, -1), 17, 18, 19, 20, *range(25, 20, -1), *range(32, 25, -1), *range(37, 32, -1)]
    mirror += [*range(42, 37, -1), 45, 44, 43, 47, 46, 49, 48, 50]
    face = p.lower_face(generic_face())
    np.testing.assert_allclose(face[mirror] * [-1, 1], face, atol=1e-12)
    mesh = {frozenset(map(int, t)) for t in p.TRIANGLES}
    assert {frozenset(mirror[i] for i in t) for t in mesh} == mesh


def test_shape_vector_holds_all_x_before_all_y_and_turns_back():
    faces = p.lower_face(moving_faces(4))
    vectors = p.to_vector(faces)
    np.testing.assert_array_equal(vectors[2, :51], faces[2, :, 0])
    np.testing.assert_array_equal(p.to_points(vectors), faces)


def test_other_numbers_of_points_are_refused():
    with pytest.raises(DataError, match="68 points"):
        p.lower_face(np.zeros((3, 67, 2)))
