"""Landmarks of other programs: OpenFace's columns, matching of rows to frames, and what is wrong with files."""

import os
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.face.openface import HEADER, POINTS, moving, rows, write
from visualspeech.corpora.findings import attempt
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.face import landmark_csv
from visualspeech.face.landmark_csv import read_landmarks, rows_of_frames
from visualspeech.face.landmark_paths import csv_of
from visualspeech.face.landmarks import track
from visualspeech.face.tracker import LandmarkSettings

RATE = 25.0
TRUE = moving()
FRAMES = [np.zeros((160, 200, 3), np.uint8)] * len(TRUE)


@pytest.fixture
def settings(tmp_path):
    (tmp_path / "of").mkdir()
    return LandmarkSettings(source="csv", folder=str(tmp_path / "of"), smoothing=0)


def tracked(settings, media="/rec/s1/a.mp4", frames=FRAMES, rate=RATE, first=0):
    return track(frames, settings, rate=rate, path=media, first=first)


def file_of(settings, name="a.csv"):
    from pathlib import Path

    return Path(settings.folder, name)


@pytest.mark.parametrize("style", [{}, {"separator": ","}, {"end": "\r\n"}])
def test_the_points_of_openface_are_the_landmarks(settings, style):
    write(file_of(settings), rows(TRUE), **style)
    found = tracked(settings)
    np.testing.assert_allclose(found.points, TRUE, atol=1e-3)
    assert found.detected.all() and found.findings == () and (found.width, found.height) == (200, 160)


def test_a_segment_reads_the_rows_of_its_frames(settings):
    write(file_of(settings), rows(TRUE))
    np.testing.assert_allclose(tracked(settings, frames=FRAMES[:5], first=7).points, TRUE[7:12], atol=1e-3)


def test_columns_may_have_any_order_and_be_few(settings):
    order = np.random.default_rng(1).permutation(136)
    values = [[i + 1, *np.concatenate([one[:, 0], one[:, 1]])[order]] for i, one in enumerate(TRUE)]
    write(file_of(settings), values, header=["frame", *np.array(POINTS)[order]])
    np.testing.assert_allclose(tracked(settings).points, TRUE, atol=1e-3)


def test_times_match_rows_of_another_rate(settings):
    fast = np.repeat(TRUE, 2, axis=0)  # 50 Hz; every second row is that of a frame
    fast[1::2] += 30
    write(file_of(settings), rows(fast, rate=50.0))
    found = tracked(settings)
    np.testing.assert_allclose(found.points, TRUE, atol=1e-3)
    assert "numbers the frame at 0.78 s 40, the video at 25 Hz 20; the times were used" in found.findings[0]


def test_rows_and_frames_the_plain_way():
    frame, time = np.arange(1.0, 31), np.arange(30) / 30.0
    found, _ = rows_of_frames(frame, time, 25.0)
    plain = {i: int(np.abs(time - i / 25).argmin()) for i in range(25)}
    assert {number: row for number, row in found.items() if number < 25} == plain
    # Times that do not ascend, as where they were not written, leave the numbers.
    assert rows_of_frames(np.array([1.0, 3, 4]), np.zeros(3), 25.0)[0] == {0: 0, 2: 1, 3: 2}
    assert rows_of_frames(np.array([np.nan] * 3), np.array([0, 0.04, 0.08]), 25.0)[0] == {0: 0, 1: 1, 2: 2}
    for frame in ([np.nan, 1], [2, 1], [1, 1], [np.inf, 1]):
        with pytest.raises(RejectedUtterance, match="neither ascending times nor ascending frame numbers"):
            rows_of_frames(np.array(frame, float), np.zeros(2), 25.0)


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({4: 0}, "marked as not tracked"),
        ({3: 0.2}, "marked as not tracked"),
        ({7 + 3: "nan"}, "not numbers"),
        ({7 + 3: ""}, "not numbers"),
        ({7 + 3: "-inf"}, "not numbers"),
        ({7 + i: 900 for i in range(68)}, "outside the frame"),
        (None, "not in the file"),
    ],
)
def test_frames_without_a_face_are_interpolated_and_told(settings, change, cause):
    values = rows(TRUE)
    if change is None:
        del values[8]
    else:
        for column, value in change.items():
            values[8][column] = value
    write(file_of(settings), values)
    found = tracked(settings)
    assert np.flatnonzero(~found.detected).tolist() == [8]
    np.testing.assert_allclose(found.points, TRUE, atol=1e-2)
    assert found.findings == (
        f"landmarks of a.csv, frames without a face: 1 {cause}",
        "no face in 1 of 20 frames; their points are interpolated",
    )


def test_the_threshold_of_the_confidence_is_a_setting(settings):
    write(file_of(settings), rows(TRUE, confidence=0.4))
    with pytest.raises(RejectedUtterance, match="no face in any frame; .* 20 marked as not tracked"):
        tracked(settings)
    assert tracked(replace(settings, min_confidence=0.3)).detected.all()


def test_of_several_faces_the_largest_is_followed_by_its_id(settings):
    other = (TRUE - 100) * 0.4 + 50
    both = [row for pair in zip(rows(other, face=0), rows(TRUE, face=7), strict=True) for row in pair]
    write(file_of(settings), both)
    found = tracked(settings)
    np.testing.assert_allclose(found.points, TRUE, atol=1e-3)
    assert found.findings == ("2 faces in one frame; the largest was followed",)


def test_fewer_rows_than_frames_are_missing_frames_up_to_the_limit(settings):
    write(file_of(settings), rows(TRUE[:18]))
    assert "2 not in the file" in tracked(settings).findings[0]
    write(file_of(settings), rows(TRUE[:10]))
    with pytest.raises(RejectedUtterance) as told:
        tracked(settings)
    assert (
        told.value.reason == "no face in 10 of 20 frames; landmarks of a.csv, frames without a face: 10 not in the file"
    )
    assert told.value.remedy.startswith("Run the landmark program on this recording again")


def broken(**changes):
    values = rows(TRUE)
    for place, value in changes.items():
        row, column = map(int, place[1:].split("_"))
        values[row][column] = value
    return values


@pytest.mark.parametrize(
    ("values", "header", "said"),
    [
        (broken(r3_9="abc"), None, "line 5 of the landmark file a.csv: x_2 is 'abc', no number"),
        (broken(r3_9="1;2"), None, "line 5 of the landmark file a.csv: x_2 is '1;2', no number"),
        (
            [*rows(TRUE)[:3], [1, 2, 3]],
            None,
            "line 5 of the landmark file a.csv has 3 values, its first line 143 names",
        ),
        ([[*row, 1] for row in rows(TRUE)], None, "line 2 of the landmark file a.csv has 144 values"),
        ([], None, "the landmark file a.csv has no rows"),
        (rows(TRUE), [*HEADER, *POINTS[:-1], "z_0"], "lacks the column y_67$"),
        (rows(TRUE), [*HEADER, *(f"p_{i}" for i in range(136))], "lacks the column x_0 and 135 more"),
        (rows(TRUE), ["n", "face_id", "time", *HEADER[3:], *POINTS], "lacks the column frame or timestamp$"),
        (rows(TRUE), [*HEADER[:-1], "x_0", *POINTS], "has the column x_0 twice"),
        (broken(r3_1="nan"), None, None),
    ],
)
def test_what_is_wrong_with_a_file_is_told_in_a_sentence(settings, values, header, said):
    write(file_of(settings), values, header=header)
    if said is None:
        assert tracked(settings).detected.sum() == len(TRUE) - 1
        return
    with pytest.raises(RejectedUtterance) as told:
        tracked(settings)
    import re

    assert re.search(said, told.value.reason) and told.value.remedy, told.value.reason


def test_hostile_files_are_told_and_do_not_fill_the_memory(settings, monkeypatch):
    path = file_of(settings)
    for data, said in [
        (b"", "lacks the column"),
        (b"\xff\xfe\x00f", "is no text"),
        (b"x" * 200_000, "line 1 of the landmark file a.csv has more than 30,000 characters"),
        (b"\0" * 5000, "lacks the column"),
    ]:
        path.write_bytes(data)
        with pytest.raises(RejectedUtterance, match=said):
            tracked(settings)
    monkeypatch.setattr(landmark_csv, "MAX_ROWS", 10)
    write(path, rows(TRUE))
    with pytest.raises(RejectedUtterance, match="has more than 10 rows"):
        tracked(settings)
    path.unlink()
    os.mkfifo(path)
    with pytest.raises(RejectedUtterance, match="is not a regular file"):
        tracked(settings)
    path.unlink()
    path.symlink_to("nowhere")
    with pytest.raises(RejectedUtterance, match="cannot be read: No such file"):
        tracked(settings)
    path.unlink()
    with pytest.raises(RejectedUtterance, match=r"no landmark file .*of/a.csv"):
        tracked(settings)


def test_a_bad_file_rejects_its_utterance_only(settings):
    write(file_of(settings), [])
    one = Utterance("u", "s", "/rec/a.mp4", "")
    found = attempt(one, "landmarks", tracked, settings)
    assert found.rejected is not None and found.findings[0].finding == "the landmark file a.csv has no rows"


def test_recordings_of_one_name_have_files_in_folders(tmp_path):
    for name in ("a.csv", "s1/a.csv", "rec/s2/a.csv"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    assert csv_of(str(tmp_path), "/data/rec/s1/a.mp4") == tmp_path / "s1" / "a.csv"
    assert csv_of(str(tmp_path), "rec/s2/a.mp4") == tmp_path / "rec" / "s2" / "a.csv"
    assert csv_of(str(tmp_path), "../s3/a.mpg") == tmp_path / "a.csv"
    assert csv_of(str(tmp_path), "b.mpg") is None


def test_a_file_is_read_as_pandas_reads_it(tmp_path):
    import pandas

    path = write(tmp_path / "a.csv", rows(TRUE))
    table, found = pandas.read_csv(path, skipinitialspace=True), read_landmarks(path)
    np.testing.assert_array_equal(found["points"][..., 0], table[POINTS[:68]].to_numpy(np.float32))
    np.testing.assert_array_equal(found["points"][..., 1], table[POINTS[68:]].to_numpy(np.float32))
    for name in ("frame", "timestamp", "face_id", "confidence", "success"):
        np.testing.assert_array_equal(found[name], table[name])


def test_a_file_is_read_once_for_the_segments_of_a_recording_and_again_when_it_changes(settings, monkeypatch):
    read = []
    known = landmark_csv._table
    monkeypatch.setattr(landmark_csv, "_table", lambda *given: read.append(given[1]) or known(*given))
    write(file_of(settings), rows(TRUE))
    for first in (0, 5, 10):
        np.testing.assert_allclose(tracked(settings, frames=FRAMES[:5], first=first).points[0], TRUE[first], atol=1e-3)
    assert read == ["a.csv"]
    write(file_of(settings), rows(TRUE + 1.5))
    np.testing.assert_allclose(tracked(settings).points, TRUE + 1.5, atol=1e-3)
    assert read == ["a.csv"] * 2
