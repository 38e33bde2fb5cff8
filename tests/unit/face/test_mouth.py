"""The mouth of faces of all point sets and of all landmarks."""

import numpy as np
import pytest

from visualspeech.face.lips import lip_opening
from visualspeech.face.markers import LANDMARK_NAMES, marker_set_names, read_marker_set
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.mouth import LANDMARK_MOUTH, Mouth, MouthNames, eye_distance, find_mouth, point_names
from visualspeech.face.point_sets import point_set_names, read_point_set

TRACKED = LANDMARK_MOUTH.among(LANDMARK_NAMES)
FACES = np.random.default_rng(1).normal(size=(9, 68, 2)) + MEAN_FACE[:, :2]


class Coded:
    """A visual coding of a point set, or of markers."""

    def __init__(self, points, markers=None):
        self.points, self.markers = points, markers


@pytest.mark.parametrize("name", point_set_names())
def test_lips_are_the_same_landmarks_in_every_point_set(name):
    points = read_point_set(name)
    mouth, chosen = LANDMARK_MOUTH.among(point_names(Coded(points))), points.select(FACES)
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


def test_markers_that_are_landmarks_have_the_same_mouth():
    markers = read_marker_set("landmarks_68")
    mouth = LANDMARK_MOUTH.among(point_names(Coded(None, markers)))
    chosen = FACES[:, markers.positions_in(LANDMARK_NAMES, "the recordings")]
    np.testing.assert_allclose(chosen[:, list(mouth.lips)], FACES[:, 48:68])
    np.testing.assert_allclose(mouth.opening(chosen), TRACKED.opening(FACES))


def test_a_face_without_a_point_lacks_the_part_that_it_belongs_to():
    names = [name for name in LANDMARK_NAMES if name != "point_62"]
    mouth = LANDMARK_MOUTH.among(names)
    assert mouth == Mouth(corners=(48, 54), lower=(64, 65, 66))


def head_of_markers(names, order):
    """A face of markers in space, turned, whose mouth markers go around the mouth in the given order of numbers."""
    ring = {place: angle for place, angle in zip(order, np.arange(8) * np.pi / 4, strict=True)}
    places = {"ch": (0, -5, 1), "fh": (0, 9, 0), "rc": (-5, 1, -3), "lc": (5, 1, -3)}
    found = np.random.default_rng(1).normal(size=(len(names), 3))
    for number, name in enumerate(names):
        key = name.lower()
        if key.startswith("mou"):
            angle = ring[int(key[3:])]
            found[number] = [2.5 * np.cos(angle), np.sin(angle) - 2, 2 - abs(np.cos(angle))]
        elif key[:2] in places:
            found[number] = places[key[:2]]
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    return found @ turn.T + [30, -20, 10]


@pytest.mark.parametrize("order", [(1, 2, 3, 4, 5, 6, 7, 8), (3, 8, 1, 6, 2, 7, 5, 4)])
def test_the_numbers_of_mouth_markers_are_read_off_the_face(order):
    names = read_marker_set("iemocap_46").names
    mouth = find_mouth(names, lambda: head_of_markers(names, order))
    # The ring begins at the person's left corner, and goes over the upper lip.
    ring = [f"Mou{number}" for number in order]
    assert mouth.corners == (ring[4], ring[0]) and not mouth.inner
    assert (set(mouth.upper), set(mouth.lower)) == (set(ring[1:4]), set(ring[5:8]))
    assert set(mouth.lips) == set(ring)


def test_faces_without_known_lips_have_no_mouth():
    def asked():
        raise AssertionError("no mean face is needed")

    for name in marker_set_names():
        names = read_marker_set(name).names
        if name == "landmarks_68":
            assert find_mouth(names, asked) == LANDMARK_MOUTH
        elif name != "iemocap_46":
            assert find_mouth(names, asked) == MouthNames() and MouthNames().among(names) == Mouth()


def test_distance_of_the_eyes():
    face = np.zeros((68, 2))
    face[36], face[45] = [10, 5], [70, 85]
    assert eye_distance(face) == 100
    with pytest.raises(ValueError, match="68 landmarks"):
        eye_distance(face[:51])
