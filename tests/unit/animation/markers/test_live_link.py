"""Live Link Face files, read back by columns."""

import csv

import numpy as np
import pytest

from visualspeech.animation.markers.live_link import BLEND_SHAPES, channels, timecode, write_live_link
from visualspeech.corpora.motion_files import read_csv
from visualspeech.errors import DataError
from visualspeech.face.markers import read_marker_set


def test_the_columns_are_those_of_the_app():
    names = list(channels())
    assert len(names) == len(set(names)) == 61 and len(names[BLEND_SHAPES:]) == 9
    assert names[0] == "EyeBlinkLeft" and names[51] == "TongueOut" and names[52] == "HeadYaw"
    assert set(names[:BLEND_SHAPES]) == set(read_marker_set("live_link").names)
    assert {name for name in names if "Left" in name and not name.startswith(("Mouth", "Jaw"))} == {
        name.replace("Right", "Left") for name in names if "Right" in name and not name.startswith(("Mouth", "Jaw"))
    }


def test_rows_hold_timecode_count_and_values(tmp_path):
    values = {"JawOpen": np.linspace(-0.5, 1.5, 61), "HeadYaw": np.linspace(-2, 2, 61)}
    write_live_link(tmp_path / "a.csv", values, 25)
    with open(tmp_path / "a.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 61 and {row["BlendShapeCount"] for row in rows} == {"61"}
    assert all(len(row) == 63 and None not in row for row in rows)
    jaw = [float(row["JawOpen"]) for row in rows]
    assert np.allclose(jaw, np.clip(values["JawOpen"], 0, 1), atol=1e-6)
    assert np.allclose([float(row["HeadYaw"]) for row in rows], values["HeadYaw"], atol=1e-6)
    assert {row["TongueOut"] for row in rows} == {"0.000000"}
    assert [rows[i]["Timecode"] for i in (0, 24, 25, 60)] == [
        "00:00:00:00.000", "00:00:00:24.000", "00:00:01:00.000", "00:00:02:10.000"]  # fmt: skip


def test_timecodes_count_hours_minutes_and_seconds():
    assert timecode(60 * (3600 + 2 * 60 + 3) + 7, 60) == "01:02:03:07.000"


@pytest.mark.parametrize(
    ("values", "rate", "said"),
    [
        ({"JawOpened": [0.1]}, 60, "JawOpened"),
        ({}, 60, "one is needed"),
        ({"JawOpen": [0.1, 0.2], "TongueOut": [0.1]}, 60, "lengths"),
        ({"JawOpen": [float("inf")]}, 60, "finite"),
        ({"JawOpen": [0.1]}, 59.94, "timecodes"),
    ],
)
def test_what_no_file_can_hold_is_refused(values, rate, said, tmp_path):
    with pytest.raises(DataError, match=said):
        write_live_link(tmp_path / "a.csv", {name: np.array(one) for name, one in values.items()}, rate)


@pytest.mark.parametrize("rate", [25, 60])
def test_the_reader_of_motion_capture_reads_it_back(tmp_path, rate):
    names = list(read_marker_set("live_link").names)
    values = np.random.default_rng(2).uniform(0, 1, (3 * rate + 7, len(names)))
    write_live_link(tmp_path / "a.csv", dict(zip(names, values.T, strict=True)), rate)
    found = read_csv(tmp_path / "a.csv", names, timecode_rate=rate)
    assert np.allclose(found.points[..., 0], values, atol=1e-6)
    assert np.allclose(np.diff(found.times), 1 / rate)
