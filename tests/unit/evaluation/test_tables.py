"""The result table: its rows, its marks, its ratios, and the same figures in every form."""

import dataclasses
import re

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import BASELINES, measured, stack, statistics
from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS, Metric, corpus_figure
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import PARTS, TableSettings, result_tables

FACTS = (("corpus", "demo"), ("split", "0123456789ab"))
BOOTSTRAP = BootstrapSettings(samples=200, level=0.9, seed=1)
ERRORS = 1 + 0.1 * np.arange(6)


def rows():
    return measured(
        (stack("FBB-128", "FBB", 128), statistics(ERRORS, 0.7, 0.8)),
        (stack("BFF-128", "BFF", 128), statistics(1.1 * ERRORS, 0.7, 1.3)),
        ("training_mean", statistics(2.0 * ERRORS, 0.0, 0.0, undefined=3)),
        ("phone_state_mean", statistics(1.5 * ERRORS, 0.4, 1.1)),
        ("floor", statistics(0.1 * ERRORS, 1.0, 1.0)),
    )


def made(settings=None, found=None):
    return result_tables(found or rows(), FACTS, settings, BOOTSTRAP)


def cell(table, title, heading):
    column = next(i for i, name in enumerate(table.columns) if name.startswith(heading))
    return next(row for row in table.rows if row.title == title).cells[column]


def test_rows_keep_their_order_title_and_role():
    frame, (figures, ratios) = made()
    titles = ["FBB-128", "BFF-128", *(row.title for row in BASELINES.values())]
    assert list(frame["row"]) == ["FBB-128", "BFF-128", *BASELINES]
    for table in (figures, ratios):
        assert [row.title for row in table.rows] == titles
        assert [row.role for row in table.rows] == ["model", "model", "baseline", "baseline", "floor"]


def test_facts_say_what_was_measured_on_what():
    _, (figures, ratios) = made()
    facts = dict(figures.facts)
    assert figures.facts[:2] == FACTS and not ratios.facts
    assert "90 %" in facts["intervals"] and "200 samples" in facts["intervals"]
    assert facts["frames with undefined correlation, counted as 0"] == "Training mean 18"
    assert len(made(TableSettings(("rmse_shape",)))[1][0].facts) == 4


def test_each_protocol_has_tables_of_its_own():
    found = rows()
    tables = {name: table.assign(lip_distance_px_absolute_sum=2 * table["lip_distance_px_sum"]) for name, table in
              found.tables.items()}  # fmt: skip
    frame, made_tables = made(found=MeasuredRows(found.rows, tables))
    assert [table.title.partition(":")[0] for table in made_tables[::2]] == [
        "Objective measures, centred", "Objective measures, absolute",
    ]  # fmt: skip
    protocols = [dict(table.facts)["protocol"] for table in made_tables[::2]]
    assert protocols[0].startswith("centred") and protocols[1].startswith("absolute")
    assert made_tables[2].columns == (METRICS["lip_distance_px_absolute"].heading,)
    assert float(frame["lip_distance_px_absolute"][0]) == pytest.approx(
        2 * float(frame["lip_distance_px"][0]), abs=2e-3
    )


def test_best_is_marked_ties_too_and_the_floor_never():
    _, (figures, ratios) = made()
    best = {heading: {row.title for row, c in zip(figures.rows, column, strict=True) if c.best}
            for heading, column in zip(figures.columns, zip(*(row.cells for row in figures.rows), strict=True),
                                       strict=True)}  # fmt: skip
    assert best[METRICS["rmse_shape"].heading] == {"FBB-128"}
    assert best[METRICS["corr"].heading] == {"FBB-128", "BFF-128"}
    assert best[METRICS["gv_ratio"].heading] == {"Phone-state mean"}
    assert not any(c.best for row in ratios.rows for c in row.cells)


def test_ratios_to_the_training_mean():
    frame, (_, ratios) = made()
    assert cell(ratios, "FBB-128", "RMSE(shape)").text == "0.500"
    assert cell(ratios, "Training mean", "RMSE(shape)").text == "1.000"
    assert cell(ratios, "FBB-128", "CORR").text == "" == frame["corr_ratio"][0]
    assert "no correlation" in ratios.notes[0] and ratios.title.endswith("ratio to the training mean")


def test_settings_choose_metrics_and_digits():
    _, (figures, ratios) = made(TableSettings(("corr", "rmse_shape", "ccc"), 2, ratio_digits=1))
    assert figures.columns == tuple(METRICS[name].heading for name in ("corr", "rmse_shape", "ccc"))
    assert cell(figures, "FBB-128", "CORR").text == "0.70"
    assert re.fullmatch(r"\d\.\d{2}", cell(figures, "FBB-128", "RMSE(shape)").text)
    assert cell(ratios, "FBB-128", "RMSE(shape)").text == "0.5"
    assert cell(made(TableSettings(("corr",), 0))[1][0], "FBB-128", "CORR").text == "1"
    assert "ccc" not in TableSettings().metrics


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"metrics": ()}, "at least 1 entry"),
        ({"digits": {"corr": 2}}, "tables.digits"),
        ({"digits": -1}, "tables.digits"),
        ({"digits": "3"}, "tables.digits"),
        ({"digits": True}, "tables.digits"),
        ({"ratio_digits": 99}, "tables.ratio_digits"),
    ],
)
def test_wrong_settings_are_named(wrong, message):
    with pytest.raises(SettingError, match=message):
        TableSettings(**wrong)


def test_an_unknown_measure_is_named():
    with pytest.raises(SettingError, match="unknown metric `rmse_shap`.*Known: rmse_shape"):
        made(TableSettings(("rmse_shap",)))


def test_missing_training_mean_is_named():
    with pytest.raises(DataError, match="training_mean"):
        made(found=measured((stack("FBB-128", "FBB", 128), statistics(ERRORS))))


def test_every_form_shows_every_figure():
    frame, tables = made()
    for text in all_forms(frame, tables, "Objective measures"):
        for row in frame.itertuples():
            assert all(str(value) in text for value in row[2:])
        assert "0123456789ab" in text


def test_tsv_is_read_by_others(tmp_path):
    frame, tables = made()
    (tmp_path / "t.tsv").write_text(all_forms(frame, tables, "t")[0], encoding="utf-8")
    table = pandas.read_csv(tmp_path / "t.tsv", sep="\t", comment="#", index_col="row")
    assert table.loc["FBB-128", "corr"] == 0.7 and len(table.columns) == len(PARTS) * 6
    assert table.loc["FBB-128", "rmse_shape_low"] < table.loc["FBB-128", "rmse_shape"]


def test_a_new_measure_is_one_entry(monkeypatch):
    """What CONTRIBUTING says of adding a measure: a statistic of each utterance, and an entry of METRICS."""

    def value(sums):
        return sums[..., 0] / sums[..., 1] + 1

    metric = Metric("dummy", "Dummy", "an error and 1", "low", ("dummy_sum", "frames"), value)
    monkeypatch.setitem(METRICS, "dummy", metric)
    found = rows()
    tables = {name: table.assign(dummy_sum=table["rmse_shape_sum"]) for name, table in found.tables.items()}
    frame, (figures, _) = made(TableSettings(("dummy",)), MeasuredRows(found.rows, tables))
    assert frame["dummy"][0] == f"{corpus_figure(tables['FBB-128'], 'rmse_shape') + 1:.3f}"
    assert cell(figures, "FBB-128", "Dummy").best and not cell(figures, "BFF-128", "Dummy").best


def test_same_input_same_text():
    assert all_forms(*made(), "t") == all_forms(*made(), "t")


def titled(name, seed):
    return dataclasses.replace(stack(name, "FBB", 128, seed), title="FBB-128")


def repeated_rows():
    return measured(
        (titled("FBB-128", 1), statistics(ERRORS, 0.7, 0.8, undefined=1)),
        (titled("FBB-128-s2", 2), statistics(1.2 * ERRORS, 0.5, 0.6)),
        (stack("BFF-128", "BFF", 128), statistics(1.15 * ERRORS, 0.7, 1.3)),
        ("training_mean", statistics(2.0 * ERRORS, 0.0, 0.0)),
    )


def test_seeds_are_pooled_and_shown_one_by_one_below():
    frame, (figures, ratios, each) = made(found=repeated_rows())
    assert [row.title for row in figures.rows] == ["FBB-128 (2 seeds)", "BFF-128", "Training mean"]
    assert [row.title for row in ratios.rows] == [row.title for row in figures.rows]
    assert [row.title for row in each.rows] == ["FBB-128, seed 1", "FBB-128, seed 2"]
    assert list(frame["row"]) == ["FBB-128", "BFF-128", "training_mean", "FBB-128-s1", "FBB-128-s2"]
    assert "utterances and seeds" in dict(figures.facts)["intervals"]
    assert dict(figures.facts)["frames with undefined correlation, counted as 0"] == "FBB-128 3"
    figure = {row.row: row for row in frame.itertuples()}
    single = [float(figure[f"FBB-128-s{seed}"].rmse_shape) for seed in (1, 2)]
    assert float(figure["FBB-128"].rmse_shape) == pytest.approx(np.mean(single), abs=1e-3)
    assert float(figure["FBB-128-s2"].rmse_shape_ratio) == pytest.approx(0.6, abs=1e-3)
    assert cell(each, "FBB-128, seed 2", "RMSE(shape)").text == figure["FBB-128-s2"].rmse_shape
    # The seeds differ more than the utterances do.
    assert float(figure["FBB-128"].corr_high) > 0.65 > 0.55 > float(figure["FBB-128"].corr_low)
    assert not any(c.best for row in each.rows for c in row.cells)
    for text in all_forms(frame, (figures, ratios, each), "Objective measures"):
        assert "FBB-128, seed 2" in text or "FBB-128-s2" in text
