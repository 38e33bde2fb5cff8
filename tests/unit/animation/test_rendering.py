import dataclasses

import numpy as np
import pytest

from tests.unit.animation.faces import BACKGROUND, CAVITY, POINTS, SKIN, draw, points68, reference
from tests.unit.face import heads
from visualspeech.animation import rendering
from visualspeech.animation.rendering import RenderSettings, place, prepare, stitch, talking_head
from visualspeech.errors import DataError, SettingError
from visualspeech.face.aam.reference import sample_texture
from visualspeech.face.head import fit_head
from visualspeech.face.point_sets import to_vector
from visualspeech.face.pose import Pose, estimate, to_frontal

GREEN = (20, 160, 40)


@pytest.fixture(scope="module")
def stitching():
    return prepare(reference())


def colour_at(picture, place):
    x, y = np.rint(place).astype(int)
    return picture[y, x].astype(int)


def near(picture, colour, tolerance=40):
    return np.abs(picture.astype(int) - colour).max(axis=2) < tolerance


def test_a_face_stitched_onto_itself_stays(stitching):
    points = points68(opening=6)
    frame = draw(points)
    face = POINTS.select(points)
    result = stitch(frame, face, face, sample_texture(frame, face, stitching.reference), stitching)
    assert result is not frame and result.dtype == np.uint8
    difference = np.abs(result.astype(int) - frame)
    assert difference.mean() < 0.2
    assert np.percentile(difference, 99.5) < 30  # the blur of one texture pixel at the lips' edge


def redder(picture):
    return np.count_nonzero(picture[..., 0] > picture[..., 1] + 100.0)


def greener(picture):
    return np.count_nonzero(picture[..., 1] > picture[..., 0] + 20.0)


@pytest.mark.parametrize(("recorded", "wanted"), [(14, 0), (0, 14), (14, 14)])
def test_the_recorded_mouth_never_shows(stitching, recorded, wanted):
    points, other = points68(recorded, drop=recorded / 2), points68(wanted, drop=wanted / 2)
    frame = draw(points)
    target = POINTS.select(other)
    texture = sample_texture(draw(other, lip=GREEN), target, stitching.reference)
    result = stitch(frame, POINTS.select(points), target, texture, stitching)
    assert redder(frame) > 150
    assert redder(result) == 0
    assert greener(result) == pytest.approx(greener(draw(other, lip=GREEN)), rel=0.15)


@pytest.mark.parametrize(("recorded", "wanted"), [(14, 0), (0, 14)])
def test_the_mouth_opens_and_closes_with_the_target(stitching, recorded, wanted):
    points, other = points68(recorded), points68(wanted)
    target = POINTS.select(other)
    # The colour of the mouth's inside comes from an open mouth whatever the target is.
    wide_open = POINTS.select(points68(14))
    texture = sample_texture(draw(points68(14)), wide_open, stitching.reference)
    result = stitch(draw(points), POINTS.select(points), target, texture, stitching)
    seen = near(result, CAVITY, 50).sum()
    expected = near(draw(other), CAVITY, 50).sum()
    assert abs(seen - expected) <= max(12, 0.25 * expected)


@pytest.mark.parametrize("drop", [-8.0, 8.0])
def test_there_is_one_jaw_line_and_it_is_the_target_s(stitching, drop):
    points, other = points68(drop=8 - max(drop, 0)), points68(drop=max(drop, 0) if drop > 0 else 0)
    frame = draw(points)
    target = POINTS.select(other)
    texture = sample_texture(draw(other), target, stitching.reference)
    result = stitch(frame, POINTS.select(points), target, texture, stitching)
    column = int(round(target[8, 0]))
    below_mouth = result[int(target[35, 1]) + 6 :, column]
    skin = np.abs(below_mouth.astype(int) - SKIN).max(axis=1) < np.abs(below_mouth.astype(int) - BACKGROUND).max(axis=1)
    edges = np.flatnonzero(np.diff(skin.astype(int)))
    assert len(edges) == 1
    assert abs(edges[0] + int(target[35, 1]) + 6 - target[8, 1]) < 2


def test_eyes_and_background_are_the_recorded_ones(stitching):
    points, other = points68(), points68(10, drop=8)
    frame = draw(points)
    noise = np.random.default_rng(0).integers(0, 30, frame.shape).astype(np.uint8)
    frame = frame // 2 + noise
    target = POINTS.select(other)
    texture = sample_texture(draw(other), target, stitching.reference)
    result = stitch(frame, POINTS.select(points), target, texture, stitching)
    eyes = int(points[36:48, 1].max())
    difference = np.abs(result[: eyes + 1].astype(int) - frame[: eyes + 1])
    assert difference.mean() < 0.5
    np.testing.assert_array_equal(result[:, :70], frame[:, :70])
    np.testing.assert_array_equal(result[-30:], frame[-30:])


def test_colours_are_brought_to_those_of_the_recording(stitching):
    points = points68(6)
    frame, face = draw(points), POINTS.select(points)
    texture = sample_texture(frame, face, stitching.reference).astype(np.float32)
    plain = stitch(frame, face, face, texture, stitching).astype(int)
    x = np.tile(stitching.basis[:, 1], 3)
    tinted = stitch(frame, face, face, texture - 15 + 8 * x, stitching).astype(int)
    assert np.abs(tinted - plain).max() <= 3


def test_a_face_at_or_beyond_the_border_is_rendered_where_it_is_seen(stitching):
    points = points68(centre=(180.0, 270.0))
    frame, face = draw(points), POINTS.select(points)
    texture = np.full(3 * stitching.reference.size, 128, np.uint8)
    assert stitch(frame, face, face + (0, 3), texture, stitching).shape == frame.shape
    away = face + (900, 900)
    np.testing.assert_array_equal(stitch(frame, away, away, texture, stitching), frame)


def test_opacity_is_full_on_the_lips_and_none_outside(stitching):
    grid = stitching.reference.grid_shape
    for point in POINTS.region(grid, "lips"):
        assert colour_at(stitching.opacity[..., None], point) == 1
    for point in POINTS.region(grid, "jaw"):
        assert stitching.opacity[tuple(np.rint(point[::-1]).astype(int))] < 0.1
    assert stitching.opacity.min() >= 0 and stitching.opacity.max() <= 1


def test_a_stream_looks_only_as_far_ahead_as_it_must(stitching):
    face = POINTS.select(points68())
    frame = draw(points68())
    texture = sample_texture(frame, face, stitching.reference)
    taken = []

    def frames():
        for index in range(60):
            taken.append(index)
            yield frame

    settings = RenderSettings(colour_smoothing=0.08)
    placement = rendering.Placement(np.repeat(face[None], 60, 0), np.repeat(face[None], 60, 0))
    stream = talking_head(frames(), placement, (texture for _ in range(60)), stitching.reference, settings, rate=25.0)
    next(stream)
    assert len(taken) == 6
    assert len(list(stream)) == 59


def test_smoothing_of_colour_takes_the_flicker_of_the_seam(stitching):
    points = points68(4)
    face, frame = POINTS.select(points), draw(points)
    random = np.random.default_rng(5)
    texture = sample_texture(frame, face, stitching.reference).astype(np.float32)
    # Light of the recording that flickers, as noise of the camera does: the offset must not follow it.
    frames = [np.clip(frame.astype(float) + random.normal(0, 6, 3), 0, 255).astype(np.uint8) for _ in range(30)]
    placement = rendering.Placement(np.repeat(face[None], 30, 0), np.repeat(face[None], 30, 0))

    def flicker(deviation):
        settings = RenderSettings(colour_smoothing=deviation)
        result = talking_head(frames, placement, [texture] * 30, stitching.reference, settings, rate=25.0)
        x, y = np.rint(POINTS.region(face, "inner_lips").mean(0)).astype(int)
        values = np.stack([picture[y - 3 : y + 4, x - 8 : x + 9] for picture in result]).astype(float)
        return np.sqrt((np.diff(values, 2, axis=0) ** 2).mean())

    assert flicker(0.08) < 0.3 * flicker(0.0)


def test_lengths_that_do_not_fit_are_told(stitching):
    face = POINTS.select(points68())
    frame = draw(points68())
    texture = sample_texture(frame, face, stitching.reference)
    placement = rendering.Placement(face[None].repeat(5, 0), face[None].repeat(5, 0))
    for frames, textures in ((4, 5), (5, 4), (6, 6)):
        with pytest.raises(DataError, match="[456] "):
            list(talking_head([frame] * frames, placement, [texture] * textures, stitching.reference, rate=25.0))


def test_settings_out_of_range_are_told():
    for change in ({"seam_width": 0}, {"warp_reach": 0.1}, {"colour_smoothing": -1.0}):
        with pytest.raises(SettingError, match=next(iter(change))):
            dataclasses.replace(RenderSettings(), **change)


@pytest.fixture(scope="module")
def seen():
    """Head, poses and landmarks of a made-up speaker."""
    recording = heads.record(40, seed=4)
    head = fit_head(recording.points, heads.SIZE)
    return head, estimate(recording.points, head, rate=25.0), recording.points


def test_the_recorded_shape_goes_back_to_where_it_was_recorded(seen):
    head, pose, landmarks = seen
    frontal = to_frontal(landmarks, pose, head)
    settings = RenderSettings(point_smoothing=0)
    shape = to_vector(POINTS.select(frontal))
    placement = place(landmarks, shape, pose, head, POINTS, settings, rate=25.0)
    # The five derived points are means of points of different depth: perspective moves them a little.
    np.testing.assert_allclose(placement.recorded, POINTS.select(landmarks), atol=1e-6)
    np.testing.assert_allclose(placement.target[:, :46], placement.recorded[:, :46], atol=1e-6)
    np.testing.assert_allclose(placement.target, placement.recorded, atol=0.5)


def test_lips_follow_the_target_and_the_nose_does_not(seen):
    head, pose, landmarks = seen
    shape = POINTS.select(to_frontal(landmarks, pose, head)) + (0, 5.0)
    placement = place(landmarks, to_vector(shape), pose, head, POINTS, rate=25.0)
    moved = np.linalg.norm(placement.target - placement.recorded, axis=2)
    np.testing.assert_allclose(moved[:, POINTS.regions["nose"]], 0, atol=1e-9)
    assert np.all(np.abs(moved[:, POINTS.regions["lips"]] - 5) < 1.5)


def test_streams_of_different_length_are_told(seen):
    head, pose, landmarks = seen
    with pytest.raises(DataError, match="poses"):
        shapes, short = np.zeros((len(landmarks), 102)), Pose(pose.rotation[:2], pose.translation[:2])
        place(landmarks, shapes, short, head, POINTS, rate=25.0)
