"""Three systems in one table: what is compared with what, and what is blank."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.evaluation.examples import measured, stack, statistics
from tests.unit.evaluation.nesting import check_nesting
from visualspeech.errors import DataError
from visualspeech.evaluation import forms
from visualspeech.evaluation.across_systems import COLUMNS, SystemRows, systems_frame, systems_tables
from visualspeech.evaluation.facts import TableFacts
from visualspeech.evaluation.metrics import corpus_figure
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP = BootstrapSettings(200, 0.95, 1)
ERRORS = np.linspace(1, 2, 8)


def system(name, rate, scale, sizes, seeds=(1,), drop=()):
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
    rows = measured(*((row, table.drop(columns=list(drop))) for row, table in pairs))
    facts = TableFacts("demo", name, "0123456789ab", rows.rates, "aam51", sizes, "clip_mean", rows.seeds)
    return SystemRows(f"The system {name}", facts, rows)


def systems():
    return (
        system("fan2015", 25.0, 1.0, "66 shape, 100 texture, 87 appearance"),
        system("thangthai2016", 100.0, 40.0, "20 shape, 30 appearance", seeds=(1, 2)),
        system("markers", 120.0, 3.0, "", drop=("lip_distance_px_sum",)),
    )


def test_ratios_are_to_the_training_mean_of_the_own_system():
    frame = systems_frame(systems(), BOOTSTRAP).set_index(["system", "row", "metric"])
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


def test_every_system_has_a_heading_with_its_rate_and_sizes():
    (table,) = systems_tables(systems_frame(systems(), BOOTSTRAP), systems(), BOOTSTRAP)
    headings = [row.title for row in table.rows if not row.cells]
    assert headings == [
        "The system fan2015: 25 Hz; aam51 (66 shape, 100 texture, 87 appearance); drift removal clip_mean; seed 1",
        "The system thangthai2016: 100 Hz; aam51 (20 shape, 30 appearance); drift removal clip_mean; seeds 1, 2",
        "The system markers: 120 Hz; aam51; drift removal clip_mean; seed 1",
    ]
    assert [row.title for row in table.rows if row.cells] == 3 * ["FBB-1", "Training mean", "Reconstruction (floor)"]
    facts = dict(table.facts)
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
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {len(COLUMNS) + 2}
    assert latex.count(rf"\multicolumn{{{len(COLUMNS) + 1}}}{{l}}") == 3
    assert page.count('<tr class="heading">') == 3
    check_nesting(page)


def test_systems_must_share_their_test_utterances_and_differ_in_name():
    first, second, _ = systems()
    fewer = second.measured.tables["training_mean"].iloc[:-1]
    other = replace(second, measured=measured(("training_mean", fewer)))
    with pytest.raises(DataError, match="`thangthai2016` and `fan2015` were evaluated on different utterances"):
        systems_frame((first, other), BOOTSTRAP)
    with pytest.raises(DataError, match="one name"):
        systems_frame((first, first), BOOTSTRAP)


def test_systems_of_codings_that_lost_different_utterances_are_compared_on_the_common_ones():
    first, second, _ = systems()
    ids = list(first.measured.tables["training_mean"]["id"])
    lacking = replace(second, measured=second.measured.on(ids[:-1]))
    assert lacking.measured.utterances == len(ids) - 1
    common = (replace(first, measured=first.measured.on(ids[:-1])), lacking)
    frame = systems_frame(common, BOOTSTRAP)
    (table,) = systems_tables(frame, common, BOOTSTRAP, lost=ids[-1:])
    assert any("Left out" in note and ids[-1] in note for note in table.notes)
    (whole,) = systems_tables(frame, common, BOOTSTRAP)
    assert not any("Left out" in note for note in whole.notes)
    every = first.measured.on(ids)
    assert all(every.tables[name].equals(table) for name, table in first.measured.tables.items())
