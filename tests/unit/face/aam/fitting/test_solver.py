import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting import fit, follow

from .scene import model, parts, pictures


def distance(a, b):
    return np.linalg.norm(a - b, axis=-1).mean(axis=-1)


def perturbed(points, seed=1, spread=3.0):
    """Points moved as a whole, and with the shape of the mean face."""
    generator = np.random.default_rng(seed)
    shapes = model().shapes
    similarity, _ = shapes.parameters(points)
    start = shapes.points(similarity, np.zeros((len(points), len(shapes.modes))))
    return start + generator.normal(0, spread, (len(points), 1, 2))


@pytest.mark.parametrize("variant", ["alternating", "simultaneous", "project_out"])
@pytest.mark.parametrize("scales", [(1,), (2, 1)])
def test_faces_are_found_again(variant, scales):
    frames, points = pictures(6)
    start = perturbed(points)
    found = fit(frames, start, model(variant=variant, scales=scales, iterations=30))
    assert not found.diverged.any()
    assert distance(start, points).mean() > 2.5
    assert distance(found.points, points).max() < (0.3 if variant != "project_out" else 0.8)
    assert np.all(found.error < 4) and np.all(found.start_error > 2 * found.error)
    assert found.points.dtype == float and found.texture.shape == (6, 4)


def test_batches_do_not_change_the_result():
    frames, points = pictures(5)
    start = perturbed(points)
    together, apart = (fit(frames, start, model(batch_size=size)) for size in (5, 2))
    np.testing.assert_allclose(together.points, apart.points, atol=0.02)


def test_a_frame_without_the_face_is_flagged_and_keeps_its_start():
    frames, points = pictures(4)
    frames[2] = np.random.default_rng(0).integers(0, 256, frames[2].shape, dtype=np.uint8)
    start = perturbed(points)
    found = fit(frames, start, model())
    assert found.diverged.tolist() == [False, False, True, False]
    np.testing.assert_array_equal(found.points[2], start[2])
    assert found.error[2] > 20


def test_a_grey_frame_does_not_stop_the_batch():
    frames, points = pictures(2)
    frames[1] = np.full_like(frames[1], 128)
    found = fit(frames, perturbed(points), model(prior_weight=0))
    assert found.diverged.tolist() == [False, True] and np.isfinite(found.points).all()


def test_each_frame_may_start_from_the_last():
    frames, points = pictures(1, noise=0.0)
    moving = [np.roll(frames[0], (0, 2 * t), axis=(0, 1)) for t in range(6)]
    truth = points + np.arange(6)[:, None, None] * [2.0, 0.0]
    found = follow(moving, truth[0], model())
    assert distance(found.points, truth).max() < 0.3
    moving[3] = np.zeros_like(moving[3])
    found = follow(moving, truth + 0.5, model())
    assert found.diverged.tolist() == [False] * 3 + [True] + [False] * 2
    np.testing.assert_array_equal(found.points[3], truth[3] + 0.5)
    assert distance(found.points, truth)[[4, 5]].max() < 0.3


def test_lighter_pictures_are_fitted_with_their_offset():
    frames, points = pictures(3, noise=0.0)
    lighter = [np.clip(frame.astype(np.float32) + 20, 0, 275) for frame in frames]
    offset = np.full(parts()[0].size, 20, np.float32)
    start = perturbed(points)
    plain, moved = fit([np.float32(f) for f in frames], start, model()), fit(lighter, start, model(), offset=offset)
    np.testing.assert_allclose(moved.points, plain.points, atol=0.01)


def test_a_view_stands_between_model_and_picture():
    """Faces seen through a shear, which no similarity makes."""
    frames, points = pictures(3, noise=0.0)

    class Sheared:
        matrix = np.array([[1.0, 0.0], [0.15, 1.0]])

        def to_image(self, points, frames):
            return points @ self.matrix

        def to_model(self, points, frames):
            return points @ np.linalg.inv(self.matrix)

    import cv2

    view = Sheared()
    warp = np.column_stack([view.matrix.T, [0, 0]])
    seen = [cv2.warpAffine(frame, warp, (260, 200)) for frame in frames]
    start = view.to_image(perturbed(points), None)
    found = fit(seen, start, model(), view)
    assert distance(found.points, view.to_image(points, None)).max() < 0.4
    without = fit(seen, start, model())
    assert distance(without.points, view.to_image(points, None)).min() > 0.5


def test_frames_and_points_must_fit():
    frames, points = pictures(2)
    with pytest.raises(DataError, match="2 frames"):
        fit(frames, points[:1], model())
    with pytest.raises(DataError, match="finite"):
        fit(frames, points * np.nan, model())
