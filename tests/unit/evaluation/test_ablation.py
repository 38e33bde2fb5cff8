"""The ablation table: paired differences within rows, and what is shown of them."""

import numpy as np
import pytest

from tests.unit.evaluation.examples import hmm, measured, stack, statistics
from visualspeech.evaluation import forms
from visualspeech.evaluation.ablation import COLUMNS, ablation_frame, ablation_tables
from visualspeech.evaluation.latex import to_latex
from visualspeech.evaluation.metrics import corpus_figure
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP, METRICS = BootstrapSettings(400, 0.95, 1), ("rmse_appearance", "corr")
ROWS = {"FBB-128": ("FBB-128-thirds", "FBB-128"), "tied HMM": ("hmm_tied", "hmm_tied_states")}
HEADINGS = ("phone times", "state times")


def found():
    generator = np.random.default_rng(1)
    errors = generator.uniform(1, 3, 40)
    return measured(
        (stack("FBB-128-thirds", "FBB", 128, cell="FBB-128-thirds"), statistics(errors + 0.1, 0.6)),
        (stack("FBB-128", "FBB", 128), statistics(errors, 0.5)),
        (stack("FBB-128-s2", "FBB", 128, 2), statistics(errors - 0.2, 0.5)),
        (hmm("hmm_tied", "tied"), statistics(errors, 0.5)),
        (hmm("hmm_tied_states", "tied with times"), statistics(errors + 0.01 * generator.normal(size=40), 0.5)),
    )


def frame():
    return ablation_frame(found(), HEADINGS, ROWS, METRICS, BOOTSTRAP)


def test_differences_are_paired_and_seeds_pooled():
    table = frame()
    assert tuple(table.columns) == COLUMNS and len(table) == 8
    lines = table.set_index(["row", "column", "metric"])
    network = lines.loc["FBB-128", "state times", "rmse_appearance"]
    assert network["model"] == "FBB-128"
    # The errors of the two seeds are lower by .1 and .3 in every utterance: seeds are all of the uncertainty.
    assert network[["difference", "difference_low", "difference_high"]].tolist() == pytest.approx([-0.2, -0.3, -0.1])
    corr = lines.loc["FBB-128", "state times", "corr"]
    assert corr[["difference", "difference_low", "difference_high"]].tolist() == pytest.approx([-0.1] * 3)
    tables = found().tables
    for column, model in zip(HEADINGS, ROWS["tied HMM"], strict=True):
        line = lines.loc["tied HMM", column, "rmse_appearance"]
        assert line["value"] == pytest.approx(corpus_figure(tables[model], "rmse_appearance"))
    first = lines.xs("phone times", level="column")
    assert not first[["difference", "difference_low", "difference_high"]].to_numpy().any()
    hmms = lines.loc["tied HMM", "state times", "rmse_appearance"]
    assert hmms["difference_low"] < hmms["difference"] < hmms["difference_high"]


def test_layout():
    made = ablation_tables(frame(), found(), (("corpus", "demo"),), BOOTSTRAP, 2)
    assert [row.title for row in made[0].rows] == [
        "FBB-128", "phone times", "state times", "state times minus phone times",
        "tied HMM", "phone times", "state times", "state times minus phone times",
    ]  # fmt: skip
    difference = made[0].rows[3].cells
    assert [(cell.text, cell.small, cell.best) for cell in difference] == [
        ("-0.20", "[-0.30, -0.10]", True),
        ("-0.10", "[-0.10, -0.10]", True),
    ]
    assert not made[0].rows[7].cells[0].best and not made[0].rows[7].cells[1].best
    text = forms.to_markdown(made)
    assert "**-0.20**" in text and "corpus" in text and "excludes 0" in text and "over utterances and seeds" in text
    assert to_latex(made).count(r"\begin{table}") == 1 and "Ablation" in forms.to_html_page(made, "Ablation")
