"""Three systems in one table: what is compared with what, and what is blank."""

import re
from dataclasses import replace

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import measured, stack, statistics
from tests.unit.evaluation.nesting import check_nesting
from visualspeech.errors import DataError
from visualspeech.evaluation import forms
from visualspeech.evaluation.across_systems import (
    COLUMNS,
    GROUPS,
    LIP_COLUMNS,
    RECORDED,
    SystemRows,
    systems_frame,
    systems_tables,
)
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.lip_metrics import ACROSS, COSTS
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP = BootstrapSettings(200, 0.95, 1)
ERRORS = np.linspace(1, 2, 8)


def lips(error, ids=None, cost=True):
    """Lip statistics of eight utterances whose predicted movements are those of the recording, less ``error`` of it."""
    frames, size = np.arange(8) + 40.0, 1 - error
    moments = (frames, 0 * frames, 0 * frames, size**2 * frames, frames, size * frames)
    columns = {"id": ids or [f"u{i}" for i in range(8)], "rate": 25.0, "frames": frames, "utterances": 1}
    columns |= {"lip_distance_sum": 2 * error * frames * ERRORS, "jerk.0": size**2 * frames, "jerk.1": frames}
    for name in ("opening", "width"):
        columns |= {f"{name}.{number}": values for number, values in enumerate(moments)}
    lags = 1 - (np.arange(41) - 20 - 10 * error) ** 2 / 900
    columns |= {f"lag.{number}": value for number, value in enumerate(lags)}
    closed = {"closed": 3 - 2 * error, "closures": 3, "silent_closed": 8 - 4 * error, "silent_frames": 10}
    columns |= closed | {"recorded_closed": 2, "recorded_silent_closed": 7}
    columns |= {"seconds": 0.5 if cost else np.nan, "parameters": 1000 * error if cost else np.nan}
    return pandas.DataFrame(columns)


def system(name, rate, scale, sizes, seeds=(1,), drop=(), error=0.25):
    """A system whose parameters are ``scale`` times as large as those of another."""
    frames = np.arange(8) * rate + rate
    nets = [
        (stack(f"FBB-{s}", "FBB", 64, s), statistics(0.5 * scale * ERRORS + 0.1 * s, 0.7, 0.8, frames, rate))
        for s in seeds
    ]
    pairs = (
        *nets,
        ("training_mean", statistics(scale * ERRORS, 0.0, 0.0, frames, rate)),
        ("floor", statistics(0 * ERRORS, 1.0, 1.0, frames, rate)),
    )
    rows = measured(*((row, table.drop(columns=list(drop), errors="ignore")) for row, table in pairs))
    shown = {"training_mean": lips(1.0), "floor": lips(0.0, cost=False)}
    tables = {row: shown.get(row, lips(error)) for row in rows.tables}
    left = [column for column in lips(0) for one in drop if column.startswith(one)]
    own = MeasuredRows(rows.rows, {row: table.drop(columns=left) for row, table in tables.items()})
    facts = TableFacts("demo", name, "0123456789ab", rows.rates, "aam51", sizes, "clip_mean", rows.seeds)
    return SystemRows(f"The system {name}", facts, rows, own)


NO_INNER_LIPS = ("closed", "closures", "silent_", "opening.", "lag.")


def systems():
    return (
        system("fan2015", 25.0, 1.0, "66 shape, 100 texture, 87 appearance"),
        system("thangthai2016", 100.0, 40.0, "20 shape, 30 appearance", seeds=(1, 2)),
        system("markers", 120.0, 3.0, "", drop=("lip_distance_px_sum", *NO_INNER_LIPS), error=0.5),
    )


def test_ratios_are_to_the_training_mean_of_the_own_system():
    frame = systems_frame(systems(), BOOTSTRAP)
    assert len(frame) == 2 + 3 * 3 * (len(COLUMNS) + len(LIP_COLUMNS))
    frame = frame[frame["part"] != "lips"].set_index(["system", "row", "metric"])
    for each in systems():
        name, pooled = each.facts.system, each.measured.pooled()
        figures = {row: corpus_figure(pooled.tables[row], "rmse_appearance") for row in pooled.tables}
        for row in ("FBB-64", "training_mean", "floor"):
            line = frame.loc[name, row, "rmse_appearance"]
            assert line["value"] == pytest.approx(figures[row] / figures["training_mean"])
            assert line["part"] == "ratio" and line["low"] <= line["value"] <= line["high"]
        assert frame.loc[name, "FBB-64", "corr"]["value"] == pytest.approx(0.7)
    assert frame.loc["markers"].xs("lip_distance_px", level=1)["value"].isna().all()
    assert len(frame) == 3 * 3 * len(COLUMNS)


def test_lips_have_the_figures_of_their_definitions():
    frame = systems_frame(systems(), BOOTSTRAP)
    lines = {(line.system, line.row, line.metric): line for line in frame.itertuples() if line.part == "lips"}
    errors = {("fan2015", "FBB-64"): 0.25, ("markers", "FBB-64"): 0.5, ("fan2015", "training_mean"): 1.0}
    for (name, row), error in errors.items():
        found = {metric: line.value for (*of, metric), line in lines.items() if of == [name, row]}
        size, weights = 1 - error, np.arange(8) + 40.0
        assert found["lip_distance"] == pytest.approx(2 * error * np.average(ERRORS, weights=weights))
        assert found["jerk"] == pytest.approx(size)
        assert found["width_ccc"] == pytest.approx(2 * size / (size**2 + 1))
        assert found["width_corr"] == (pytest.approx(1) if size else pytest.approx(np.nan, nan_ok=True))
        assert found["frames_per_second"] == pytest.approx(weights.sum() / 4)
        assert found["parameters"] == pytest.approx(1000 * error)
        if name != "markers":
            assert found["closure"] == pytest.approx(1 - 2 * error / 3)
            assert found["lag"] == pytest.approx(100 * error)
            assert found["silence"] == pytest.approx(0.8 - 0.4 * error)
            assert found["opening_ccc"] == found["width_ccc"]
    for metric in ("closure", "silence", "opening_corr", "opening_ccc", "lag"):
        assert np.isnan(lines["markers", "FBB-64", metric].value)
    assert all(np.isnan(lines["fan2015", "floor", name].value) for name in COSTS)
    recorded = {metric: line.value for (_, row, metric), line in lines.items() if row == RECORDED}
    assert recorded == pytest.approx({"closure": 2 / 3, "silence": 0.7})
    line = lines["fan2015", "FBB-64", "lip_distance"]
    assert line.low < line.value < line.high


def test_systems_whose_parameters_are_not_measured_are_left_out_of_the_second_table():
    names = [column for name, _ in COLUMNS for column in METRICS[name].columns if column != "frames"]
    first, markers = system("fan2015", 25.0, 1.0, ""), system("markers", 25.0, 1.0, "", drop=names)
    for given, titles in (((first, markers), ["The system fan2015"]), ((markers,), None)):
        lead, *others = systems_tables(systems_frame(given, BOOTSTRAP), given, BOOTSTRAP)
        headings = [row.title.partition(":")[0] for one in others for row in one.rows if not row.cells]
        assert headings == (titles or []) and len(others) == bool(titles)
        assert len([row for row in lead.rows if not row.cells]) == len(given)


def test_the_lips_lead_and_the_best_of_all_systems_is_bold():
    table, _ = systems_tables(systems_frame(systems(), BOOTSTRAP), systems(), BOOTSTRAP)
    assert table.title == "Systems on one corpus" and sum(span for _, span in table.groups) == len(table.columns)
    rows = {(number, row.title): row.cells for number, row in enumerate(table.rows) if row.cells}
    assert [title for _, title in rows][:4] == ["Recorded faces", "FBB-1", "Training mean", "Reconstruction (floor)"]
    best = {
        name: [(number, title) for (number, title), cells in rows.items() if cells[place].best]
        for place, name in enumerate(LIP_COLUMNS)
    }
    nets = [(2, "FBB-1"), (6, "FBB-1")]
    assert all(best[name] == nets for name in ("lip_distance", "jerk", "lag", "closure", "silence", "opening_ccc"))
    # Baselines are not compared with models; a rate of frames is the same here for all.
    assert best["parameters"] == nets and {title for _, title in best["frames_per_second"]} == {"FBB-1"}
    assert [cell.text for cell in rows[0, "Recorded faces"]][-4:] == ["0.667", "0.700", "", ""]
    # What has no spread has no interval.
    assert rows[2, "FBB-1"][-1].text == "250" and rows[2, "FBB-1"][-1].small == ""
    assert {name for names in GROUPS.values() for name in names} == set(ACROSS)


def test_no_measure_of_the_second_table_has_a_name_of_the_first():
    assert not {name for name, _ in COLUMNS} & set(LIP_COLUMNS)


def test_every_system_has_a_heading_with_its_rate_and_sizes():
    _, table = systems_tables(systems_frame(systems(), BOOTSTRAP), systems(), BOOTSTRAP)
    headings = [row.title for row in table.rows if not row.cells]
    assert headings == [
        "The system fan2015: 25 Hz; aam51 (66 shape, 100 texture, 87 appearance); drift removal clip_mean; seed 1",
        "The system thangthai2016: 100 Hz; aam51 (20 shape, 30 appearance); drift removal clip_mean; seeds 1, 2",
        "The system markers: 120 Hz; aam51; drift removal clip_mean; seed 1",
    ]
    assert [row.title for row in table.rows if row.cells] == 3 * ["FBB-1", "Training mean", "Reconstruction (floor)"]
    (first, _) = systems_tables(systems_frame(systems(), BOOTSTRAP), systems(), BOOTSTRAP)
    facts = dict(first.facts)
    assert facts["corpus"] == "demo" and facts["split"] == "0123456789ab" and facts["test utterances"] == "8"
    # The best of all systems, floors aside; the system without lips is blank there.
    best = [(i, j) for i, row in enumerate(table.rows) for j, cell in enumerate(row.cells) if cell.best]
    assert (
        {j for _, j in best} == {0, 2, 3, 4}
        and (1, 0) in best
        and not any("floor" == table.rows[i].role for i, _ in best)
    )
    assert table.rows[9].cells[0].text == ""


def test_three_systems_in_every_form():
    frame = systems_frame(systems(), BOOTSTRAP)
    tsv, markdown, latex, page = forms.all_forms(frame, systems_tables(frame, systems(), BOOTSTRAP), "Systems")
    assert tsv.startswith("# corpus: demo\n") and "thangthai2016\tFBB-64\tcorr\tvalue\t" in tsv
    lines = [line for line in markdown.splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {len(LIP_COLUMNS) + 2, len(COLUMNS) + 2}
    for columns in (COLUMNS, LIP_COLUMNS):
        assert latex.count(rf"\multicolumn{{{len(columns) + 1}}}{{l}}") == 3
    assert page.count('<tr class="heading">') == 6
    check_nesting(page)


def test_systems_must_share_their_test_utterances_and_differ_in_name():
    first, second, _ = systems()
    fewer = second.measured.tables["training_mean"].iloc[:-1]
    other = replace(second, measured=measured(("training_mean", fewer)))
    unlike = replace(first, lips=first.lips.on(first.lips.tables["floor"]["id"][:7]))
    with pytest.raises(DataError, match="`lips of fan2015` and `fan2015` were evaluated on different utterances"):
        systems_frame((unlike,), BOOTSTRAP)
    with pytest.raises(DataError, match="`thangthai2016` and `fan2015` were evaluated on different utterances"):
        systems_frame((first, other), BOOTSTRAP)
    with pytest.raises(DataError, match="one name"):
        systems_frame((first, first), BOOTSTRAP)


def test_systems_of_codings_that_lost_different_utterances_are_compared_on_the_common_ones():
    first, second, _ = systems()
    ids = list(first.measured.tables["training_mean"]["id"])
    lacking, kept = (
        replace(one, measured=one.measured.on(ids[:-1]), lips=one.lips.on(ids[:-1])) for one in (second, first)
    )
    assert lacking.measured.utterances == len(ids) - 1
    common = (kept, lacking)
    frame = systems_frame(common, BOOTSTRAP)
    table, _ = systems_tables(frame, common, BOOTSTRAP, lost=ids[-1:])
    assert any("Left out" in note and ids[-1] in note for note in table.notes)
    whole, _ = systems_tables(frame, common, BOOTSTRAP)
    assert not any("Left out" in note for note in whole.notes)
    every = first.measured.on(ids)
    assert all(every.tables[name].equals(table) for name, table in first.measured.tables.items())
