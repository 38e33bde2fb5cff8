"""Motion capture on a regular grid: gaps, jitter, lengths; each limit is a sentence."""

import numpy as np
import pytest

from tests.motion_capture import moving, write_csv
from visualspeech.corpora.motion import (
    MotionSource,
    cut,
    filled,
    longest_gap,
    measured_rate,
    read_motion,
    regular_motion,
    screen_dimensions,
)
from visualspeech.corpora.motion_files import Recorded
from visualspeech.corpora.motion_settings import MotionSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

NAMES = ("brow", "cheek", "chin")
SETTINGS = MotionSettings()


def recorded(seconds=1.0, rate=100.0, seed=0):
    return Recorded(np.arange(round(seconds * rate)) / rate, moving(seconds, 3, rate, seed))


def rejected(one, seconds=1.0, settings=SETTINGS, rate=0.0):
    with pytest.raises(RejectedUtterance) as told:
        regular_motion(one, NAMES, seconds, settings, rate)
    assert told.value.remedy.endswith(".")
    return told.value.reason


def test_rows_on_a_grid_are_taken_as_they_are():
    one = recorded()
    found = regular_motion(one, NAMES, 1.0, SETTINGS)
    assert found.rate == 100 and found.notes == () and found.points.dtype == np.float32
    np.testing.assert_array_equal(found.points, one.points.astype(np.float32))
    # Times are rounded in files.
    rounded = Recorded(np.round(one.times + 6.29, 4) - 6.29, one.points)
    np.testing.assert_array_equal(regular_motion(rounded, NAMES, 1.0, SETTINGS).points, found.points)


@pytest.mark.parametrize(("rate", "expected"), [(120.0, 120.0), (59.94, 59.94), (29.97003, 29.97003), (60.01, 60.0)])
def test_the_rate_is_measured(rate, expected):
    times = np.round(np.arange(400) / rate, 5)
    assert measured_rate(times) == pytest.approx(expected, rel=1e-5)
    kept = np.delete(times, [50, 51, 52, 200])  # lost rows leave the rate alone
    assert measured_rate(kept) == pytest.approx(expected, rel=1e-5)


def test_uneven_times_are_resampled():
    # A line in time is its own linear interpolation, wherever it is sampled.
    random = np.random.default_rng(3)
    times = np.arange(200) / 100 + random.uniform(-0.004, 0.004, 200)
    times = np.sort(times - times[0])
    line = Recorded(times, (times[:, None, None] * np.array([[1.0], [2.0], [-3.0]])))
    found = regular_motion(line, NAMES, 2.0, SETTINGS)
    assert abs(found.rate - 100) < 0.5 and abs(len(found.points) - 200) <= 1
    grid = np.minimum(np.arange(len(found.points)) / found.rate, times[-1])
    np.testing.assert_allclose(found.points[:, :, 0], grid[:, None] * [1, 2, -3], atol=1e-5)
    (note,) = found.notes
    assert note.startswith("uneven times: rows are") and note.endswith("is resampled")
    lost = Recorded(np.delete(recorded(2).times, [60, 61]), np.delete(recorded(2).points, [60, 61], axis=0))
    found = regular_motion(lost, NAMES, 2.0, SETTINGS)
    assert found.points.shape == (200, 3, 3) and found.rate == 100 and len(found.notes) == 1
    np.testing.assert_allclose(found.points[:60], recorded(2).points[:60], atol=1e-4)


def test_a_wanted_rate_resamples_in_silence():
    times = np.arange(100) / 100
    line = Recorded(times, np.repeat(times[:, None, None], 3, axis=1))
    found = regular_motion(line, NAMES, 1.0, SETTINGS, rate=60.0)
    assert found.rate == 60 and found.points.shape == (60, 3, 1) and found.notes == ()
    np.testing.assert_allclose(found.points[:, 0, 0], np.arange(60) / 60, atol=1e-6)


def test_short_gaps_are_interpolated_linearly():
    one = recorded()
    line = np.linspace(0, 99, 100)[:, None, None] * np.ones((1, 3, 3))
    broken = line.copy()
    broken[20:40, 0] = np.nan
    broken[50, 1, 2] = np.nan  # one coordinate is enough
    broken[:5, 2] = np.nan
    broken[90:, 2] = np.nan
    found = regular_motion(Recorded(one.times, broken), NAMES, 1.0, SETTINGS)
    expected = line.copy()
    expected[:5, 2], expected[90:, 2] = 5, 89
    np.testing.assert_allclose(found.points, expected, rtol=1e-6)
    assert np.isnan(broken).sum() == 3 * 20 + 1 + 3 * 15  # what was given is left alone


def test_gaps_up_to_the_limit_and_no_further():
    one = recorded()
    for rows, settings, fits in ((25, SETTINGS, True), (26, SETTINGS, False), (26, MotionSettings(max_gap=0.3), True)):
        points = one.points.copy()
        points[30 : 30 + rows, 1] = np.nan
        if fits:
            assert np.isfinite(filled(Recorded(one.times, points), NAMES, 100, settings.max_gap)).all()
        else:
            reason = rejected(Recorded(one.times, points), settings=settings)
            assert reason == ("the marker cheek is occluded for 0.26 s from 0.30 s on, longer than "
                              "`motion.max_gap: 0.25`")  # fmt: skip


@pytest.mark.parametrize(
    ("seen", "gap"),
    [("111", (0, 0)), ("0110", (0, 1)), ("1001000", (4, 3)), ("000", (0, 3)), ("10", (1, 1)), ("", (0, 0))],
)
def test_the_longest_gap(seen, gap):
    assert longest_gap(np.array([one == "1" for one in seen], bool)) == gap


def test_what_cannot_be_used_is_said():
    one = recorded()
    never = one.points.copy()
    never[:, 1:, 0] = np.nan
    assert rejected(Recorded(one.times, never)) == "markers are never visible: cheek, chin"
    never[:, 1] = one.points[:, 1]
    assert rejected(Recorded(one.times, never)) == "a marker is never visible: chin"
    assert rejected(Recorded(one.times[:2], one.points[:2])) == "only 2 frames of motion capture"
    assert rejected(Recorded(one.times[:1], one.points[:1])) == "only 1 frame of motion capture"
    assert rejected(Recorded(one.times[:20], one.points[:20]), 0.2) == "only 0.20 s of motion capture"
    said = "sound and motion capture differ in length: {} s of sound, 1.00 s of motion capture"
    assert rejected(one, 1.51) == said.format("1.51") and rejected(one, 0.4) == said.format("0.40")
    assert regular_motion(one, NAMES, 1.49, SETTINGS).points.shape == (100, 3, 3)
    late = one.times + 0.3 * (one.times > 0.45)
    assert rejected(Recorded(late, one.points), 1.3).startswith("no rows between 0.45 s and 0.76 s, a pause longer")
    assert rejected(Recorded(one.times * 20, one.points), 20).startswith("motion capture at 5 frames per second")
    assert rejected(Recorded(one.times / 1000, one.points)).startswith("motion capture at 1e+05 frames per second")
    assert rejected(Recorded(one.times, one.points * 1e30)) == "the motion capture holds values beyond 1e+09"


def test_a_span_of_years_takes_no_memory():
    times = np.array([0, 0.01, 0.02, 0.03, 1e9])
    assert "differ in length" in rejected(Recorded(times, np.zeros((5, 3, 1))), 1.0)


def test_start_and_end_cut_the_rows():
    one = recorded()
    part = cut(one, 0.2, 0.5)
    np.testing.assert_array_equal(part.points, one.points[20:50])
    np.testing.assert_allclose(part.times, np.arange(30) / 100, atol=1e-12)
    assert len(cut(one, 0.2, 0).times) == 80 and cut(one, 0, 0) is one
    with pytest.raises(RejectedUtterance, match="no motion capture between 2.00 s and the end"):
        cut(one, 2, 0)


def test_reading_an_utterance(tmp_path):
    one = recorded()
    path = tmp_path / "a.csv"
    write_csv(path, one.times, {name: one.points[:, number, 0] for number, name in enumerate(NAMES)})
    utterance = Utterance("a", "s", "", "", motion=str(path), start=0.2, end=0.7)
    found = read_motion(utterance, MotionSource(["chin", "brow"]), 0.5, SETTINGS)
    np.testing.assert_allclose(found.points[:, :, 0], one.points[20:70, [2, 0], 0], rtol=1e-4)
    with pytest.raises(RejectedUtterance, match="sound and motion capture differ"):
        read_motion(utterance, MotionSource(["chin"]), 1.2, SETTINGS)


def test_utterances_of_other_dimensions_than_most_are_refused(tmp_path):
    path = tmp_path / "0.h5"
    with ArrayWriter(path) as out:
        for name, d in (("a", 3), ("b", 1), ("c", 3)):
            out.add(name, {"points": np.zeros((4, 2, d), np.float32)}, 100.0)
    with ArrayReader(path) as motion:
        refused = screen_dimensions(motion, motion.ids)
        assert list(refused) == ["b"] and "give 1 value per name, those of most utterances 3" in refused["b"].reason
        assert screen_dimensions(motion, []) == {}
