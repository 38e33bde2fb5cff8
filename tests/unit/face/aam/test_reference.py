import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, map_coordinates, uniform_filter

from tests.unit.face.aam.faces import POINTS, moving_faces, smooth_picture
from visualspeech.errors import DataError, SettingError
from visualspeech.face.aam import reference as r


@pytest.fixture(scope="module")
def faces():
    return POINTS.select(moving_faces(40))


@pytest.fixture(scope="module")
def reference(faces):
    return r.fit_reference([faces[:15], faces[15:]], POINTS, r.ReferenceSettings(texture_pixels=3000))


def test_mean_shape_is_the_mean_of_all_frames(faces, reference):
    np.testing.assert_allclose(reference.mean_shape, faces.mean(axis=0), rtol=1e-12)


def test_grid_has_about_the_pixels_asked_for_and_every_one_has_its_place(reference):
    assert reference.size == pytest.approx(3000, rel=0.02)
    places = reference.weights @ reference.grid_shape
    np.testing.assert_allclose(places, reference.pixels[:, ::-1], atol=1e-9)
    assert reference.barycentric.min() > -1e-8
    height, width = reference.nearest.shape
    assert reference.pixels.min() >= 0 and np.all(reference.pixels.max(axis=0) < [height, width])


def test_closed_mouth_has_pixels_inside(faces):
    closed = faces.mean(axis=0)
    inner = POINTS.regions["inner_lips"]
    closed[inner, 1] = closed[inner, 1].mean()
    reference = r.fit_reference([closed[None]], POINTS, r.ReferenceSettings(mouth_opening=0.2))
    inside = np.isin(POINTS.triangles, inner).all(axis=1)
    assert np.isin(reference.triangle, np.nonzero(inside)[0]).sum() > 60
    np.testing.assert_array_equal(reference.mean_shape, closed)


def test_texture_of_a_frame_is_the_interpolated_picture_at_the_mapped_places(faces, reference):
    picture = smooth_picture(180, 200)
    texture = r.sample_texture(picture, faces[3], reference).reshape(3, -1)
    for number in range(0, reference.size, 97):  # the slow, plain way
        corners = faces[3][POINTS.triangles[reference.triangle[number]]]
        x, y = reference.barycentric[number] @ corners
        for channel in range(3):
            slow = map_coordinates(picture[..., channel].astype(float), [[y], [x]], order=1)[0]
            assert abs(slow - texture[channel, number]) <= 1.5


def test_a_face_larger_than_the_grid_is_smoothed_before_it_is_sampled(faces, reference):
    """Fine stripes on a face of six times the grid: on the grid they are grey, and not a coarser pattern."""
    points = 6 * faces[3]
    rows = np.arange(int(points[:, 1].max()) + 40) // 2 % 2 * 200
    stripes = np.broadcast_to(rows[:, None, None], (len(rows), int(points[:, 0].max()) + 40, 3)).astype(np.uint8)
    texture = r.sample_texture(stripes, points, reference).astype(float)
    assert np.abs(texture - 100).max() < 12
    # Without smoothing, the nearest pixels would be kept as they are.
    x, y = (reference.weights @ points).T
    plain = map_coordinates(stripes[..., 0].astype(float), [y, x], order=1)
    assert plain.std() > 50
    # What the grid can hold stays: the mean over the pixels of the frame that a pixel of the grid stands for.
    smooth = smooth_picture(len(rows), stripes.shape[1])
    wanted = [map_coordinates(uniform_filter(smooth[..., c].astype(float), 6), [y, x], order=1) for c in range(3)]
    found = r.sample_texture(smooth, points, reference).reshape(3, -1)
    assert np.abs(found - wanted).mean() < 1.0


def test_smoothing_sees_the_surroundings_of_the_face_and_not_the_edge_of_a_part(faces, reference):
    frame = np.random.default_rng(1).integers(0, 256, (700, 800, 3), np.uint8)
    points = 4 * (faces[3] - faces[3].min(axis=0)) + [40, 60]
    part, corner = r._prefiltered(frame, points, reference)
    areas = [np.abs(POINTS.areas(one)).sum() for one in (points, reference.grid_shape)]
    whole = gaussian_filter(frame.astype(float), [*2 * [(np.sqrt(areas[0] / areas[1]) - 1) / 2], 0], truncate=6)
    low, high = (np.array(f(points), int) for f in (lambda p: p.min(axis=0), lambda p: p.max(axis=0)))
    inside = (slice(low[1], high[1]), slice(low[0], high[0]))
    moved = tuple(slice(s.start - c, s.stop - c) for s, c in zip(inside, corner[::-1], strict=True))
    assert part.shape < frame.shape and np.abs(part[moved] - whole[inside]).max() < 2


def test_faces_that_differ_by_their_shape_alone_have_one_texture(faces, reference):
    texture = r.sample_texture(smooth_picture(180, 200), faces[0], reference)
    moved = r.paint(texture, faces[7], reference, np.zeros((180, 200, 3), np.uint8))
    again = r.sample_texture(moved, faces[7], reference).reshape(3, -1)
    inner = np.all(np.abs(reference.barycentric) > 0.05, axis=1)  # away from edges, where the black ground blends in
    assert np.abs(again.astype(float) - texture.reshape(3, -1))[:, inner].mean() < 1.0


def test_painting_back_restores_the_picture_without_holes(faces, reference):
    picture = smooth_picture(180, 200, seed=4)
    texture = r.sample_texture(picture, faces[5], reference)
    canvas = np.full_like(picture, 255)
    painted = r.paint(texture, faces[5], reference, canvas)
    colours, inside = r.render(texture, faces[5], reference, 180, 200)
    assert inside.sum() == pytest.approx(POINTS.areas(faces[5]).sum(), rel=0.1)
    assert np.abs(painted[inside].astype(float) - picture[inside]).mean() < 1.5
    np.testing.assert_array_equal(painted[~inside], 255)
    np.testing.assert_array_equal(canvas, 255)


def test_faces_beyond_the_picture_and_crossed_lips_are_painted_as_far_as_they_go(faces, reference):
    texture = np.full(3 * reference.size, 300.0)
    points = faces[0] + [120, -80]
    points[[43, 44, 45], 1] -= 15
    painted = r.paint(texture, points, reference, np.zeros((90, 200, 3), np.uint8))
    assert set(np.unique(painted)) == {0, 255}
    assert not r.paint(texture, points + 500, reference, np.zeros((90, 200, 3), np.uint8)).any()


def test_textures_of_an_utterance_need_as_many_frames_as_points(faces, reference):
    frames = [smooth_picture(180, 200)] * 3
    assert r.sample_textures(iter(frames), faces[:3], reference).shape == (3, 3 * reference.size)
    for points in (faces[:2], faces[:4]):
        with pytest.raises(DataError, match="3 frames in the recording"):
            r.sample_textures(iter(frames), points, reference)


def test_saved_reference_reads_back_the_same(tmp_path, faces, reference):
    reference.save(tmp_path / "reference.safetensors")
    again = r.Reference.load(tmp_path / "reference.safetensors")
    picture = smooth_picture(180, 200)
    np.testing.assert_array_equal(
        r.sample_texture(picture, faces[1], again), r.sample_texture(picture, faces[1], reference)
    )
    assert again.settings == reference.settings and again.points is POINTS
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "reference.safetensors").read_bytes()


def test_what_is_no_face_is_refused(faces):
    with pytest.raises(DataError, match="no shapes"):
        r.fit_reference([], POINTS)
    with pytest.raises(DataError, match="folded over"):
        r.fit_reference([faces * [-1, 1]], POINTS)
    with pytest.raises(DataError, match="expected shapes"):
        r.fit_reference([faces[:, 1:]], POINTS)
    with pytest.raises(SettingError, match="texture_pixels"):
        r.ReferenceSettings(texture_pixels=10)
    with pytest.raises(SettingError, match="mouth_opening"):
        r.ReferenceSettings(mouth_opening=0)
