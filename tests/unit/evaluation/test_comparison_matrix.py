"""All comparisons of a system as one table."""

import numpy as np

from tests.unit.evaluation.examples import hmm, measured, stack, statistics
from visualspeech.evaluation.comparison_matrix import comparison_matrix
from visualspeech.evaluation.comparisons import compare
from visualspeech.evaluation.gathering import pooled_rows

ERRORS = np.linspace(1, 2, 12)


def rows(count=12):
    errors = ERRORS[:count]
    return measured(
        (stack("FBB-64", "FBB", 64), statistics(errors)),
        (stack("FBB-64-s2", "FBB", 64, 2), statistics(errors + 0.01)),
        (hmm("hmm", "MGE-trained HMM"), statistics(1.2 * errors, 0.4)),
        ("training_mean", statistics(2 * errors, 0.0)),
    )


def test_each_row_has_its_figures_and_the_rows_it_differs_from():
    given = rows()
    frame = compare(given, ["rmse_appearance", "corr"])
    table = comparison_matrix(frame, pooled_rows(given.rows), 0.05)
    assert [row.title for row in table.rows] == ["FBB-64", "MGE-trained HMM", "Training mean"]
    assert [row.cells[0].small for row in table.rows] == ["▲ 2", "▲ 1 ▼ 1", "▼ 2"]
    assert [row.cells[0].best for row in table.rows] == [True, False, False]
    for number, metric in enumerate(("rmse_appearance", "corr")):
        part = frame[frame["metric"] == metric]
        for name, row in zip(("FBB-64", "hmm", "training_mean"), table.rows, strict=True):
            values = [*part[part["first"] == name]["first_value"], *part[part["second"] == name]["second_value"]]
            assert row.cells[number].text == f"{values[0]:.3f}"
            losses = (((part["first"] == name) | (part["second"] == name)) & ~part["better"].isin(["", name])).sum()
            assert (f"▼ {losses}" in row.cells[number].small) == bool(losses)


def test_too_few_utterances_leave_no_difference():
    given = rows(3)
    table = comparison_matrix(compare(given, ["rmse_appearance"]), pooled_rows(given.rows), 0.05)
    assert all(cell.small == "" for row in table.rows for cell in row.cells)
    assert table.notes[0] == "No two rows differ significantly in any measure (Holm-corrected p at least 0.05)."


def test_measures_of_the_absolute_protocol_and_of_a_user_are_named():
    given = rows()
    frame = compare(given, ["rmse_appearance"])
    both = frame.assign(metric="lip_distance_px_absolute"), frame.assign(metric="my_measure")
    headings = [comparison_matrix(one, pooled_rows(given.rows), 0.05).columns[0] for one in both]
    assert headings == ["Lip distance, absolute [px]\u00a0↓", "my_measure"]


def test_a_single_row_makes_an_empty_table():
    given = measured(("training_mean", statistics(ERRORS)))
    table = comparison_matrix(compare(given, ["rmse_appearance"]), pooled_rows(given.rows), 0.05)
    assert table.rows == () and table.columns == ()
