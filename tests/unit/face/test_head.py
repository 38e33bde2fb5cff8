import numpy as np
import pytest

from tests.unit.face.heads import CENTRE, FOCAL, SIZE, record
from visualspeech.errors import DataError, StorageError
from visualspeech.face.camera import solve_pose
from visualspeech.face.head import HeadModel, fit_head
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.tracker import RIGID
from visualspeech.storage.models import write_model


def reprojection(points3d, points):
    from visualspeech.face.camera import project

    model = points3d[RIGID]
    seen = project(model, *solve_pose(points[:, RIGID], model, FOCAL, CENTRE), FOCAL, CENTRE)
    return np.sqrt(((seen - points[:, RIGID]) ** 2).sum(2).mean())


def test_fitted_head_explains_the_speaker_far_better_than_the_mean_face():
    recording = record(300, seed=6, noise=0.3)
    head = fit_head(recording.points, SIZE)
    mean = reprojection(MEAN_FACE * 100, recording.points)
    fitted = reprojection(head.points3d, recording.points)
    assert fitted < 0.5 < 1.5 < mean  # 0.3 px a coordinate is 0.42 px a point


def test_fitted_head_is_the_speakers_head_up_to_place_and_size():
    recording = record(400, seed=7, noise=0.05, turn=0.3)
    head = fit_head(recording.points, SIZE)

    def shape(points):
        rigid = points[RIGID] - points[RIGID].mean(0)
        return rigid / np.sqrt((rigid**2).sum(1).mean())

    one, other = shape(head.points3d), shape(recording.head)
    left, _, right = np.linalg.svd(one.T @ other)
    # Radius 1 stands for about 23 pixels here; the mean face is 0.09 off.
    assert np.sqrt(((one @ left @ right - other) ** 2).sum(1).mean()) < 0.04


def test_normalised_picture_holds_all_points_and_has_an_even_size():
    head = fit_head(record(60, seed=8, noise=0.3).points, SIZE)
    assert head.size[0] % 2 == head.size[1] % 2 == 0
    assert (head.mean_points > 5).all() and (head.mean_points < np.array(head.size) - 5).all()


def test_model_survives_its_file_and_the_bytes_repeat(tmp_path):
    recording = record(40, seed=9, noise=0.3)
    for name in ("one", "two"):
        fit_head(recording.points, SIZE).save(tmp_path / name)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    head, again = fit_head(recording.points, SIZE), HeadModel.load(tmp_path / "one")
    np.testing.assert_array_equal(again.points3d, head.points3d)
    assert (again.focal, again.size, again.settings) == (head.focal, head.size, head.settings)


def test_wrong_input_is_refused(tmp_path):
    with pytest.raises(DataError, match="68"):
        fit_head(np.zeros((5, 51, 2)), SIZE)
    with pytest.raises(DataError):
        fit_head(np.zeros((0, 68, 2)), SIZE)
    write_model(tmp_path / "other.safetensors", {"a": np.zeros(2)}, {"kind": "aam"})
    with pytest.raises(StorageError, match="no head model"):
        HeadModel.load(tmp_path / "other.safetensors")


def test_mean_face_is_symmetric_and_the_right_way_up():
    mirrored = MEAN_FACE * [-1, 1, 1]
    distance = np.linalg.norm(MEAN_FACE[:, None] - mirrored[None], axis=2).min(1)
    assert distance.max() < 0.01
    jaw, brows, nose, eyes, lips = (MEAN_FACE[a:b] for a, b in ((0, 17), (17, 27), (27, 36), (36, 48), (48, 68)))
    assert brows[:, 1].max() < eyes[:, 1].min() < nose[-1, 1] < lips[:, 1].mean() < jaw[8, 1]
    assert nose[:, 2].min() < lips[:, 2].min() < jaw[0, 2]
