import re

import numpy as np
import pytest

from tests.unit.animation.faces import draw, points68
from tests.unit.face import heads
from tests.unit.face.aam.faces import POINTS, generic_face, moving_faces
from visualspeech.animation.rendering import place
from visualspeech.animation.video import Recording, Speaker, synthetic_frames
from visualspeech.errors import DataError, SettingError
from visualspeech.face import point_sets
from visualspeech.face.aam.fitting import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.faces import fit_faces
from visualspeech.face.aam.model import Aam, AamSettings
from visualspeech.face.aam.reference import Reference, ReferenceSettings, fit_reference_of, paint, sample_faces
from visualspeech.face.aam.training import fit_aam
from visualspeech.face.head import fit_head
from visualspeech.face.point_sets import parse_point_set, point_set_path, read_point_set, to_points, to_vector
from visualspeech.face.pose import estimate, to_frontal
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

# Jaw 9, nostrils 5, lips 20; landmarks of the cheeks and the bridge of the nose are held.
SMALL = """
points: [4, 5, 6, 7, 8, 9, 10, 11, 12, 31, 32, 33, 34, 35, 48, 49, 50, 51, 52, 53, 54, 55, 56, 57, 58, 59, 60, 61, 62,
  63, 64, 65, 66, 67]
regions:
  jaw: [0, 1, 2, 3, 4, 5, 6, 7, 8]
  nostrils: [9, 10, 11, 12, 13]
  lips: [14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33]
  outer_lips: [14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25]
  inner_lips: [26, 27, 28, 29, 30, 31, 32, 33]
mouth: {corners: [26, 30], middle: [28, 32]}
lowered: {1: 0.4, 2: 0.7, 3: 1, 4: 1, 5: 1, 6: 0.7, 7: 0.4, 21: 0.7, 22: 1, 23: 1, 24: 1, 25: 0.7, 31: 1, 32: 1, 33: 1}
outline: [0, 1, 2, 3, 4, 5, 6, 7, 8, 13, 12, 11, 10, 9]
triangles: [
  [1, 24, 2], [3, 24, 23], [4, 3, 23], [5, 4, 23], [5, 22, 6], [7, 20, 8], [7, 21, 20],
  [9, 14, 0], [10, 15, 9], [11, 18, 17], [12, 18, 11], [14, 1, 0],
  [15, 10, 16], [15, 14, 9], [15, 26, 14], [15, 27, 26], [16, 10, 11], [16, 11, 17], [18, 12, 19], [18, 29, 17],
  [19, 12, 13], [20, 13, 8], [20, 19, 13], [21, 22, 31], [21, 30, 20], [22, 5, 23], [22, 7, 6], [22, 21, 7],
  [22, 32, 31], [24, 3, 2], [24, 32, 23], [25, 1, 14], [25, 24, 1], [26, 25, 14], [26, 27, 33], [26, 33, 25],
  [27, 15, 16], [27, 16, 17], [27, 28, 33], [28, 27, 17], [28, 29, 31], [28, 32, 33], [29, 18, 19], [29, 28, 17],
  [29, 30, 31], [30, 19, 20], [30, 21, 31], [30, 29, 19], [32, 22, 23], [32, 24, 33], [32, 28, 31], [33, 24, 25]
]
rendering:
  follows: {0: 0.5, 8: 0.5, 9: 0, 10: 0, 11: 0, 12: 0, 13: 0}
  controls: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25]
  held: [0, 1, 2, 3, 13, 14, 15, 16, 27, 28, 29, 30]
  slow: [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13]
  painted: [0, 1, 2, 3, 4, 5, 6, 7, 8, 13, 12, 11, 10, 9]
  face_width: [34, 41]
"""


def test_landmarks_are_taken_as_they_are_and_the_other_points_are_means():
    face = generic_face()
    points = POINTS.select(face)
    assert points.shape == (51, 2) and POINTS.size == 51 and POINTS.freedom == 92
    np.testing.assert_array_equal(POINTS.region(points, "jaw"), face[:17])
    np.testing.assert_array_equal(POINTS.region(points, "nose"), face[27:36])
    np.testing.assert_array_equal(POINTS.region(points, "lips"), face[48:68])
    np.testing.assert_allclose(points[46], (face[1] + face[30]) / 2)
    np.testing.assert_allclose(points[50], (face[8] + face[57]) / 2)
    np.testing.assert_allclose(POINTS.completion @ points[POINTS.free], points, atol=1e-12)


def test_points_move_with_every_affine_map():
    faces = moving_faces(5)
    turn, shift = np.array([[0.9, 0.2], [-0.3, 1.1]]), np.array([4.0, -7.0])
    np.testing.assert_allclose(POINTS.select(faces @ turn + shift), POINTS.select(faces) @ turn + shift, atol=1e-9)


LIPS_JAW_NOSTRILS = read_point_set("lips_jaw_nostrils_34")


def test_the_34_points_of_lips_jaw_and_nostrils():
    face, points = generic_face(), LIPS_JAW_NOSTRILS
    assert points.size == 34 and points.freedom == 68
    for name, landmarks in {"jaw": range(4, 13), "nostrils": range(31, 36), "lips": range(48, 68)}.items():
        np.testing.assert_array_equal(points.region(points.select(face), name), face[list(landmarks)])


def test_what_the_34_points_lack_is_held_where_it_was_recorded():
    """There are no cheeks: the upper jaw line, the bridge of the nose and the eyes stay when lips and jaw move."""
    points = LIPS_JAW_NOSTRILS
    modelled = set(np.argmax(points.selection, axis=1))
    assert not modelled & set(points.held) and {0, 1, 2, 3, 13, 14, 15, 16, 27, 30} < set(points.held)
    assert points.face_width == (points.size + list(points.held).index(0), points.size + list(points.held).index(16))
    made = heads.record(12, seed=4, mouth=5)
    head = fit_head(made.points, heads.SIZE)
    pose = estimate(made.points, head, rate=25.0)
    wanted = to_vector(points.select(to_frontal(made.points, pose, head))) + 4
    placement = place(made.points, wanted, pose, head, points, rate=25.0)
    moved = np.linalg.norm(placement.target - placement.recorded, axis=2)
    np.testing.assert_array_equal(moved[:, points.size :], 0)
    np.testing.assert_allclose(moved[:, points.regions["nostrils"]], 0, atol=1e-9)
    jaw = moved[:, points.regions["jaw"]].mean(axis=0)
    assert jaw[0] < 0.6 * jaw[4] and moved[:, points.regions["lips"]].min() > 3


MESHES = [POINTS, LIPS_JAW_NOSTRILS, parse_point_set(SMALL, "small")]


@pytest.mark.parametrize("points", MESHES, ids=lambda points: points.name)
def test_mesh_tiles_the_outline_without_overlap_and_keeps_the_lips(points):
    face = points.select(points68(opening=6))
    areas = points.areas(face)
    x, y = face[points.outline].T
    outline = abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    assert np.all(areas > 0)
    assert areas.sum() == pytest.approx(outline, rel=1e-12)
    edges = {frozenset((int(t[i]), int(t[i - 1]))) for t in points.triangles for i in range(3)}
    for ring in (points.regions["outer_lips"], points.regions["inner_lips"], points.outline):
        assert all(frozenset((int(ring[i]), int(ring[i - 1]))) in edges for i in range(len(ring)))


def test_mesh_of_34_points_is_symmetric():
    mirror = [*range(8, -1, -1), *range(13, 8, -1), *range(20, 13, -1), *range(25, 20, -1), *range(30, 25, -1)]
    mirror += [33, 32, 31]
    face = LIPS_JAW_NOSTRILS.select(generic_face())
    np.testing.assert_allclose(face[mirror] * [-1, 1], face, atol=1e-12)
    mesh = {frozenset(map(int, t)) for t in LIPS_JAW_NOSTRILS.triangles}
    assert {frozenset(mirror[i] for i in t) for t in mesh} == mesh


def test_mesh_is_symmetric_off_the_midline():
    mirror = [*range(16, -1, -1), 17, 18, 19, 20, *range(25, 20, -1), *range(32, 25, -1), *range(37, 32, -1)]
    mirror += [*range(42, 37, -1), 45, 44, 43, 47, 46, 49, 48, 50]
    face = POINTS.select(generic_face())
    np.testing.assert_allclose(face[mirror] * [-1, 1], face, atol=1e-12)
    mesh = {frozenset(map(int, t)) for t in POINTS.triangles}
    assert {frozenset(mirror[i] for i in t) for t in mesh} == mesh


def test_shape_vector_holds_all_x_before_all_y_and_turns_back():
    faces = POINTS.select(moving_faces(4))
    vectors = to_vector(faces)
    np.testing.assert_array_equal(vectors[2, :51], faces[2, :, 0])
    np.testing.assert_array_equal(to_points(vectors), faces)


def test_other_numbers_of_points_and_unknown_names_are_refused():
    with pytest.raises(DataError, match="68 points"):
        POINTS.select(np.zeros((3, 67, 2)))
    with pytest.raises(DataError, match="no region 'ears'"):
        POINTS.region(np.zeros((3, 51, 2)), "ears")
    with pytest.raises(DataError, match="the 51 points of lower_face_51"):
        POINTS.region(np.zeros((3, 34, 2)), "lips")
    with pytest.raises(SettingError, match="no point set 'lower_face_7'; give one of .*lower_face_51"):
        read_point_set("lower_face_7")
    assert point_set_path("lower_face_51").name == "lower_face_51.yaml"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("points: [4,", "points: [68,", "point 0 is no landmark"),
        ("points: [4,", "points: [[4, 4],", "sum to 1"),
        ("points: [4,", "points: [x,", "value of another form"),
        ("[1, 24, 2]", "[24, 1, 2]", r"1 triangles have another turn.*\[24, 1, 2\]"),
        ("[1, 24, 2]", "[1, 24, 34]", "triangles has an index outside 0 to 33"),
        ("[1, 24, 2]", "[1, 24]", "value of another form"),
        ("  inner_lips", "  teeth", "names no region inner_lips"),
        ("corners: [26, 30]", "corners: [26]", "mouth_corners must be two points"),
        ("lowered: {1: 0.4", "lowered: {1: 4", "lowered must be a share"),
        ("lowered: {1: 0.4", "lowered: {77: 0.4", "no point 77"),
        ("outline: [0", "outline: [-1", "outline has an index"),
        ("  held: [0", "  held: [68", "held has an index outside 0 to 67"),
        ("face_width: [34", "face_width: [46", "face_width has an index outside 0 to 45"),
        ("  slow:", "  quick:", "slow"),
        ("outline:", "colour: red\noutline:", "unknown keys colour"),
        ("points: [4,", "points: [[4],", ""),
        ("mouth: {", "mouth: }", "not a YAML file"),
    ],
)
def test_a_damaged_point_set_is_refused_by_its_key(old, new, said):
    changed = SMALL.replace(old, new, 1)
    if not said:
        assert parse_point_set(changed, "small").size == 34
        return
    with pytest.raises(DataError, match=f"point set small: .*{said}"):
        parse_point_set(changed, "small")


def test_a_mean_of_landmarks_that_are_no_points_moves_by_itself():
    changed = re.sub(r"points: \[4,", "points: [[3, 4],", SMALL)
    points = parse_point_set(changed, "small")
    assert points.free.tolist() == list(range(34))
    np.testing.assert_array_equal(points.completion, np.eye(34))


def test_a_smaller_set_needs_no_code(tmp_path, monkeypatch):
    """From landmarks to a rendered frame with 34 points: grid, textures, AAM, codes, fitting and stitching."""
    (tmp_path / "small.yaml").write_text(SMALL)
    monkeypatch.setattr(point_sets, "__file__", str(tmp_path / "__init__.py"))
    points = read_point_set("small")
    made = heads.record(20, seed=4, mouth=5)
    frames = [draw(one) for one in made.points]
    head = fit_head(made.points, heads.SIZE)
    pose = estimate(made.points, head, rate=25.0)
    frontal = to_frontal(made.points, pose, head)
    with ArrayWriter(tmp_path / "pose.h5") as out:
        out.add("a", {"points": frontal}, 25.0)
    with ArrayReader(tmp_path / "pose.h5") as arrays:
        reference = fit_reference_of(arrays, ["a"], points, ReferenceSettings(texture_pixels=1500))
    assert reference.weights.shape == (reference.size, 34)
    faces = sample_faces(frames, made.points, frontal, reference, rate=25.0)
    with ArrayWriter(tmp_path / "textures.h5") as out:
        out.add("a", faces.arrays(), 25.0)
    six = {"components": 6}
    with ArrayReader(tmp_path / "textures.h5") as arrays:
        aam = fit_aam(arrays, ["a"], points, AamSettings(shape=six, texture=six, appearance={"components": 8}))
    reference.save(tmp_path / "reference.safetensors")
    aam.save(tmp_path / "aam.safetensors")
    reference, aam = Reference.load(tmp_path / "reference.safetensors"), Aam.load(tmp_path / "aam.safetensors")
    assert reference.points.name == aam.points.name == "small"
    coded = aam.encode_faces(faces)
    decoded = aam.decode_points(coded.parameters) + to_points(coded.offset.shape)
    np.testing.assert_allclose(decoded, points.select(frontal), atol=1.0)
    assert points.region(decoded, "lips").shape == (20, 20, 2)
    texture = aam.decode_texture(coded.parameters)[0] + coded.offset.texture
    painted = paint(texture, points.select(made.points)[0], reference, frames[0])
    assert np.abs(painted.astype(int) - frames[0]).mean() < 2
    model = FittingModel.of_aam(aam, reference, FittingSettings(iterations=3))
    found = fit_faces(frames, made.points, pose, head, model, reference, (faces.reference, aam.drift))
    assert found.points.shape == (20, 34, 2)
    placement = place(made.points, faces.shape + 4, pose, head, points, rate=25.0)
    assert placement.target.shape == (20, 34 + 12, 2)
    moved = np.linalg.norm(placement.target - placement.recorded, axis=2)
    np.testing.assert_array_equal(moved[:, 34:], 0)
    np.testing.assert_allclose(moved[:, points.regions["nostrils"]], 0, atol=1e-9)
    assert moved[:, points.regions["lips"]].min() > 3
    recording = Recording(made.points, pose, faces.reference)
    rendered = list(synthetic_frames(frames, coded.parameters, recording, Speaker(head, aam, reference), rate=25.0))
    assert np.mean([np.abs(a.astype(int) - b).mean() for a, b in zip(frames, rendered, strict=True)]) < 1.0
