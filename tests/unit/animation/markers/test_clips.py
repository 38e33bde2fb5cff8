"""Clips of points: what is drawn where, sound, labels, metadata and the files beside them."""

import av
import numpy as np
import pytest

from tests.fap_reader import read_fap
from tests.synthetic import hum
from tests.unit.animation.markers.faces import markers
from tests.unit.animation.markers.test_actor import fitted, moving
from visualspeech.animation.markers.clips import (
    Motion,
    marker_metadata,
    video_rate,
    whole_rate,
    write_clip,
    write_controls,
)
from visualspeech.animation.markers.drawing import PREDICTED, TRUE, drawn_bars, drawn_points, view_of
from visualspeech.animation.markers.layouts import frame_of, layout_of
from visualspeech.corpora.records import Utterance
from visualspeech.face.markers import read_marker_set

UTTERANCE = Utterance("turn_1", "F", "", "", emotion="anger")


def written(path, names, true, predicted, **options):
    metadata = marker_metadata("turn_1", "iemocap", "Joint-2", "an actor, by licence")
    write_clip(path, UTTERANCE, names, true, predicted, hum(1.0), 16000, metadata, **options)
    with av.open(str(path)) as file:
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    with av.open(str(path)) as file:
        sound = np.concatenate([frame.to_ndarray()[0] for frame in file.decode(audio=0)])
        return frames, sound, dict(file.metadata), float(file.streams.video[0].average_rate)


def near(image, colour):
    return np.abs(image.astype(int) - colour).max(axis=-1) < 40


def test_true_and_predicted_faces_stand_side_by_side_with_sound_and_say_what_they_are(tmp_path):
    names, points, _ = moving(frames=220)
    motion = Motion(points[100:], 120.0)
    frames, sound, metadata, rate = written(tmp_path / "a.mp4", names, motion, Motion(points[100:] + 1, 120.0))
    assert rate == 60 and len(frames) == 60
    assert len(sound) / 16000 == pytest.approx(1.0, abs=0.15) and np.abs(sound).max() > 0.1
    assert metadata["synthetic"] == "yes" and metadata["model"] == "Joint-2" and "SYNTHETIC" in metadata["comment"]
    assert "an actor, by licence" in metadata["comment"] and metadata["corpus"] == "iemocap"
    height, width = frames[0].shape[:2]
    assert height % 2 == 0 and width % 2 == 0
    left, right = frames[30][:, : width // 2], frames[30][:, width // 2 :]
    assert near(left, TRUE).sum() > 500 and near(left, PREDICTED).sum() == 0
    assert near(right, PREDICTED).sum() > 500 and near(right, TRUE).sum() == 0
    unlabelled, *_ = written(tmp_path / "b.mp4", names, motion, Motion(points[100:] + 1, 120.0), label=False)
    corner = np.s_[-120:-30, -140:-4]
    assert np.abs(frames[5][corner].astype(int) - unlabelled[5][corner]).max() > 60


def test_the_file_has_the_same_bytes_each_time(tmp_path):
    names, points, _ = moving(frames=120)
    for name in "ab":
        written(tmp_path / f"{name}.mp4", names, Motion(points[100:], 60.0), Motion(points[100:], 60.0))
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_streams_of_two_rates_are_shown_at_the_same_times(tmp_path):
    names, points, _ = moving(frames=150)
    slow, fast = Motion(points[100::4], 12.5), Motion(points[100:], 50.0)
    frames, _, _, rate = written(tmp_path / "a.mp4", names, slow, fast)
    assert (len(frames), rate) == (12, 12.5)
    frames, _, _, rate = written(tmp_path / "b.mp4", names, fast, slow)
    assert (len(frames), rate) == (52, 50.0)


@pytest.mark.parametrize(
    ("rate", "video", "controls"), [(25, 25, 25), (120, 60, 60), (100, 50, 50), (29.97, 29.97, 30), (200, 50, 50)]
)
def test_rates_of_files(rate, video, controls):
    assert video_rate(rate) == pytest.approx(video) and whole_rate(rate) == controls


def test_the_drawn_face_looks_at_the_reader_and_stays_in_its_panel():
    names, idle = markers()
    frame = frame_of(layout_of(names, 3), names, idle)
    view = view_of([idle[None]], frame, 300, 400)
    pixels = view.pixels(idle)
    assert (pixels > 0).all() and (pixels < [300, 400]).all()
    assert np.ptp(pixels, axis=0).max() > 240
    forehead, chin = pixels[names.index("FH2")], pixels[names.index("CH2")]
    assert forehead[1] < chin[1] - 150, "up is up"
    left = pixels[[row for row, name in enumerate(names) if name.startswith("LC")], 0].mean()
    right = pixels[[row for row, name in enumerate(names) if name.startswith("RC")], 0].mean()
    assert left > right + 50, "the person's left is on the reader's right"


def test_points_are_drawn_where_the_view_puts_them_and_wild_ones_do_no_harm():
    points = np.array([[[10.0, 20.0], [90.0, 20.0], [50.0, 120.0], [1e7, -1e7]]])
    view = view_of([np.repeat(points[:, :3], 2000, axis=0)], None, 200, 200)
    (image,) = drawn_points(points, view, [[0, 1]], (0, 0, 255), width=200, height=200)
    for place in view.pixels(points[0, :3]).round().astype(int):
        assert tuple(image[place[1], place[0]]) == (0, 0, 255)
    middle = view.pixels(np.array([50.0, 20.0])).round().astype(int)
    assert tuple(image[middle[1], middle[0]]) == (0, 0, 255), "on the line"
    off = view.pixels(np.array([50.0, 70.0])).round().astype(int)
    assert image[off[1], off[0]].min() > 200


def test_bars_have_the_length_of_their_channels(tmp_path):
    names = read_marker_set("live_link").names
    values = np.zeros((3, len(names)))
    values[1], values[2] = 0.5, 1.0
    filled = [near(image, PREDICTED).sum() for image in drawn_bars(values, names, (0.0, 1.0), PREDICTED)]
    assert filled[0] < 0.05 * filled[2] and filled[1] == pytest.approx(filled[2] / 2, rel=0.1)
    motion = Motion(np.repeat(values, 5, axis=0)[..., None], 15.0)
    frames, *_ = written(tmp_path / "a.mp4", names, motion, motion)
    assert len(frames) == 15 and near(frames[12][:, frames[12].shape[1] // 2 :], PREDICTED).sum() > 3000


def test_controls_lie_beside_the_clip(tmp_path):
    names, points, quiet = moving()
    actor = fitted(names, points, quiet)
    paths = write_controls(tmp_path, UTTERANCE, Motion(points[100:], 120.0), actor)
    assert [path.name for path in paths] == ["turn_1.fap", "turn_1.csv"]
    animation = read_fap((tmp_path / "turn_1.fap").read_text())
    assert animation.rate == 60 and len(animation.frames) == 150
    assert {3, 5, 6, 31} <= set(animation.frames[0])
    lines = (tmp_path / "turn_1.csv").read_text().splitlines()
    assert len(lines) == 151
    write_controls(tmp_path, UTTERANCE, Motion(points[100:], 25.0), actor)
    assert read_fap((tmp_path / "turn_1.fap").read_text()).rate == 25
    assert len((tmp_path / "turn_1.csv").read_text().splitlines()) == 1 + 300 * 60 // 25
    still = fitted(names, np.repeat(points[:1], 50, axis=0), np.zeros(50))
    assert write_controls(tmp_path, UTTERANCE, Motion(points, 120.0), still) == []
