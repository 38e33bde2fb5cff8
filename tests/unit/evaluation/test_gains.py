"""Table 3: who is chosen by what, and that gains are paired."""

import numpy as np
import pytest

from tests.unit.evaluation.examples import hmm, measured, stack, statistics
from visualspeech.errors import DataError
from visualspeech.evaluation import forms
from visualspeech.evaluation.comparisons import ComparisonSettings, holm, signed_rank
from visualspeech.evaluation.gains import best_cell, gains_frame, gains_tables, rows_of_gains
from visualspeech.evaluation.latex import to_latex
from visualspeech.evaluation.metrics import METRICS, corpus_figure, statistics_of
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.statistics import BootstrapSettings

PAPER = published("fan2015")
BOOTSTRAP = BootstrapSettings(400, 0.95, 1)
REFERENCES = ("hmm_tied", "hmm_mge")


def everything():
    generator = np.random.default_rng(1)
    errors = generator.uniform(1, 3, 40)
    corr = generator.uniform(0.5, 0.7, 40)
    return measured(
        (stack("FBB-128", "FBB", 128), statistics(0.95 * errors, corr + 0.05)),
        (stack("FFF-128", "FFF", 128), statistics(0.9 * errors, corr + 0.05)),
        ("training_mean", statistics(2 * errors, 0 * corr)),
        (hmm("hmm_tied", "Tied-state triphone HMM"), statistics(1.1 * errors, corr - 0.1)),
        (hmm("hmm_mge", "MGE-trained HMM"), statistics(errors, corr + 0.05 + 0.2 * generator.normal(size=40))),
    )


def rows():
    return rows_of_gains(everything(), "FBB-128", REFERENCES)


def frame_of(paper=PAPER, found=None):
    return gains_frame(found or rows(), "FBB-128", PAPER.metrics, paper, None, BOOTSTRAP)


def test_validation_chooses_among_the_candidates():
    candidates = [
        stack("FBB-128", "FBB", 128), stack("FBB-128-s2", "FBB", 128, 2), stack("BFF-128", "BFF", 128),
        stack("FFF-128", "FFF", 128),
    ]  # fmt: skip
    errors = {"FBB-128": 0.5, "FBB-128-s2": 0.3, "BFF-128": 0.39}
    tables = {name: statistics(np.full(3, value), 0.9 - value) for name, value in errors.items()}
    assert best_cell(candidates, tables) == "BFF-128"
    tables["BFF-128"] = tables["BFF-128"].assign(rmse_appearance_sum=1000.0)
    assert best_cell(candidates, tables) == "FBB-128" and best_cell(candidates, tables, "corr") == "BFF-128"
    del tables["BFF-128"]
    assert best_cell(candidates, tables) == "FBB-128"
    with pytest.raises(DataError, match="no candidate"):
        best_cell(candidates, {})


def test_rows_are_the_references_and_the_best_cell():
    assert [row.name for row in rows().rows] == ["FBB-128", "hmm_tied", "hmm_mge"]
    with pytest.raises(DataError, match="no reference"):
        rows_of_gains(everything(), "FBB-128", ())


def test_gains_are_paired():
    frame = frame_of()
    run = frame[frame["source"] == "run"].set_index(["row", "metric"])
    assert list(dict.fromkeys(run.index.get_level_values(0))) == ["hmm_tied", "hmm_mge", "FBB-128"]
    # The network's error is 5 % lower in every utterance: the pair has no uncertainty at all, each row has much.
    row = run.loc["hmm_mge", "rmse_appearance"]
    assert (row["gain"], row["gain_low"], row["gain_high"]) == pytest.approx((0.05,) * 3)
    assert row["high"] - row["low"] > 0.2
    assert run.loc["hmm_tied", "rmse_shape"]["gain"] == pytest.approx(1 - 0.95 / 1.1)
    tables = rows().tables
    assert run.loc["hmm_mge", "corr"]["gain"] == pytest.approx(
        corpus_figure(tables["FBB-128"], "corr") - corpus_figure(tables["hmm_mge"], "corr")
    )
    assert np.isnan(run.loc["FBB-128", "corr"]["gain"])


def test_p_values_are_corrected_over_all_gains():
    frame, tables = frame_of(None), rows().tables
    own = []
    for row in REFERENCES:
        for metric in PAPER.metrics:
            network, reference = (
                METRICS[metric].value(statistics_of(tables[name], METRICS[metric])) for name in ("FBB-128", row)
            )
            own.append(signed_rank(network - reference).p)
    np.testing.assert_allclose(frame["p"].dropna(), own)
    np.testing.assert_allclose(frame["p_holm"].dropna(), holm(np.array(own)))


def test_the_published_gain_is_the_papers():
    frame = frame_of()
    gain = frame[(frame["source"] == "published") & (frame["row"] == "HMM")].set_index("metric")["gain"]
    assert gain["rmse_appearance"] == pytest.approx(0.0659, abs=1e-4) and gain["corr"] == pytest.approx(0.065)


def test_seeds_are_one_row():
    found = everything()
    second = stack("FBB-128-s2", "FBB", 128, seed=2)
    more = measured(*((row, found.tables[row.name]) for row in found.rows), (second, found.tables["FFF-128"]))
    frame = frame_of(None, rows_of_gains(more, "FBB-128", REFERENCES)).set_index(["row", "metric"])
    assert frame.loc["hmm_mge", "rmse_shape"]["gain"] == pytest.approx(1 - (0.95 + 0.9) / 2)


def test_layout():
    made = gains_tables(frame_of(), rows(), "FBB-128", (("corpus", "demo"),), PAPER, ComparisonSettings())
    assert [row.title for row in made[0].rows] == [
        "Tied-state triphone HMM",
        "MGE-trained HMM",
        "Best network (FBB-128)",
    ]
    assert [row.title for row in made[2].rows] == ["HMM", "deep BLSTM"]
    text = forms.to_markdown(made)
    assert "**5.0%** \\[5.0%, 5.0%\\]" in text and "**1.122**" in text
    assert "6.6%" in text and "lowest centred RMSE(appearance) on the validation" in text
    assert to_latex(made).count(r"\begin{table}") == 4 and "http" not in forms.to_html_page(made, "Table 3")
    assert len(gains_tables(frame_of(None), rows(), "FBB-128", (), None, ComparisonSettings())) == 2


def test_a_gain_is_significant_only_where_the_test_agrees():
    base = np.linspace(2, 3, 60)
    mostly = np.where(np.arange(60) < 48, base - 0.1, base + 2.0)
    found = measured(
        (stack("FBB-128", "FBB", 128), statistics(mostly)),
        (hmm("hmm_tied", "Tied"), statistics(base)),
        (hmm("hmm_mge", "MGE"), statistics(base + 1.0)),
    )
    frame = gains_frame(found, "FBB-128", ["rmse_shape"], None, None, BOOTSTRAP).set_index("row")
    assert frame.loc["hmm_tied", "gain"] < 0 and frame.loc["hmm_tied", "p_holm"] < 0.05
    assert frame.loc["hmm_tied", "significant"] == 0 and frame.loc["hmm_mge", "significant"] == 1
