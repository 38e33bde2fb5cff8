"""Tables of chosen rows: means and deviations over utterances, paired differences, published figures, oracle rows."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.evaluation.examples import hmm, measured, stack, statistics
from visualspeech.errors import SettingError
from visualspeech.evaluation import forms
from visualspeech.evaluation.published_results import published, published_of
from visualspeech.evaluation.selection_settings import SelectionSettings
from visualspeech.evaluation.selections import COLUMNS, PUBLISHED, RUN, selection_frame, selection_tables
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP = BootstrapSettings(400, 0.95, 1)
ERRORS = np.random.default_rng(1).uniform(1, 3, 40)
SETTINGS = SelectionSettings(
    title="Units", rows=("hmm", "F-8", "told"), intervals=("rmse_appearance",), reference="F-8", notes=("A sentence.",)
)
BARE = {"source": "A paper", "corpus": "its own"}
PAPER = published_of(
    BARE
    | {
        "selections": {
            "units": {
                "metrics": ["corr_first5", "rmse_first5"],
                "digits": [2, 1],
                "figures": {"HMM": [[0.7, 0.05], [10.46, 2.17]]},
                "notes": ["As printed."],
            }
        }
    },
    "a_paper",
)


def found():
    told = replace(stack("told", "F", 8, cell="told"), role="oracle")
    return measured(
        (hmm("hmm", "HMM"), statistics(ERRORS + 0.2, 0.4)),
        (stack("F-8", "F", 8), statistics(ERRORS, 0.5)),
        (told, statistics(ERRORS - 0.5, 0.8)),
    )


def both(settings=SETTINGS, rows=None, paper=PAPER):
    rows = rows or found()
    frame = selection_frame(rows, settings, BOOTSTRAP, paper.selections["units"] if paper else None)
    return frame, selection_tables(frame, rows, settings, "units", (("corpus", "x"),), BOOTSTRAP, paper)


def test_means_and_deviations_are_over_utterances():
    frame, tables = both()
    assert tuple(frame.columns) == COLUMNS
    line = frame[frame["source"] == RUN].set_index(["row", "metric"]).loc["F-8", "rmse_first5"]
    assert line["mean"] == pytest.approx(ERRORS.mean()) and line["deviation"] == pytest.approx(np.std(ERRORS, ddof=1))
    cells = dict(zip([row.title for row in tables[0].rows], [row.cells for row in tables[0].rows], strict=True))
    assert cells["F-8"][1].text == f"{ERRORS.mean():.3f}" and cells["F-8"][1].small.startswith("± 0.")


def test_differences_are_paired_and_those_without_zero_are_bold():
    frame, tables = both()
    line = frame[frame["source"] == RUN].set_index(["row", "metric"]).loc["hmm", "rmse_appearance"]
    # Every utterance differs by the same, so that the interval of the difference is narrow, unlike those of the rows.
    assert line[["difference", "difference_low", "difference_high"]].tolist() == pytest.approx([0.2] * 3)
    assert line["high"] - line["low"] > 0.2
    rows = {row.title: row.cells for row in tables[1].rows}
    assert rows["HMM"][1].best and rows["F-8"][1].text == "" and not rows["F-8"][1].best


def test_an_oracle_row_is_named_and_never_the_best():
    _, tables = both()
    best = [row.title for row in tables[0].rows for cell in row.cells if cell.best]
    assert best == ["F-8", "F-8"]
    assert all(any(note.startswith("Oracle rows: told.") for note in table.notes) for table in tables[:2])
    assert "A sentence." in tables[0].notes


def test_published_figures_stand_beside_with_the_digits_of_the_paper():
    frame, tables = both()
    assert frame[frame["source"] == PUBLISHED]["mean"].tolist() == [0.7, 10.46]
    (row,) = tables[2].rows
    assert [(cell.text, cell.small) for cell in row.cells] == [("0.70", "± 0.05"), ("10.5", "± 2.2")]
    assert tables[2].title == "Units, as published" and "As printed." in tables[2].notes
    for text in forms.all_forms(frame, tables, "Units"):
        assert "0.70" in text or "0.7\t" in text
    assert len(both(paper=None)[1]) == 2


def test_one_setting_down_and_another_across():
    cells = [stack(f"{letters}-{nodes}", letters, nodes) for letters in ("F", "FF") for nodes in (8, 16)]
    rows = measured(*((cell, statistics(ERRORS + number, 0.5)) for number, cell in enumerate(cells[:3])))
    settings = SelectionSettings(rows=("nets",), metrics=("rmse_first5",), down="letters", across="nodes")
    _, (table,) = both(settings, rows, None)
    assert table.groups == (("8", 1), ("16", 1)) and [row.title for row in table.rows] == ["F", "FF"]
    assert table.rows[1].cells[1].text == "" and table.rows[0].cells[0].best


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"down": "layers"}, "tables.selections.down: layers` must be given together with `across`"),
        ({"down": "a", "across": "b", "intervals": ["corr"]}, "intervals: .* must be left out"),
        ({"metrics": ["corr", "corr"]}, "names each entry once"),
    ],
)
def test_settings_that_do_not_go_together(given, said):
    with pytest.raises(SettingError, match=said):
        SelectionSettings(**given)


def test_the_figures_of_the_paper():
    """Table 3 and 5 of Thangthai et al. (2016): D is the phone DNN, and 3 x 3000 the phone + DV one."""
    tables = published("thangthai2016").selections
    assert tables["frame_features"].figures["D"] == tables["units"].figures["Phoneme DNN"]
    assert tables["layers"].figures["3 x 3000"] == tables["units"].figures["Phoneme + DV DNN"]
    assert len(tables["layers"].figures) == 20


def test_a_published_row_of_another_length_is_refused():
    wrong = {"selections": {"t": {"metrics": ["corr"], "digits": [2], "figures": {"a": [[0.1]]}}}}
    with pytest.raises(
        SettingError, match=r"published/p.yaml: t: a must have mean and deviation for each of 1 measures"
    ):
        published_of(BARE | wrong, "p")
