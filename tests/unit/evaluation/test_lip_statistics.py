"""The measures across systems on mouths whose answers are known."""

import numpy as np
import pytest

from tests.unit.speech.alignments import spoken
from visualspeech.corpora.records import Utterance
from visualspeech.errors import DamagedFile, DataError
from visualspeech.evaluation.lip_metrics import ACROSS
from visualspeech.evaluation.lip_rows import cost_rows, lip_rows, lip_table, read_lip_tables
from visualspeech.evaluation.lip_statistics import at_frames, lip_statistics, recorded_closures
from visualspeech.evaluation.metrics import is_measured, statistics_of, total
from visualspeech.evaluation.tracked import (
    TrackedSpeaker,
    mean_face,
    read_mouth,
    read_speakers,
    tracked_speaker,
    tracked_speakers,
    write_mouth,
    write_speakers,
)
from visualspeech.face.markers import LANDMARK_NAMES
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.mouth import LANDMARK_MOUTH, Mouth, MouthNames
from visualspeech.face.point_sets import read_point_set, to_vector
from visualspeech.models.speed import write_speed
from visualspeech.storage.models import write_model
from visualspeech.storage.tables import write_table

RATE = 25.0
SPEAKER = TrackedSpeaker("anna", 80.0, -1.0, 9)
TRACKED = LANDMARK_MOUTH.among(LANDMARK_NAMES)
LIPS, CORNERS, LOWER = TRACKED.lips, TRACKED.corners, TRACKED.lower
BOTH = (TRACKED, TRACKED)
POINTS = read_point_set("lips_jaw_nostrils_34")


def wave(times, seed=0):
    """A movement slower than 4 Hz at any times."""
    generator = np.random.default_rng(seed)
    parts = [(generator.uniform(0.5, 4), generator.uniform(0, 2 * np.pi)) for _ in range(9)]
    return sum(np.sin(2 * np.pi * frequency * times + phase) for frequency, phase in parts)


def faces(times, seed=0, opening=1.0, width=1.0):
    """Faces (T, 68, 2) whose lower lips and corners move."""
    found = np.repeat(100 * MEAN_FACE[None, :, :2], len(times), axis=0)
    lower = [*LOWER, *range(55, 60)]
    found[:, lower, 1] += 3 + opening * wave(times, seed)[:, None]
    found[:, CORNERS[1], 0] += width * wave(times, seed + 100)
    return found


def times_of(frames, rate=RATE):
    return (np.arange(frames) + 0.5) / rate


def figures(*rows):
    table = lip_table({"row": "x", "id": f"u{number}", **row} for number, row in enumerate(rows))
    return {
        name: float(metric.value(total(statistics_of(table, metric))))
        for name, metric in ACROSS.items()
        if is_measured(table, metric)
    }


def measured(predicted, true, alignment=None, speaker=SPEAKER, mouths=BOTH):
    return lip_statistics(predicted, true, mouths, alignment or spoken(("iy", 9.0)), RATE, speaker)


def test_a_perfect_prediction_has_the_perfect_figures():
    alignment = spoken(("sil", 0.4), ("b", 0.4), ("iy", 2.0), ("m", 0.4), ("sil", 0.8))
    rows = []
    for seed in range(4):
        true = faces(times_of(100), seed)
        # Another seat of the speaker is no error.
        rows.append(measured(true + [[[7.0, -3.0]]], true, alignment))
    found = figures(*rows)
    assert found["lip_distance"] == pytest.approx(0, abs=1e-12) and found["lag"] == pytest.approx(0, abs=1e-6)
    for name in ("opening_corr", "opening_ccc", "width_corr", "width_ccc", "jerk"):
        assert found[name] == pytest.approx(1, abs=1e-9)
    recorded = recorded_closures(lip_table({"row": "x", "id": str(n), **row} for n, row in enumerate(rows)))
    assert {name: found[name] for name in ("closure", "silence")} == recorded
    assert 0 < recorded["closure"] <= 1 and 0 < recorded["silence"] < 1


def test_distance_is_in_percent_of_that_of_the_eyes():
    true = faces(times_of(60))
    predicted = true.copy()
    predicted[::2, LIPS] += [3.0, 4.0]  # half of the frames 5 px away: 2.5 px from the mean of the clip
    assert figures(measured(predicted, true))["lip_distance"] == pytest.approx(100 * 2.5 / 80)
    # The same face twice as large is the same.
    large = TrackedSpeaker("anna", 160.0, -2.0, 9)
    small, double = measured(predicted, true), measured(2 * predicted, 2 * true, speaker=large)
    assert small == pytest.approx(double)


def test_opening_and_width_agree_with_numpy():
    pairs = [(faces(times_of(n), n, 0.7, 0.4), faces(times_of(n), n + 1)) for n in (50, 75, 64)]
    found = figures(*(measured(x, y) for x, y in pairs))
    for name, of in (("opening", TRACKED.opening), ("width", TRACKED.width)):
        x, y = (np.concatenate([of(f) - of(f).mean() for f in side]) for side in zip(*pairs, strict=True))
        assert found[f"{name}_corr"] == pytest.approx(np.corrcoef(x, y)[0, 1], rel=1e-9)
        ccc = 2 * np.mean((x - x.mean()) * (y - y.mean())) / (x.var() + y.var() + (x.mean() - y.mean()) ** 2)
        assert found[f"{name}_ccc"] == pytest.approx(ccc, rel=1e-9)


def test_jerk_is_the_ratio_of_third_differences():
    generator = np.random.default_rng(1)
    predicted, true = generator.normal(size=(2, 40, 68, 2))
    x, y = (f[:, list(LIPS)] for f in (predicted, true))
    third = [f[3:] - 3 * f[2:-1] + 3 * f[1:-2] - f[:-3] for f in (x, y)]
    expected = np.sqrt(np.mean(third[0] ** 2) / np.mean(third[1] ** 2))
    assert figures(measured(predicted, true))["jerk"] == pytest.approx(expected)
    # Half the movement has half the jerk; a cubic in time has a constant one.
    assert figures(measured(true / 2, true))["jerk"] == pytest.approx(0.5)
    cubic = np.zeros((9, 68, 2))
    cubic[:, 50, 0] = np.arange(9.0) ** 3
    assert measured(cubic, cubic)["jerk.0"] == pytest.approx(6 * 36 / 0.8**2)


@pytest.mark.parametrize("shift", [-2, 2])
def test_a_lag_of_two_frames_is_found(shift):
    rows = []
    for seed in range(4):
        times = times_of(100)
        rows.append(measured(faces(times - shift / RATE, seed), faces(times, seed)))
    assert figures(*rows)["lag"] == pytest.approx(1000 * shift / RATE, abs=3)


def test_closures_are_counted_against_the_clip_mean():
    alignment = spoken(("sil", 0.4), ("iy", 0.4), ("b", 0.08), ("iy", 0.4), ("m", 0.08), ("iy", 0.24))
    true = np.zeros((40, 68, 2))
    true[:, LOWER, 1] = 6.0
    true[[20, 33], LOWER[0] : LOWER[-1] + 1, 1] = 1.0
    true[:4, LOWER[0] : LOWER[-1] + 1, 1] = 1.0
    predicted = true.copy()
    predicted[33, LOWER[0] : LOWER[-1] + 1, 1] = 5.5  # the "m" gapes
    predicted[:, :, 1] += 50
    predicted[:, LOWER[0] : LOWER[-1] + 1, 1] += 20  # a mean of the clip that no model is asked for
    row = measured(predicted, true, alignment)
    found = figures(row)
    assert (found["closure"], found["silence"]) == (0.5, 0.4)
    assert recorded_closures(lip_table([{"row": "x", "id": "a", **row}])) == {"closure": 1.0, "silence": 0.4}


def test_the_threshold_is_a_percentile_of_the_recorded_closures():
    alignment, generator = spoken(("iy", 0.4), ("b", 0.08), ("iy", 0.52)), np.random.default_rng(3)
    openings = generator.normal(9, 0.01, (300, 25)) + generator.normal(0, 2, (300, 1))
    openings[:, 11] -= generator.uniform(2, 8, 300)
    found = tracked_speaker("anna", 80, ((one, alignment, RATE) for one in openings))
    least = openings[:, 11] - openings.mean(axis=1)
    assert found == TrackedSpeaker("anna", 80.0, pytest.approx(np.percentile(least, 90)), 300)
    none = tracked_speaker("ben", 70, [(np.ones(25), spoken(("iy", 1.0)), RATE)])
    assert np.isnan(none.closed) and none.occurrences == 0
    row = measured(faces(times_of(50)), faces(times_of(50)), spoken(("b", 1.0), ("sil", 1.0)), none)
    found = figures(row)
    assert np.isnan(found["closure"]) and np.isnan(found["silence"])


def test_a_still_face_has_no_correlation_and_no_lag():
    true, still = faces(times_of(50)), faces(np.zeros(20))
    # Read between its frames, it is still up to rounding.
    found = figures(measured(at_frames(still + 0.1, 10.0, 50, RATE), true))
    assert all(np.isnan(found[name]) for name in ("opening_corr", "width_corr", "lag"))
    assert found["opening_ccc"] == found["width_ccc"] == 0 and found["jerk"] == pytest.approx(0, abs=1e-9)
    assert found["lip_distance"] > 0


def test_predictions_are_read_in_the_middle_of_the_frames():
    # A line in time is read exactly at any rate; before the first frame it is constant.
    for rate in (25.0, 50.0, 100.0, 120.0):
        points = times_of(int(4 * rate), rate)[:, None, None] * np.ones((1, 3, 2))
        np.testing.assert_allclose(at_frames(points, rate, 100, RATE)[:, 1, 1], times_of(100), atol=1e-12)
    slow = at_frames(times_of(20, 5.0)[:, None, None], 5.0, 100, RATE)[:, 0, 0]
    np.testing.assert_allclose(slow, np.clip(times_of(100), 0.1, 3.9))


def test_lips_that_do_not_fit_are_refused():
    true = faces(times_of(30))
    with pytest.raises(DataError, match=r"\(29, 68, 2\), the recorded ones \(30, 68, 2\)"):
        measured(true[1:], true)
    damaged = true.copy()
    damaged[4, 50] = np.nan
    with pytest.raises(DataError, match="predicted lips of frame"):
        measured(damaged, true)


def test_what_faces_cannot_give_is_left_out():
    generator, unknown = np.random.default_rng(2), TrackedSpeaker("cyd", float("nan"), float("nan"), 0)
    outer = Mouth((0, 1, 2, 3), (0, 2))
    points = generator.normal(size=(50, 6, 3))
    found = figures(measured(points, points, speaker=unknown, mouths=(outer, outer)))
    assert set(found) == {"lip_distance", "width_corr", "width_ccc", "jerk"}
    assert np.isnan(found["lip_distance"]) and found["width_corr"] == pytest.approx(1) and found["jerk"] == 1
    # No lips at all, or none in the coding.
    assert figures(measured(points, points, speaker=unknown, mouths=(Mouth(), Mouth()))) == {}
    assert figures(measured(points, points, speaker=unknown, mouths=(Mouth(), outer))) == {}


class Opened(dict):
    """Opened files: arrays and rates by utterance."""

    def array(self, name, key):
        return self[name][key]

    def rate(self, name):
        return self[name]["rate"]


class Coding:
    """A coding whose parameters are the coordinates of its points."""

    points = POINTS

    @staticmethod
    def decode_points(parameters, speaker):
        assert speaker in ("anna", "ben")
        return np.stack(np.split(parameters, 2, axis=1), axis=2)


def corpus(order):
    ids = [f"u{number}" for number in order]
    utterances = [Utterance(one, "anna" if int(one[1:]) % 2 else "ben", "", "") for one in ids]
    tracked, predictions = Opened(), Opened()
    for one in ids:
        seed, slow, fast = int(one[1:]), times_of(50), times_of(200, 100.0)
        tracked[one] = {"points": faces(slow, seed), "rate": RATE}
        predictions[one] = {"appearance": to_vector(POINTS.select(faces(fast, seed))), "rate": 100.0}
    return utterances, tracked, predictions


def lines(order):
    utterances, tracked, predictions = corpus(order)
    aligned = {one.id: spoken(("sil", 0.5), ("b", 0.2), ("iy", 1.3)) for one in utterances}
    speakers = tracked_speakers(utterances, tracked, TRACKED, aligned, {"anna": 80.0, "ben": 90.0})
    by_name = {one.speaker: one for one in speakers}
    return lip_rows("net", utterances, predictions, tracked, Coding, LANDMARK_MOUTH, LANDMARK_NAMES, aligned, by_name)


def test_a_faster_system_is_measured_at_the_frames_of_the_camera():
    table = lip_table(lines(range(4)))
    assert list(table["id"]) == ["u0", "u1", "u2", "u3"] and set(table["frames"]) == {50}
    found = {name: float(ACROSS[name].value(total(statistics_of(table, ACROSS[name])))) for name in ("lag", "jerk")}
    # A line through the samples of 100 Hz is all that differs.
    assert found["lag"] == pytest.approx(0, abs=0.2) and found["jerk"] == pytest.approx(1, abs=0.01)
    ccc = ACROSS["opening_ccc"]
    assert float(ccc.value(total(statistics_of(table, ccc)))) == pytest.approx(1, abs=1e-4)


def test_the_table_is_the_same_for_utterances_in_another_order():
    assert lip_table(lines([2, 0, 3, 1])).equals(lip_table(lines(range(4))))


def test_tables_are_read_by_row_with_their_costs(tmp_path):
    utterances, _, _ = corpus(range(4))
    rows = [*lines(range(4)), *({**one, "row": "floor"} for one in lines(range(4)))]
    lips, costs, model, speed = (tmp_path / name for name in ("lips.tsv", "costs.tsv", "m.safetensors", "speed.tsv"))
    write_table(lips, lip_table(rows))
    write_model(model, {"mean": np.zeros(7)}, {})
    write_speed(speed, [(one.id, 0.5) for one in utterances])
    write_table(costs, lip_table(cost_rows("net", utterances, model, speed)))
    net, floor = read_lip_tables(lips, costs, ["net", "floor"])
    cost = {name: float(ACROSS[name].value(total(statistics_of(net, ACROSS[name])))) for name in
            ("frames_per_second", "parameters")}  # fmt: skip
    assert cost == {"frames_per_second": 100.0, "parameters": 7.0}
    assert floor["seconds"].isna().all() and list(floor["id"]) == list(net["id"])
    with pytest.raises(DamagedFile, match="no line of other"):
        read_lip_tables(lips, costs, ["other"])
    write_speed(speed, [("u0", 0.5)])
    with pytest.raises(DamagedFile, match="utterance u1 is missing"):
        list(cost_rows("net", utterances, model, speed))


def test_speakers_are_kept_in_a_table(tmp_path):
    path = tmp_path / "tracked_lips.tsv"
    write_speakers(path, [SPEAKER, TrackedSpeaker("007", 70.0, float("nan"), 0)])
    found = read_speakers(path)
    assert list(found) == ["anna", "007"] and found["anna"] == SPEAKER and np.isnan(found["007"].closed)
    write_speakers(path, [SPEAKER, SPEAKER])
    with pytest.raises(DamagedFile, match="several rows"):
        read_speakers(path)


def test_the_mouth_is_kept_in_a_table(tmp_path):
    path = tmp_path / "mouth.tsv"
    for mouth in (LANDMARK_MOUTH, MouthNames(), MouthNames(("a", "b c"), ("b c", "a"))):
        write_mouth(path, mouth)
        read = read_mouth(path)
        assert (read.lips, read.corners, read.upper, read.lower) == (
            mouth.lips,
            mouth.corners,
            mouth.upper,
            mouth.lower,
        )
    path.write_text("part\tpoint\nbeard\ta\n")
    with pytest.raises(DamagedFile, match="none of lips, corners, upper, lower"):
        read_mouth(path)


def test_the_mean_face_is_that_of_all_frames():
    generator = np.random.default_rng(5)
    found = Opened({name: {"points": generator.normal(size=(n, 4, 3))} for name, n in (("a", 5), ("b", 9))})
    every = np.concatenate([one["points"] for one in found.values()])
    np.testing.assert_allclose(mean_face(["a", "b"], found), every.mean(axis=0))


def test_without_inner_lips_no_opening_counts_as_closed():
    utterances, tracked, _ = corpus(range(2))
    (found,) = tracked_speakers(utterances, tracked, None, {}, {"anna": float("nan")})
    assert np.isnan(found.closed) and found.occurrences == 0 and found.unit == 1
