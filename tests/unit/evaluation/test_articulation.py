"""Closures and the opening of the lips on signals whose answers are known."""

import dataclasses

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import BASELINES, measured, stack
from tests.unit.speech.alignments import spoken
from visualspeech.errors import DamagedFile, DataError
from visualspeech.evaluation.articulation import (
    ARTICULATION,
    LAGS,
    Target,
    articulation,
    articulation_of,
    cross_correlation,
    opening_correlation,
    opening_deviation,
    opening_lag,
    read_targets,
    recorded_figures,
    targets_of,
    write_targets,
)
from visualspeech.evaluation.articulation_table import RECORDED, articulation_tables
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.metrics import corpus_figure, statistics_of, total
from visualspeech.evaluation.scoring import score_table
from visualspeech.face.point_sets import read_point_set, to_vector
from visualspeech.speech.closures import closing_frames, greatest_openings, least_openings

TARGETS = (Target("bilabial", 2.0, 9), Target("labiodental", 3.0, 9), Target("open", 8.0, 9))
RATE = 25.0


def value(rows, name):
    metric = ARTICULATION[name]
    return float(metric.value(total(statistics_of(score_table(rows), metric))))


def row(name, predicted, true, alignment, targets=TARGETS):
    return {"id": name, "rate": RATE, "frames": len(true)} | articulation(predicted, true, alignment, RATE, targets)


def smooth(times, seed=0):
    """A signal of a mouth, slower than 5 Hz, at any times."""
    generator = np.random.default_rng(seed)
    waves = [(generator.uniform(0.5, 5), generator.uniform(0, 2 * np.pi)) for _ in range(12)]
    return 5 + sum(np.sin(2 * np.pi * frequency * times + phase) for frequency, phase in waves)


def test_windows_reach_one_frame_beyond_the_phone():
    # Frame i stands for 0.02 + 0.04 i seconds; "b" lasts from 0.2 to 0.28 s, so frames 4 (0.18) to 7 (0.30) count.
    alignment = spoken(("iy", 0.2), ("b", 0.08), ("iy", 0.32))
    for frame in range(15):
        opening = np.full(15, 9.0)
        opening[frame] = 1.0
        assert least_openings(opening, alignment, RATE, "bilabial").tolist() == [1.0 if 4 <= frame <= 7 else 9.0]
    assert not len(least_openings(np.ones(15), alignment, RATE, "labiodental"))
    # Frames may end before the alignment does.
    assert not len(least_openings(np.ones(3), alignment, RATE, "bilabial"))


def test_frames_of_closures_are_those_of_the_least_opening():
    alignment = spoken(("b", 0.2), ("f", 0.2), ("iy", 0.2), ("m", 0.2))
    opening = np.arange(20.0)[::-1].copy()
    opening[2] = -1
    # "f" from 0.2 to 0.4 s reaches frame 10 (0.42 s), "m" the end.
    assert closing_frames(opening, alignment, RATE).tolist() == [2, 10, 19]
    assert not len(closing_frames(opening, spoken(("iy", 0.8)), RATE))


def test_closures_are_counted():
    alignment = spoken(("iy", 0.2), ("b", 0.08), ("iy", 0.4), ("f", 0.08), ("iy", 0.4), ("m", 0.08), ("iy", 0.2))
    true = np.full(36, 9.0)
    true[[5, 17, 29]] = 1.0
    predicted = true + np.where(np.arange(36) == 29, 1.5, 0.0)  # the "m" gapes
    rows = [row("a", predicted, true, alignment), row("b", true, true, alignment)]
    assert value(rows, "closure_bilabial") == 0.75
    assert value(rows, "closure_labiodental") == 1.0
    assert recorded_figures(score_table(rows)) == {
        "closure_bilabial": 1.0,
        "closure_labiodental": 1.0,
        "open_vowels": pytest.approx(np.nan, nan_ok=True),
    }
    # The mean of an utterance counts: nothing is centred.
    assert value([row("a", true + 5, true, alignment)], "closure_bilabial") == 0


def test_thresholds_are_percentiles_of_the_recorded_occurrences():
    generator = np.random.default_rng(1)
    alignment = spoken(("iy", 0.2), ("b", 0.08), ("iy", 0.4), ("f", 0.08), ("iy", 0.24))
    least = generator.normal(2, 1, (500, 2))
    openings = np.full((500, 25), 9.0)
    openings[:, 5], openings[:, 17] = least.T
    found = targets_of((opening, alignment, RATE) for opening in openings)
    np.testing.assert_allclose([one.threshold for one in found[:2]], np.percentile(least, 90, axis=0))
    assert [one.occurrences for one in found] == [500, 500, 0]
    rows = [row(f"u{k}", opening, opening, alignment, found) for k, opening in enumerate(openings)]
    assert value(rows, "closure_bilabial") == pytest.approx(0.9, abs=1 / 500)


def test_open_vowels_are_counted_too():
    alignment = spoken(("b", 0.2), ("aa", 0.2), ("ah", 0.2), ("eh", 0.2))
    opening = np.full(20, 5.0)
    opening[7] = 8.5  # within "aa"; the reduced vowel counts for nothing
    opening[12] = 9.0
    found = row("a", opening, opening + 10, alignment)
    assert greatest_openings(opening, alignment, RATE).tolist() == [8.5, 5.0]
    assert value([found], "open_vowels") == 0.5 and recorded_figures(score_table([found]))["open_vowels"] == 1
    # Thresholds are exceeded by nine of ten.
    openings = [np.full(20, float(k)) for k in range(101)]
    assert targets_of((one, alignment, RATE) for one in openings)[2] == Target("open", 10.0, 202)


def test_without_occurrences_there_is_no_rate():
    closures = targets_of([(np.ones(10), spoken(("iy", 0.4)), RATE)])
    assert [one.occurrences for one in closures] == [0, 0, 0] and all(np.isnan(one.threshold) for one in closures)
    found = row("a", smooth(np.arange(50) / RATE), smooth(np.arange(50) / RATE), spoken(("b", 2.0)), closures)
    assert np.isnan(value([found], "closure_bilabial"))
    assert np.isnan(recorded_figures(score_table([found]))["closure_bilabial"])


def test_opening_over_all_frames_agrees_with_numpy():
    generator = np.random.default_rng(2)
    pairs = [(generator.normal(5, 2, n), generator.normal(4, 3, n)) for n in (40, 75, 51)]
    rows = [row(f"u{k}", x, y, spoken(("iy", 3.0))) for k, (x, y) in enumerate(pairs)]
    x, y = (np.concatenate(parts) for parts in zip(*pairs, strict=True))
    assert value(rows, "opening_corr") == pytest.approx(np.corrcoef(x, y)[0, 1], rel=1e-9)
    assert value(rows, "opening_sd") == pytest.approx(x.std() / y.std(), rel=1e-9)


@pytest.mark.parametrize("constant", [0.0, 0.1, 6.0])
def test_a_constant_opening_has_no_correlation_and_no_lag(constant):
    true = smooth(np.arange(50) / RATE)
    rows = [row("a", np.full(50, constant), true, spoken(("iy", 2.0)))]
    assert np.isnan(value(rows, "opening_corr")) and np.isnan(value(rows, "opening_lag"))
    assert value(rows, "opening_sd") == 0
    assert np.isnan(value([row("a", true, np.full(50, constant), spoken(("iy", 2.0)))], "opening_sd"))


@pytest.mark.parametrize("rate", [25.0, 50.0, 100.0])
@pytest.mark.parametrize("lag", [-0.12, -0.02, -0.013, 0.0, 0.007, 0.04, 0.055])
def test_a_known_lag_is_found(lag, rate):
    sums = 0.0
    for seed, seconds in enumerate((3.0, 4.0, 3.5, 5.0)):
        times = np.arange(int(seconds * rate)) / rate
        sums = sums + cross_correlation(smooth(times - lag, seed), smooth(times, seed), rate)
    assert float(opening_lag(sums)) == pytest.approx(1000 * lag, abs=3)


def test_lags_of_whole_frames_are_the_plain_sums():
    x, y = np.random.default_rng(3).normal(size=(2, 60))
    dx, dy = x - x.mean(), y - y.mean()
    found = cross_correlation(x, y, RATE)
    for lag in range(-5, 6):
        pairs = [dx[t + lag] * dy[t] for t in range(60) if 0 <= t + lag < 60]
        at = int(np.argmin(np.abs(LAGS - lag / RATE)))
        assert found[at] == pytest.approx(60 * np.mean(pairs), rel=1e-9)


def test_utterances_shorter_than_the_lags_have_none():
    assert not cross_correlation(np.arange(7.0), np.arange(7.0), RATE).any()
    assert np.isnan(opening_lag(np.zeros(len(LAGS))))


def test_a_maximum_at_the_end_is_no_lag():
    assert np.isnan(opening_lag(np.arange(1.0, 42.0)))
    # The vertex of a parabola, between two lags.
    np.testing.assert_allclose(opening_lag(1 - (LAGS - 0.0432) ** 2), 43.2, rtol=1e-9)


def test_measures_of_several_samples_at_once():
    sums = np.random.default_rng(4).uniform(1, 2, (3, 5, 6)) * [10, 1, 1, 30, 30, 10]
    for function in (opening_correlation, opening_deviation):
        np.testing.assert_array_equal(function(sums)[1, 2], function(sums[1, 2]))
    lags = np.random.default_rng(5).normal(size=(3, 5, len(LAGS)))
    np.testing.assert_array_equal(opening_lag(lags)[2, 3], opening_lag(lags[2, 3]))


def test_lengths_that_differ_are_refused():
    with pytest.raises(DataError, match="10 frames, the recorded one 9"):
        articulation(np.ones(10), np.ones(9), spoken(("b", 0.4)), RATE, TARGETS)


class Coding:
    """A coding whose parameters are the points themselves."""

    points = read_point_set("lower_face_51")

    @staticmethod
    def decode_points(parameters):
        return parameters.reshape(len(parameters), -1, 2)


def test_openings_come_from_decoded_points():
    faces = np.random.default_rng(6).normal(size=(30, Coding.points.size, 2))
    found = articulation_of(faces.reshape(30, -1), to_vector(faces), Coding, spoken(("b", 1.2)), RATE, TARGETS)
    assert value([{"id": "a", "rate": RATE, "frames": 30} | found], "opening_corr") == pytest.approx(1)

    class Markers(Coding):
        points = type("Points", (), {"regions": {"inner_lips": []}})()

    assert articulation_of(None, None, Markers, spoken(("b", 1.2)), RATE, TARGETS) == {}


def test_thresholds_are_kept_in_a_table(tmp_path):
    path = tmp_path / "closures.tsv"
    write_targets(path, TARGETS)
    assert read_targets(path) == TARGETS
    write_targets(path, (Target("bilabial", float("nan"), 0), *TARGETS[1:]))
    assert np.isnan(read_targets(path)[0].threshold)
    write_targets(path, TARGETS[:1])
    with pytest.raises(DamagedFile, match="a row for each of bilabial, labiodental, open"):
        read_targets(path)


def table_of(factor):
    """Statistics of a model whose opening is that of the recording, scaled about 5 px."""
    rows = []
    for k in range(6):
        true = smooth(np.arange(60) / RATE, k)
        alignment = spoken(("iy", 0.8), ("b", 0.1), ("iy", 1.5))
        rows.append(row(f"u{k}", 5 + factor * (true - 5), true, alignment))
    return score_table(rows)


def test_the_table_has_a_row_for_each_model_and_the_recordings():
    found = measured(
        (stack("FBB-128", "FBB", 128), table_of(0.8)),
        (stack("BFF-128", "BFF", 128), table_of(0.5)),
        ("floor", table_of(1.0)),
    )
    frame, tables = articulation_tables(found, TARGETS, (("corpus", "demo"),))
    assert list(frame["row"]) == ["FBB-128", "BFF-128", "floor", RECORDED]
    assert frame["opening_sd"].tolist()[:2] == ["0.800", "0.500"] and frame["opening_lag"][0] == "0.0"
    assert frame["opening_sd"][3] == "" and frame["closure_labiodental"].tolist() == [""] * 4
    recorded = float(frame["closure_bilabial"][3])
    assert recorded == pytest.approx(corpus_figure_of(table_of(1.0)), abs=1e-3)
    (table,) = tables
    best = table.rows[0].cells[list(ARTICULATION).index("opening_sd")]
    assert best.best and best.small == "[0.800, 0.800]"
    assert "2.00 px (p, b, m; 9 training occurrences)" in " ".join(table.notes)
    assert dict(table.facts)["test occurrences"] == "6 of p, b, m, 0 of f, v, 0 of aa, ae, aw, ay, eh"
    assert all("0.800" in text for text in all_forms(frame, tables, "Articulation"))


def corpus_figure_of(table):
    metric = ARTICULATION["closure_bilabial"]
    return float(metric.value(total(statistics_of(table, metric))))


def test_a_coding_without_inner_lips_has_empty_cells():
    table = pandas.DataFrame({"id": ["a", "b"], "rate": RATE, "frames": [3, 4]})
    closures = targets_of([])
    frame, (shown,) = articulation_tables(measured((BASELINES["floor"], table)), closures, ())
    assert set(frame.drop(columns="row").to_numpy().ravel()) == {""}
    assert "no inner lips" in " ".join(shown.notes) and "test occurrences" not in dict(shown.facts)


def test_measures_of_the_result_table_are_others():
    from visualspeech.evaluation.metrics import METRICS

    assert not set(METRICS) & set(ARTICULATION)
    with pytest.raises(Exception, match="unknown metric"):
        corpus_figure(table_of(1.0), "opening_sd")


def test_seeds_of_a_network_are_one_row():
    found = measured(
        (stack("FBB-128", "FBB", 128), table_of(0.8)),
        (dataclasses.replace(stack("FBB-128-s2", "FBB", 128, 2), title="FBB-128"), table_of(0.6)),
    )
    frame, (table,) = articulation_tables(found, TARGETS, ())
    assert list(frame["row"]) == ["FBB-128", RECORDED] and table.rows[0].title == "FBB-128 (2 seeds)"
    low, high = float(frame["opening_sd_low"][0]), float(frame["opening_sd_high"][0])
    assert low == pytest.approx(0.6, abs=0.01) and high == pytest.approx(0.8, abs=0.01)
    assert frame["closure_bilabial"][1] == f"{corpus_figure_of(table_of(1.0)):.3f}"
