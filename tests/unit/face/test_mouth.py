"""The mouth of faces of all point sets and of all landmarks."""

import numpy as np
import pytest

from visualspeech.face.lips import lip_opening
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.mouth import LIPS, TRACKED, Mouth, eye_distance, mouth_of
from visualspeech.face.point_sets import point_set_names, read_point_set

FACES = np.random.default_rng(1).normal(size=(9, 68, 2)) + MEAN_FACE[:, :2]


@pytest.mark.parametrize("name", point_set_names())
def test_lips_are_the_same_landmarks_in_every_point_set(name):
    points = read_point_set(name)
    mouth, chosen = mouth_of(points), points.select(FACES)
    np.testing.assert_allclose(chosen[:, list(mouth.lips)], FACES[:, 48:68])
    np.testing.assert_allclose(mouth.opening(chosen), TRACKED.opening(FACES))
    np.testing.assert_allclose(mouth.width(chosen), TRACKED.width(FACES))
    # The other route to the opening: the point set's own inner lips.
    np.testing.assert_allclose(mouth.opening(chosen), lip_opening(chosen, points))


def test_opening_and_width_of_a_face_drawn_by_hand():
    face = np.zeros((1, 68, 2))
    face[0, [61, 62, 63], 1], face[0, [65, 66, 67], 1] = [1, 2, 3], [5, 6, 10]
    face[0, 48], face[0, 54] = [-3, 1], [1, 4]
    assert TRACKED.opening(face) == pytest.approx([5]) and TRACKED.width(face) == pytest.approx([5])


def test_the_opening_in_space_is_a_distance():
    mouth = Mouth((0, 1, 2, 3), (0, 1), (2,), (3,))
    points = np.array([[[0, 0, 0], [2, 3, 6], [1, 1, 1], [4, 1, 5]]], float)
    assert mouth.opening(points) == pytest.approx([5]) and mouth.width(points) == pytest.approx([7])


def test_a_point_set_without_all_lips_has_no_mouth():
    class Points:
        selection = np.eye(68)[[point for point in range(68) if point != LIPS[3]]]

    assert mouth_of(Points()) is None


def test_distance_of_the_eyes():
    face = np.zeros((68, 2))
    face[36], face[45] = [10, 5], [70, 85]
    assert eye_distance(face) == 100
    with pytest.raises(ValueError, match="68 landmarks"):
        eye_distance(face[:51])
