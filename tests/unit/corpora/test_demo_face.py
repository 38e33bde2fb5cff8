"""The demo speaker's mouth, head and pictures."""

import cv2
import numpy as np
import pytest
from scipy.interpolate import RBFInterpolator

from visualspeech.corpora.demo import articulation, camera, mouth
from visualspeech.corpora.demo.motion import Motion, draw
from visualspeech.corpora.demo.portrait import neutral_points, seam
from visualspeech.corpora.demo.rendering import Renderer, image_points
from visualspeech.corpora.demo.warp import evaluate, thin_plate

UPPER, LOWER = [61, 62, 63], [67, 66, 65]
PHONES = [name for name in articulation._TARGETS if name != "sil"]


def _still(frames: int = 1, closed: float = 0.0) -> Motion:
    return Motion(np.zeros((frames, 3)), np.zeros((frames, 3)), np.full(frames, closed), np.ones((frames, 3)), 0.0)


def _said(phones: str, length: float = 0.09, rate: float = 500.0):
    """Times, parameters and intervals of phones of equal length between two silences."""
    names = ["sil", *phones.split(), "sil"]
    intervals = [(name, i * length, (i + 1) * length) for i, name in enumerate(names)]
    times = np.arange(0, length * len(names), 1 / rate)
    return times, articulation.movement(intervals, times), intervals


@pytest.mark.parametrize("vowel", ["aa", "iy", "uw"])
@pytest.mark.parametrize("closure", articulation.CLOSED)
def test_lips_really_close(vowel, closure):
    times, parameters, intervals = _said(f"k {vowel} {closure} {vowel} k")
    _, start, end = intervals[3]
    during = (times >= start) & (times < end)
    shut = parameters[during, 0] <= 0
    assert shut.sum() / 500 > 0.04, "long enough that a camera of 25 frames a second sees it"
    assert parameters[(times > start - 0.06) & (times < start - 0.04), 0].min() > 1
    face = mouth.points(parameters[during][np.argmin(parameters[during, 0])])
    assert np.allclose(face[UPPER], face[LOWER])


def test_f_and_v_tuck_and_thin_the_lower_lip():
    for phone in articulation.LABIODENTAL:
        times, parameters, intervals = _said(f"aa {phone} aa")
        middle = parameters[np.argmin(np.abs(times - np.mean(intervals[2][1:])))]
        assert middle[4] > 0.85 and 0 < middle[0] < 3
        face, rest = mouth.points(middle), neutral_points()
        assert face[57, 1] - face[66, 1] < 0.75 * (rest[57, 1] - rest[66, 1])


def test_a_long_phone_reaches_its_target_and_the_mean_stays_between_targets():
    intervals = [("sil", 0, 0.5), ("aa", 0.5, 2.5), ("sil", 2.5, 3.0)]
    parameters = articulation.movement(intervals, np.array([1.5]))
    assert np.allclose(parameters[0], articulation._TARGETS["aa"][0], atol=0.05)
    times, parameters, _ = _said(" ".join(PHONES))
    targets = np.array([target for target, _ in articulation._TARGETS.values()])
    assert (parameters >= targets.min(axis=0)).all() and (parameters <= targets.max(axis=0)).all()


def test_rounding_is_anticipated():
    """Coarticulation: the s of "soon" is rounder than the s of "seen"."""
    round_s, spread_s = (
        parameters[np.argmin(np.abs(times - np.mean(intervals[1][1:])))]
        for times, parameters, intervals in (_said("s uw n"), _said("s iy n"))
    )
    assert round_s[3] > spread_s[3] + 0.3
    assert mouth.half_width(round_s) < mouth.half_width(spread_s) - 2


def test_dominance_equals_the_plain_formula():
    times, parameters, intervals = _said("m ae n", rate=50.0)
    segments = articulation._segments(intervals)
    for t, row in zip(times[::3], parameters[::3], strict=True):
        weights = total = 0.0
        for name, start, end in segments:
            target, claims = articulation._TARGETS[name]
            fall = articulation._DECAY_OF_CLOSURE if name == "m" else 24.0
            dominance = claims[0] * np.exp(-fall * max(start - t, t - end, 0.0))
            weights, total = weights + dominance, total + dominance * target[0]
        assert row[0] == pytest.approx(total / weights)


def test_thin_plate_agrees_with_scipy():
    random = np.random.default_rng(0)
    centres, values, places = (
        random.uniform(0, 100, (30, 2)),
        random.normal(size=(30, 2)),
        random.uniform(0, 100, (50, 2)),
    )
    ours = evaluate(thin_plate(centres, values), centres, places)
    assert np.allclose(ours, RBFInterpolator(centres, values, kernel="thin_plate_spline")(places), atol=1e-6)
    assert np.allclose(evaluate(thin_plate(centres, values), centres, centres), values, atol=1e-6)


def test_mouth_warp_takes_the_moved_lips_back_to_the_resting_lips():
    rest = neutral_points()
    for name in ("aa", "uw", "iy", "f", "p"):
        parameters = np.array(articulation._TARGETS[name][0])
        moved = mouth.points(parameters)
        upper, lower = mouth.MouthWarp(parameters)(moved)
        assert np.abs(upper[[50, 51, 52, 61, 62, 63]] - rest[[50, 51, 52, 61, 62, 63]]).max() < 0.6
        assert np.abs(lower[[56, 57, 58, 65, 66, 67, 8]] - rest[[56, 57, 58, 65, 66, 67, 8]]).max() < 0.6
        assert np.abs(upper[36:48] - rest[36:48]).max() < 1e-9


def test_projection_and_its_inverse():
    random = np.random.default_rng(1)
    places = random.uniform([60, 60], [260, 300], (400, 2))
    assert np.allclose(camera.project(places, np.zeros(3), np.zeros(3)), places, atol=1e-9)
    for _ in range(5):
        rotation, translation = np.radians(random.uniform(-6, 6, 3)), random.uniform(-8, 8, 3)
        assert np.allclose(camera.rotation_matrix(rotation), cv2.Rodrigues(rotation)[0], atol=1e-12)
        seen = camera.project(places, rotation, translation)
        assert np.abs(camera.unproject(seen, rotation, translation, 30) - places).max() < 1e-6
        assert np.abs(camera.unproject(seen, rotation, translation) - places).max() < 0.05


def test_projection_agrees_with_opencv():
    rotation, translation = np.radians([3.0, -5.0, 2.0]), np.array([2.0, -1.0, 9.0])
    points = camera.surface(neutral_points()) - camera.PIVOT
    matrix = np.array([[camera.DISTANCE, 0, camera.CENTRE[0]], [0, camera.DISTANCE, camera.CENTRE[1]], [0, 0, 1]])
    origin = camera.PIVOT + translation + [0, 0, camera.DISTANCE]
    expected = cv2.projectPoints(points, rotation, origin, matrix, None)[0][:, 0]
    assert np.allclose(camera.project(neutral_points(), rotation, translation), expected, atol=1e-8)


def test_head_movement_is_small_and_smooth():
    motion = draw(np.arange(250) / 25, np.random.default_rng(3))
    assert np.degrees(np.abs(motion.rotation)).max() < 10
    assert np.degrees(np.abs(np.diff(motion.rotation, axis=0))).max() < 1.5
    assert 0.1 < motion.closed_eyes.max() <= 1 and (motion.closed_eyes == 0).mean() > 0.7


@pytest.fixture(scope="module")
def renderer():
    return Renderer()


def test_an_open_mouth_shows_teeth_and_cavity_and_a_closed_one_only_lips(renderer):
    def inside(phone):
        parameters = np.array(articulation._TARGETS[phone][0])
        return renderer.frame(parameters, _still(), 0)[232:244, 152:168].astype(float)

    assert inside("aa").min() < 40, "the cavity is dark"
    assert (inside("aa").min(axis=-1).max()) > 110, "teeth are light and grey"
    shut = inside("p")
    assert (shut[..., 0] - shut[..., 2]).min() > 10, "lips and skin are red everywhere"


def test_blinking_changes_the_eyes_alone(renderer):
    parameters = np.zeros(6)
    difference = np.abs(
        renderer.frame(parameters, _still(), 0).astype(int) - renderer.frame(parameters, _still(closed=1.0), 0)
    ).max(axis=2)
    rows, columns = np.nonzero(difference > 3)
    assert len(rows) > 100 and rows.min() > 130 and rows.max() < 165 and columns.min() > 95 and columns.max() < 225
    canonical, seen = image_points(parameters, _still(closed=1.0), 0)
    assert np.allclose(canonical, seen) and np.allclose(canonical[37], canonical[41] * [0, 1] + canonical[37] * [1, 0])


def test_the_seam_runs_through_the_resting_corners():
    rest = neutral_points()
    assert np.allclose(seam(rest[[48, 54], 0]), rest[[48, 54], 1])
    assert np.allclose(rest[:, 0], 319 - rest[:, 0][np.argsort(rest[:, 0])][::-1][np.argsort(np.argsort(rest[:, 0]))])
