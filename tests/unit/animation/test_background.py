import numpy as np
import pytest

from tests.unit.animation.faces import draw
from tests.unit.animation.speakers import LENGTHS
from tests.unit.face import heads
from visualspeech.animation.background import (
    Background,
    choose_recordings,
    frame_distances,
    write_background,
)
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.face.blinks import double_blinks
from visualspeech.face.drift import FaceReference
from visualspeech.face.pose import Pose

ZERO = FaceReference(np.zeros(102, np.float32), np.zeros(30, np.float32))


def recording(length=12, seed=0, mouth=5.0):
    return heads.record(length, seed=seed, mouth=mouth)


def clip(made, name="a", frames=None, face=ZERO, rate=25.0):
    frames = (draw(points) for points in made.points) if frames is None else frames
    return name, f"{name}.mp4", frames, made.points, Pose(made.rotation, made.translation), face, rate


def test_pictures_and_measures_come_back(tmp_path):
    made = [recording(length, seed) for seed, length in enumerate(LENGTHS)]
    faces = [FaceReference(np.full(102, i, np.float32), np.full(30, i, np.float32)) for i in range(2)]
    write_background(
        tmp_path / "b.h5", (clip(one, name, face=face) for one, name, face in zip(made, "ab", faces, strict=True))
    )
    found = Background.load(tmp_path / "b.h5")
    assert len(found) == sum(LENGTHS) and found.rate == 25 and found.size == heads.SIZE
    assert found.clip.tolist() == [0] * LENGTHS[0] + [1] * LENGTHS[1]
    assert found.media == ("a.mp4", "b.mp4") and found.shapes[1, 0] == 1 and found.textures[1, 0] == 1
    points = np.concatenate([one.points for one in made])
    assert np.allclose(found.landmarks, points, atol=1e-3)
    assert np.allclose(found.pose.rotation, np.concatenate([one.rotation for one in made]))
    for frame in (0, 41, len(found) - 1):
        assert np.abs(found.frame(frame).astype(int) - draw(points[frame])).mean() < 1.0
    again = tmp_path / "c.h5"
    write_background(again, (clip(one, name, face=face) for one, name, face in zip(made, "ab", faces, strict=True)))
    assert again.read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_recordings_of_another_camera_are_refused(tmp_path):
    made = recording()
    small = (draw(points)[:100] for points in made.points)
    with pytest.raises(DataError, match="one camera"):
        write_background(tmp_path / "b.h5", [clip(made), clip(made, "b", small)])
    with pytest.raises(DataError, match="one camera"):
        write_background(tmp_path / "b.h5", [clip(made), clip(made, "b", rate=30.0)])
    with pytest.raises(DataError, match="has 3 frames, 12 of landmarks"):
        write_background(tmp_path / "b.h5", [clip(made, frames=(draw(points) for points in made.points[:3]))])
    with pytest.raises(DataError, match="no recording"):
        write_background(tmp_path / "b.h5", [])
    assert not list(tmp_path.iterdir())
    (tmp_path / "no.h5").write_bytes(b"nothing")
    with pytest.raises(StorageError, match="cannot read"):
        Background.load(tmp_path / "no.h5")


def test_the_mouth_does_not_count_and_the_eyes_do(tmp_path):
    still = recording(16, 1, mouth=0.0)
    points = np.repeat(still.points[:1], 16, axis=0)
    # A little movement sets the unit; frame 5 speaks, frame 10 blinks.
    points = points + np.linspace(0, 0.8, 16)[:, None, None]
    points[5, 55:60, 1] += 8
    points[5, 65:68, 1] += 8
    points[5, 7:10, 1] += 8
    points[10, 36:48, 1] += 6
    made = heads.Recording(still.head, still.rotation[:16], still.translation[:16], still.moving, points)
    write_background(tmp_path / "b.h5", [clip(made)])
    distances = frame_distances(Background.load(tmp_path / "b.h5"))
    assert np.allclose(distances, distances.T, atol=1e-4) and np.abs(np.diag(distances)).max() < 1e-3
    steps = distances[np.arange(15), np.arange(1, 16)]
    assert steps[5] < 2 * np.median(steps) and steps[9] > 4 * np.median(steps)


def test_recordings_with_one_seat_and_one_light_are_chosen():
    base = recording(20, 2).points
    seats = {"a": 0, "b": 25, "c": 0.3, "d": -20, "e": 0.5}
    light = {"c": 0, "a": 1, "e": 30, "b": 0, "d": 0}
    faces = [
        (name, base + seat, FaceReference(ZERO.shape, np.full(30, 100 + light[name], np.float32)))
        for name, seat in seats.items()
    ]
    assert choose_recordings(iter(faces), 1.5, 25.0) in (["a", "c"], ["c", "a"])
    assert len(choose_recordings(iter(faces), 60, 25.0)) == 5
    assert len(choose_recordings(iter(faces), 0.01, 25.0)) == 1
    with pytest.raises(DataError, match="no recording"):
        choose_recordings(iter([]), 3, 25.0)


def test_recordings_with_a_double_blink_are_chosen_last():
    base = recording(20, 2).points
    blinking = base.copy()
    for frame in (5, 9):
        middle = blinking[frame, 36:48, 1].mean()
        blinking[frame, 36:48, 1] = middle + 0.1 * (blinking[frame, 36:48, 1] - middle)
    faces = [(name, blinking if name in "bd" else base + 3 * i, ZERO) for i, name in enumerate("abcd")]
    assert double_blinks(blinking, 25.0) == 1 and double_blinks(base, 25.0) == 0
    assert choose_recordings(iter(faces), 1.5, 25.0) in (["a", "c"], ["c", "a"])
    assert set(choose_recordings(iter(faces), 2.0, 25.0)[2:]) <= set("bd")
    assert len(choose_recordings(iter(faces), 60, 25.0)) == 4
    only = [faces[1], faces[3]]
    assert len(choose_recordings(iter(only), 0.5, 25.0)) == 1  # where all have one, one is taken all the same


def test_one_recording_of_a_background_can_be_taken(tmp_path):
    made = [recording(length, seed) for seed, length in enumerate((12, 9))]
    faces = [FaceReference(np.full(102, i, np.float32), np.full(30, i, np.float32)) for i in range(2)]
    write_background(
        tmp_path / "b.h5", (clip(one, name, face=face) for one, name, face in zip(made, "ab", faces, strict=True))
    )
    whole = Background.load(tmp_path / "b.h5")
    assert whole.names == ("a", "b")
    one = whole.only("b")
    assert len(one) == 9 and one.names == ("b",) and one.media == ("b.mp4",) and set(one.clip) == {0}
    np.testing.assert_array_equal(one.landmarks, whole.landmarks[12:])
    np.testing.assert_array_equal(one.frame(3), whole.frame(15))
    assert len(one.pose) == 9 and one.shapes.tolist() == whole.shapes[1:].tolist()
    with pytest.raises(SettingError, match="the background has no recording c; there are a, b"):
        whole.only("c")
