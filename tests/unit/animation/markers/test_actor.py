"""Controls from markers: directions, ranges, and what does not depend on a recording's coordinates and numbering."""

import numpy as np
import pytest

from tests.unit.animation.markers.faces import at, markers
from visualspeech.animation.markers.actor import fit_actor, loudness
from visualspeech.animation.markers.fap import faps
from visualspeech.animation.markers.layouts import frame_of, layout_of, layouts
from visualspeech.animation.markers.live_link import channels
from visualspeech.errors import DataError
from visualspeech.face.markers import marker_set_names, read_marker_set

CORNER_LEFT, LOWER, BROW_LEFT = (24, -30, 56), (0, -41, 62), (15, 40, 62)


def moving(seed=0, frames=400):
    """Names, recorded frames (N, 46, 3) and loudness: idle while quiet, then every marker moves by itself."""
    names, idle = markers(seed)
    points = np.repeat(idle[None], frames, axis=0)
    phase = np.linspace(0, 40, frames - 100)
    chin = [names.index(f"CH{i}") for i in (1, 2, 3)]
    points[100:, chin, 1] -= 8 * (1 - np.cos(phase))[:, None]
    points[100:, at(names, idle, "Mou", LOWER), 1] -= 6 * (1 - np.cos(phase))
    points[100:, at(names, idle, "Mou", CORNER_LEFT), 0] += 4 * np.sin(0.7 * phase)
    points[100:, at(names, idle, "LBRO", BROW_LEFT), 1] += 5 * np.sin(0.3 * phase)
    return names, points, np.concatenate([np.zeros(100), np.ones(frames - 100)])


def fitted(names, points, quiet):
    return fit_actor(layout_of(names, points.shape[2]), names, points, quiet)


def test_every_marker_set_has_a_layout_that_names_its_markers_and_known_controls():
    assert {one.name for one in layouts()} == set(marker_set_names())
    for name, dimensions in (("landmarks_68", 2), ("iemocap_46", 3), ("live_link", 1)):
        given = read_marker_set(name)
        assert layout_of(given.names, dimensions).name == name
        assert layout_of(given.names[1:], dimensions) is None or name == "live_link"
    for one in layouts():
        assert set(one.fap) <= {name for name, fap in faps().items() if fap.range > 0}
        shapes = one.live_link if one.live_link != "identity" else {}
        assert set(shapes) <= {name for name, most in channels().items() if most > 0}
        assert all(movement.get("like", name) in shapes for name, movement in shapes.items())
        assert {role for line in one.lines for role in line} <= {*one.markers, *one.roles}


def test_the_idle_face_is_neutral_and_the_range_of_motion_becomes_that_of_the_parameters():
    names, points, quiet = moving()
    actor = fitted(names, points, quiet)
    assert np.allclose(actor.idle, points[0])
    driven = actor.faps(points)
    assert all(np.abs(values[:100]).max() < 1e-9 for values in driven.values())
    for name in ("open_jaw", "raise_b_midlip", "stretch_l_cornerlip", "raise_l_i_eyebrow"):
        assert np.percentile(np.abs(driven[name]), 99) == pytest.approx(faps()[name].range, rel=1e-6)
    assert driven["open_jaw"].min() == 0 and driven["raise_b_midlip"].max() < 1e-9
    shapes = actor.blend_shapes(points)
    assert np.percentile(shapes["JawOpen"], 99) == pytest.approx(channels()["JawOpen"], rel=1e-6)
    assert all((values >= 0).all() and (values <= 1).all() for values in shapes.values())


def test_a_control_follows_its_marker_in_its_direction():
    """A plain route: the displacement of one marker along one coordinate, scaled."""
    names, points, quiet = moving()
    idle, driven = points[0], fitted(names, points, quiet).faps(points)
    corner = points[:, at(names, idle, "Mou", CORNER_LEFT), 0] - CORNER_LEFT[0]
    expected = corner / np.percentile(np.abs(corner), 99) * faps()["stretch_l_cornerlip"].range
    assert np.allclose(driven["stretch_l_cornerlip"], expected)
    brow = points[:, at(names, idle, "LBRO", BROW_LEFT), 1] - BROW_LEFT[1]
    assert np.allclose(driven["raise_l_i_eyebrow"], brow / np.percentile(np.abs(brow), 99) * 250)


def test_both_sides_share_a_scale_and_what_never_moves_is_left_out():
    names, points, quiet = moving()
    actor = fitted(names, points, quiet)
    driven = actor.faps(points)
    # Only the left corner moves: the right one keeps its scale and stays at rest.
    assert np.abs(driven["stretch_r_cornerlip"]).max() == pytest.approx(0, abs=1e-9)
    assert "lift_l_cheek" not in driven and "push_t_lip" not in driven
    assert "CheekSquintLeft" not in actor.blend_shapes(points)
    jitter = points + np.random.default_rng(1).normal(0, 0.1, points.shape)
    assert "lift_l_cheek" not in fitted(names, jitter, quiet).faps(jitter)


def test_lips_that_stay_closed_while_the_jaw_drops_close_the_mouth():
    names, points, quiet = moving()
    idle = points[0]
    shut = points.copy()
    lips = [row for row, name in enumerate(names) if name.startswith("Mou")]
    shut[:, lips] = idle[lips]
    actor = fitted(names, points, quiet)
    shapes = actor.blend_shapes(shut)
    assert np.allclose(shapes["MouthClose"], shapes["JawOpen"]) and shapes["JawOpen"].max() > 0.5
    # Lips that part as the jaw drops leave nothing to close.
    parted = shut.copy()
    down = points[:, names.index("CH2"), 1] - idle[names.index("CH2"), 1]
    below = [row for row in lips if idle[row, 1] < -35]
    parted[:, below, 1] += down[:, None]
    assert np.abs(actor.blend_shapes(parted)["MouthClose"]).max() < 1e-9


@pytest.mark.parametrize("seed", [1, 2])
def test_neither_the_axes_of_a_recording_nor_the_numbers_of_its_markers_matter(seed):
    names, points, quiet = moving()
    expected = fitted(names, points, quiet)
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    others, elsewhere, _ = moving(seed)
    elsewhere = 0.1 * elsewhere @ turn + [5.0, -3.0, 100.0]
    found = fitted(others, elsewhere, quiet)
    for name, values in expected.faps(points).items():
        assert np.allclose(found.faps(elsewhere)[name], values, atol=1e-6), name
    for name, values in expected.blend_shapes(points).items():
        assert np.allclose(found.blend_shapes(elsewhere)[name], values, atol=1e-6), name


def test_axes_are_unit_vectors_square_to_each_other():
    names, idle = markers()
    axes = frame_of(layout_of(names, 3), names, idle).axes
    matrix = np.stack([axes[name] for name in ("left", "up", "forward")])
    assert np.allclose(matrix @ matrix.T, np.eye(3)) and np.allclose(matrix, np.eye(3), atol=0.03)


def test_landmarks_have_no_depth_and_images_point_down():
    from visualspeech.corpora.demo.mouth import points as mouth_points

    names = [f"point_{i}" for i in range(68)]
    phases = 0.5 - 0.5 * np.cos(np.linspace(0, 12, 200))
    still = mouth_points(np.zeros(6))
    faces = np.array([mouth_points(np.array([12 * p, 9 * p, 0, 0, 0, 0])) for p in phases])
    points = np.concatenate([np.repeat(still[None], 50, axis=0), faces])
    actor = fitted(names, points, np.concatenate([np.zeros(50), np.ones(200)]))
    driven, shapes = actor.faps(points), actor.blend_shapes(points)
    assert "thrust_jaw" not in driven and "JawForward" not in shapes
    assert np.corrcoef(driven["open_jaw"][50:], phases)[0, 1] > 0.999 and driven["open_jaw"].max() > 300
    assert driven["raise_b_midlip"].min() < -400 and driven["lower_t_midlip"].min() < -100
    assert np.allclose(driven["raise_b_lip_lm"], driven["raise_b_lip_rm"], atol=1e-6)
    assert shapes["MouthClose"].max() < 0.25 * shapes["JawOpen"].max()


def test_channels_pass_through_and_drive_parameters():
    names = list(read_marker_set("live_link").names)
    random = np.random.default_rng(3)
    points = 0.02 + 0 * random.uniform(size=(300, len(names), 1))
    points[100:, names.index("JawOpen"), 0] = random.uniform(0, 0.5, 200)
    points[100:, names.index("BrowDownLeft"), 0] = random.uniform(0, 0.5, 200)
    actor = fitted(names, points, np.concatenate([np.zeros(100), np.ones(200)]))
    shapes = actor.blend_shapes(points)
    assert all(np.array_equal(shapes[name], points[:, row, 0]) for row, name in enumerate(names))
    driven = actor.faps(points)
    assert np.percentile(driven["open_jaw"], 99) == pytest.approx(faps()["open_jaw"].range)
    assert driven["raise_l_i_eyebrow"].min() < -200 and driven["raise_l_i_eyebrow"].max() < 20
    assert "puff_l_cheek" not in driven


def test_markers_without_a_layout_and_points_of_another_face():
    assert layout_of(["one", "two"], 3) is None
    names, points, quiet = moving()
    assert layout_of(names, 2) is None
    with pytest.raises(DataError, match="do not fit"):
        fitted(names, points, quiet).faps(points[:, :40])
    with pytest.raises(DataError, match="no"):
        fitted(names, points[:0], quiet[:0])
    with pytest.raises(DataError, match="extent"):
        fitted(names, 0 * points, quiet)


def test_loudness_is_the_mean_square_about_a_frame():
    samples = np.random.default_rng(0).normal(size=16000)
    found = loudness(samples, 16000, 25, 25.0)
    for index in (0, 7, 24):
        centre = (index + 0.5) / 25
        first, last = max(0, round((centre - 0.1) * 16000)), min(16000, round((centre + 0.1) * 16000))
        assert found[index] == pytest.approx(np.mean(samples[first:last] ** 2), rel=1e-9)
    assert loudness(samples[:1600], 16000, 25, 25.0)[20] == 0
