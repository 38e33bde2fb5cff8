"""The figure of all systems and the short table: which rows they show, and where."""

from dataclasses import replace

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import BASELINES, hmm, stack
from visualspeech.evaluation.conclusions import Choice, Conclusion
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.overview import (
    MAX_MODELS,
    SHORT_COLUMNS,
    SHORT_ROWS,
    Band,
    Line,
    Shown,
    SystemOverview,
    bands,
    figures_of,
    short_table,
)
from visualspeech.evaluation.overview_figure import overview_figure, tick_step
from visualspeech.models.rows import ModelRow

ORACLE = ModelRow("oracle", "oracle DV", "dnn", role="oracle")


def system(name, nets, **changes):
    rows = [stack(f"FBB-{i}", "FBB", 64) for i in range(nets)] + [hmm("hmm", "MGE-trained HMM"), ORACLE]
    rows += list(BASELINES.values())
    ranked = (*(f"FBB-{i}" for i in range(nets)), "hmm")
    choice = Choice(ranked, METRICS["rmse_appearance"], "hmm", "training_mean")
    of_name = {row.name: row for row in rows}
    return replace(SystemOverview(name, f"System {name}", of_name, Conclusion(choice, "A sentence.")), **changes)


def figures(*systems, without=()):
    lines = []
    for number, one in enumerate(systems):
        for place, row in enumerate(one.rows):
            value = np.nan if row in without else 1 + number + 0.01 * place
            lines += [(one.name, row, metric, "lips", value, value - 0.1, value + 0.1) for metric in SHORT_COLUMNS]
            lines += [(one.name, row, "lip_distance", "value", 99.0, 99.0, 99.0)]
    columns = ["system", "row", "metric", "part", "value", "low", "high"]
    return figures_of(pandas.DataFrame(lines, columns=columns))


def test_few_models_have_a_line_each():
    one = system("a", 3, spoken="FBB-2")
    (band,) = bands([one], figures(one))
    assert [(line.title, line.role) for line in band.lines] == [
        ("FBB-0", "best"), ("FBB-1", "model"), ("FBB-2", "model"), ("MGE-trained HMM", "model"),
        ("Training mean", "baseline"), ("Phone-state mean", "baseline"), ("Reconstruction (floor)", "floor"),
    ]  # fmt: skip
    assert [line.note for line in band.lines[:3]] == ["best on validation", "", "in the videos"]
    assert band.baseline == pytest.approx(1.05) and band.floor == pytest.approx(1.07)
    assert all(len(line.dots) == 1 for line in band.lines)


def test_further_models_share_a_line_and_those_that_matter_are_named():
    one = system("a", 60, spoken="FBB-40")
    (band,) = bands([one], figures(one))
    models = [line for line in band.lines if line.role in ("best", "model")]
    assert [line.title for line in models] == ["FBB-0", "FBB-1", "FBB-2", "FBB-40", "MGE-trained HMM"]
    assert len(models) == MAX_MODELS
    (others,) = [line for line in band.lines if line.role == "others"]
    assert others.title == "56 further models" and len(others.dots) == 56
    assert len(band.lines) <= 10


def test_rows_without_a_figure_are_left_out():
    one, two = system("a", 2), system("b", 1)
    known = figures(one, two, without=("FBB-0", "floor"))
    first, second = bands([one, two], known)
    assert "FBB-0" not in [line.title for line in first.lines] and np.isnan(first.floor)
    assert bands([one], {}) == () and short_table([one], {}) is None
    assert [line.title for line in second.lines][0] == "MGE-trained HMM"


def test_a_system_without_a_chosen_model_is_shown_all_the_same():
    one = system("a", 2, conclusion=Conclusion(None, "No model can be chosen."))
    (band,) = bands([one], figures(one))
    assert [line.role for line in band.lines][:3] == ["model"] * 3 and np.isnan(band.baseline)


def test_the_short_table_has_six_rows_of_which_each_system_has_its_share():
    systems = [system(name, 20, spoken="FBB-3") for name in "abc"]
    table = short_table(systems, figures(*systems))
    rows = [row for row in table.rows if row.cells]
    assert len(rows) == SHORT_ROWS and [row.title for row in table.rows if not row.cells] == [
        "System a", "System b", "System c"]  # fmt: skip
    assert [row.title for row in rows] == ["FBB-0 (best on validation)", "MGE-trained HMM"] * 3
    assert rows[0].cells[0].best and not any(row.cells[0].best for row in rows[1:])
    alone = short_table(systems[:1], figures(*systems[:1]))
    assert [row.title for row in alone.rows] == [
        "FBB-0 (best on validation)", "MGE-trained HMM", "FBB-3 (in the videos)", "FBB-1", "Training mean",
        "Reconstruction (floor)",
    ]  # fmt: skip
    assert not any(cell.best for row in alone.rows[4:] for cell in row.cells)
    assert "oracle DV" not in str(alone)
    many = [system(str(number), 1) for number in range(9)]
    assert len([row for row in short_table(many, figures(*many)).rows if row.cells]) == 9


def test_costs_have_no_interval():
    one = system("a", 1)
    cells = short_table([one], figures(one)).rows[0].cells
    assert cells[0].small == "[0.90, 1.10]" and cells[SHORT_COLUMNS.index("parameters")].small == ""


@pytest.mark.parametrize(
    ("most", "step"), [(2.1, 0.5), (1.36, 0.5), (5, 1), (0.07, 0.02), (900, 200), (0, 1), (np.nan, 1)]
)
def test_steps_of_the_axis(most, step):
    assert tick_step(most) == pytest.approx(step)


def test_positions_lie_inside_the_plot():
    wide = Band("a", (Line("x", "best", (Shown(1.0, 0.5, 50.0),)), Line("y", "model", (Shown(2.0, 1.9, np.nan),))))
    drawn = overview_figure([wide])
    (band,) = drawn.bands
    assert band.tracks[0].ends[1] == "100.00%" and band.tracks[1].ends == () and band.baseline == band.floor == ""
    assert [text for _, text in drawn.ticks] == ["0.0", "0.5", "1.0", "1.5", "2.0", "2.5"]
    assert drawn.ticks[0][0] == "0.00%" and drawn.ticks[-1][0] == "100.00%"
    assert overview_figure([]).bands == ()
