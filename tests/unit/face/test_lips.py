"""The opening of the mouth of faces that are opened by a known amount."""

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.face.lips import has_inner_lips, lip_opening, opening_weights
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.point_sets import point_set_names, read_point_set


@pytest.mark.parametrize("name", point_set_names())
def test_lowering_the_jaw_opens_the_mouth(name):
    points = read_point_set(name)
    assert has_inner_lips(points)
    face = points.select(MEAN_FACE[:, :2])
    closed = lip_opening(face, points)
    lowered = face + 3 * np.stack([np.zeros(points.size), points.lowered], axis=1)
    share = points.lowered[np.array([i for i in points.regions["inner_lips"] if i not in points.mouth_corners])]
    assert lip_opening(lowered, points) - closed == pytest.approx(3 * share[share > 0].mean())
    assert closed == pytest.approx(0, abs=0.02)


def test_it_is_the_difference_of_two_means():
    points = read_point_set("lower_face_51")
    faces = np.random.default_rng(1).normal(size=(7, points.size, 2))
    upper, lower = faces[:, [39, 40, 41], 1].mean(axis=1), faces[:, [43, 44, 45], 1].mean(axis=1)
    np.testing.assert_allclose(lip_opening(faces, points), lower - upper, rtol=1e-12)
    weights = opening_weights(points)
    assert weights.sum() == pytest.approx(0) and np.count_nonzero(weights) == 6


def test_moving_the_head_is_no_opening():
    points = read_point_set("lower_face_51")
    face = np.random.default_rng(2).normal(size=(points.size, 2))
    assert lip_opening(face + [5, -3], points) == pytest.approx(lip_opening(face, points))


def test_faces_of_another_set_are_refused():
    with pytest.raises(DataError, match="51 points"):
        lip_opening(np.zeros((4, 50, 2)), read_point_set("lower_face_51"))
