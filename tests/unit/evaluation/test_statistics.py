"""The bootstrap: repeatable, of the right width, and drawn in pairs."""

import numpy as np
import pandas
import pytest

from tests.unit.evaluation import examples
from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation import statistics
from visualspeech.evaluation.metrics import METRICS, concordance, statistics_of
from visualspeech.evaluation.statistics import BootstrapSettings

SETTINGS = BootstrapSettings(samples=1000, level=0.95, seed=3)


def table(values, frames=None):
    frames = np.full(len(values), 10.0) if frames is None else np.asarray(frames, float)
    sums = {"id": [f"u{i}" for i in range(len(values))], "frames": frames, "rmse_shape_sum": values * frames}
    return pandas.DataFrame(sums)


def sampled(numerator, denominator, drawn):
    frame = pandas.DataFrame({"rmse_shape_sum": numerator, "frames": denominator})
    return statistics.sample(frame, METRICS["rmse_shape"], drawn)


def test_same_seed_same_draws_and_other_seed_others():
    drawn = statistics.draws(20, SETTINGS)
    assert drawn.shape == (1000, 20) and drawn.min() == 0 and drawn.max() == 19
    np.testing.assert_array_equal(drawn, statistics.draws(20, SETTINGS))
    assert (drawn != statistics.draws(20, BootstrapSettings(1000, 0.95, 4))).any()


def test_interval_agrees_with_normal_theory():
    values = np.random.default_rng(5).normal(3.0, 0.5, size=400)
    drawn = statistics.draws(400, BootstrapSettings(4000, 0.95, 0))
    found = statistics.figure(sampled(values * 10, np.full(400, 10.0), drawn), 0.95)
    half = 1.96 * values.std() / np.sqrt(400)
    assert found.value == pytest.approx(values.mean(), rel=1e-12)
    assert found.low == pytest.approx(values.mean() - half, abs=0.08 * half)
    assert found.high == pytest.approx(values.mean() + half, abs=0.08 * half)


def test_interval_agrees_with_a_slow_version():
    generator = np.random.default_rng(6)
    numerator, denominator = generator.uniform(1, 2, 7), generator.uniform(5, 9, 7)
    drawn = statistics.draws(7, SETTINGS)
    slow = sorted(sum(numerator[i] for i in row) / sum(denominator[i] for i in row) for row in drawn)
    found = statistics.figure(sampled(numerator, denominator, drawn), 0.9)
    assert (found.low, found.high) == pytest.approx(tuple(np.quantile(slow, [0.05, 0.95])), rel=1e-12)


def test_blocks_do_not_change_the_result(monkeypatch):
    values, frames = np.random.default_rng(7).uniform(1, 2, (2, 2100))
    drawn = statistics.draws(2100, BootstrapSettings(1100))  # more than one block
    found = statistics.figure(sampled(values, frames, drawn), 0.95)
    whole = values[drawn].sum(axis=1) / frames[drawn].sum(axis=1)
    assert (found.low, found.high) == tuple(np.quantile(whole, [0.025, 0.975]))


def test_ratio_is_drawn_in_pairs():
    """Twice the base in every utterance: the ratio is 2 in every draw, however much utterances differ."""
    numerator, denominator = np.random.default_rng(8).uniform(1, 9, 30), np.full(30, 10.0)
    drawn = statistics.draws(30, SETTINGS)
    row, base = (sampled(factor * numerator, denominator, drawn) for factor in (2, 1))
    found = statistics.relative_figure(row, base, 0.95)
    assert (found.value, found.low, found.high) == pytest.approx((2, 2, 2), rel=1e-12)


def test_no_ratio_to_what_may_be_nothing():
    drawn = statistics.draws(30, SETTINGS)
    around_zero = sampled(np.random.default_rng(9).normal(size=30), np.ones(30), drawn)
    found = statistics.relative_figure(sampled(np.ones(30), np.ones(30), drawn), around_zero, 0.95)
    assert np.isnan([found.value, found.low, found.high]).all()


def test_concordance_is_sampled_from_its_sums():
    """The interval of a measure that is no quotient, against a slow version."""
    found = examples.statistics(np.linspace(1, 2, 9), corr=np.linspace(0.2, 0.9, 9))
    drawn = statistics.draws(9, BootstrapSettings(200, 0.95, 2))
    fast = statistics.sample(found, METRICS["ccc"], drawn)
    rows = statistics_of(found, METRICS["ccc"])
    np.testing.assert_allclose(fast.samples, [float(concordance(rows[each].sum(axis=0))) for each in drawn], rtol=1e-12)


def test_summary_has_a_line_for_each_row_and_metric():
    rows = examples.measured(
        (examples.stack("FBB-128", "FBB", 128), table(np.array([1.0, 2.0]), [10, 30])),
        ("training_mean", table(np.array([2.0, 4.0]), [10, 30])),
    )
    summary = statistics.summarise(rows, ["rmse_shape"], SETTINGS)
    assert list(summary["row"]) == ["FBB-128", "training_mean"]
    assert summary["value"][0] == pytest.approx((10 * 1 + 30 * 2) / 40)
    assert list(summary["ratio"]) == pytest.approx([0.5, 1.0])


def test_one_utterance_has_an_interval_of_no_width():
    rows = examples.measured(("training_mean", table(np.array([2.0]))))
    summary = statistics.summarise(rows, ["rmse_shape"], SETTINGS)
    assert list(summary.loc[0, ["value", "low", "high"]]) == [2.0, 2.0, 2.0]


def test_missing_base_row_is_named():
    rows = examples.measured((examples.stack("F-1", "F", 1), table(np.array([1.0]))))
    with pytest.raises(DataError, match="training_mean"):
        statistics.summarise(rows, ["rmse_shape"], SETTINGS)


def test_nothing_to_evaluate():
    rows = examples.measured(("training_mean", table(np.array([]))))
    with pytest.raises(DataError, match="no test utterance"):
        statistics.summarise(rows, ["rmse_shape"], SETTINGS)


@pytest.mark.parametrize("wrong", [{"samples": 0}, {"level": 1.0}, {"level": 95}])
def test_settings_out_of_range(wrong):
    with pytest.raises(SettingError, match=next(iter(wrong))):
        BootstrapSettings(**wrong)


def test_only_errors_are_shown_as_ratios():
    rows = examples.measured(("training_mean", examples.statistics([1.0, 1.1, 1.2], corr=-0.01)))
    names = [metric.name for metric in rows.metrics(METRICS)]
    summary = statistics.summarise(rows, names, statistics.BootstrapSettings(samples=50))
    ratios = summary.set_index("metric")["ratio"].notna()
    errors = {"rmse_shape", "rmse_texture", "rmse_appearance", "lip_distance_px", "rmse_first5"}
    assert set(ratios.index[ratios]) == errors


def test_repetitions_are_drawn_beside_utterances():
    """Two seeds far apart and hardly any spread over utterances: the interval is that of the seeds."""
    generator = np.random.default_rng(10)
    spread = 0.001 * generator.normal(size=50)
    rows = examples.measured(
        *((examples.stack(f"FBB-1-{s}", "FBB", 1, s), examples.statistics(mean + spread, frames=np.full(50, 10)))
          for s, mean in ((1, 1.0), (2, 2.0), (3, 3.0))),
    ).pooled()  # fmt: skip
    settings = BootstrapSettings(4000, 0.95, 0)
    drawn = statistics.draws(50, settings)
    found = statistics.sample_row(rows, "FBB-1", METRICS["rmse_shape"], drawn, settings)
    assert found.value == pytest.approx(2.0, abs=1e-3)
    # The mean of three draws with replacement from 1, 2, 3 has the variance 2 / 3 / 3.
    assert found.samples.std() == pytest.approx(np.sqrt(2 / 9), rel=0.05)
    alone = statistics.sample(rows.tables["FBB-1"], METRICS["rmse_shape"], drawn)
    assert alone.samples.std() < 0.01 and "utterances and seeds" in settings.text(rows)


def test_two_rows_of_equal_seeds_are_drawn_apart():
    tables = [examples.statistics(np.full(5, value)) for value in (1.0, 2.0)]
    rows = examples.measured(
        *((examples.stack(f"{letters}-1-{s}", letters, 1, s), table)
          for letters in ("F", "B") for s, table in enumerate(tables, start=1)),
    ).pooled()  # fmt: skip
    drawn = statistics.draws(5, SETTINGS)
    one, other = (
        statistics.sample_row(rows, name, METRICS["rmse_shape"], drawn, SETTINGS).samples for name in ("F-1", "B-1")
    )
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.1
