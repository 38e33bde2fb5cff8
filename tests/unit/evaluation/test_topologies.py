"""Table 1: what is marked, what is a ratio to what, and that the published figures are the paper's."""

import numpy as np
import pandas
import pytest

from visualspeech.errors import DataError
from visualspeech.evaluation import sheets as forms
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.repetitions import mean_and_deviation, pooled
from visualspeech.evaluation.topologies import (
    agreement,
    is_collapsed,
    stand_in,
    topology_frame,
    topology_sheets,
)

PAPER = published("fan2015")


def measured(rmse, corr, utterances=5):
    frames = np.arange(10, 10 + utterances)
    columns = {"id": [f"u{i}" for i in range(utterances)], "frames": frames}
    for name in METRICS:
        columns[name] = rmse * (1 + 0.1 * np.arange(utterances))
    columns |= {"corr": np.full(utterances, corr), "corr_undefined": 0, "true_scatter": 2.0}
    return pandas.DataFrame(columns)


def tables():
    return {
        "FBB-128": measured(0.7, 0.75),
        "FFF-128": measured(0.999, 0.02),
        "FBB-256": measured(0.72, 0.74),
        "FBB-128-s2": measured(0.8, 0.70),
        "FFF-128-s2": measured(0.8, 0.5),
        "training_mean": measured(1.0, 0.01),
        "hmm_tied": measured(0.75, 0.7),
    }


def cell(frame, source, topology, nodes, metric):
    found = frame.query("source == @source and topology == @topology and nodes == @nodes and metric == @metric")
    assert len(found) == 1
    return found.iloc[0]


def test_published_table_is_whole_and_its_best_cell_is_the_papers():
    assert len(PAPER.topologies) == 24 and {nodes for _, nodes in PAPER.topologies} == set(PAPER.nodes)
    assert {stack for stack, _ in PAPER.topologies} == {stack for stack in PAPER.stacks if len(stack) == 3}
    frame = topology_frame({"training_mean": measured(1.0, 0.0)}, PAPER)
    best = frame[frame["best"]]
    assert set(best["metric"]) == set(PAPER.metrics)
    assert set(zip(best["topology"], best["nodes"], strict=True)) == {("FBB", 128)}
    assert PAPER.systems["deep BLSTM"] == PAPER.topologies["FBB", 128]
    assert sum(PAPER.preference.values()) == pytest.approx(1)


def test_published_cells_that_collapsed_are_those_without_correlation():
    frame = topology_frame({"training_mean": measured(1.0, 0.0)}, PAPER)
    flat = {cell for cell, figures in PAPER.topologies.items() if abs(figures["corr"]) < 0.1}
    part = frame[frame["collapsed"] > 0]
    assert set(zip(part["topology"], part["nodes"], strict=True)) == flat and len(flat) == 7
    # A collapsed network is one constant: their errors agree, and those of the others do not.
    errors = [PAPER.topologies[one]["rmse_appearance"] for one in flat]
    assert np.ptp(errors) / np.median(errors) < 1 / 300
    assert stand_in(PAPER)["rmse_appearance"] == pytest.approx(np.median(errors))
    assert cell(frame, "published", "FBB", 128, "rmse_appearance")["ratio"] == pytest.approx(
        156.502 / 213.312, rel=1e-3
    )


def test_a_constant_prediction_is_collapsed_and_a_poor_one_is_not():
    """By the second route: figures of a real constant prediction, of noise about it, and of half the truth."""
    generator = np.random.default_rng(0)
    truth = generator.normal(size=(400, 12)) * np.linspace(3, 0.5, 12)

    def figures(predicted):
        rmse = np.sqrt(((predicted - truth) ** 2).mean(axis=1)).mean()
        return np.mean([np.corrcoef(a, b)[0, 1] for a, b in zip(predicted, truth, strict=True)]), rmse

    mean = figures(np.tile(truth.mean(axis=0) + 1e-3, (400, 1)))[1]
    constant = np.tile(truth.mean(axis=0) + 0.02 * generator.normal(size=12), (400, 1))
    for predicted, expected in ((constant, True), (0.3 * truth + 0.01 * constant, False)):
        corr, rmse = figures(predicted)
        assert is_collapsed(corr, rmse / mean) is expected


def test_seeds_are_averaged_and_collapsed_ones_counted():
    frame = topology_frame(tables())
    row = cell(frame, "ours", "FBB", 128, "rmse_appearance")
    scale = np.average(1 + 0.1 * np.arange(5), weights=np.arange(10, 15))
    assert (row["value"], row["deviation"]) == pytest.approx((0.75 * scale, scale * 0.1 / np.sqrt(2)))
    assert (row["ratio"], row["ratio_deviation"]) == pytest.approx((0.75, 0.1 / np.sqrt(2)))
    assert (row["seeds"], row["collapsed"], row["best"]) == (2, 0, False)
    assert cell(frame, "ours", "FFF", 128, "corr")["collapsed"] == 1
    lone = cell(frame, "ours", "FBB", 256, "rmse_shape")
    assert lone["best"] and np.isnan(lone["deviation"])
    assert np.isnan(cell(frame, "ours", "FBB", 128, "corr")["ratio"])
    assert "hmm_tied" not in set(frame["topology"])


def test_pooled_rows_are_means_by_utterance():
    rows = pooled(tables())
    assert list(rows) == ["FBB-128", "FFF-128", "FBB-256", "training_mean", "hmm_tied"]
    np.testing.assert_allclose(rows["FBB-128"]["corr"], 0.725)
    figure, _ = mean_and_deviation([tables()["FBB-128"], tables()["FBB-128-s2"]], "rmse_shape")
    assert np.average(rows["FBB-128"]["rmse_shape"], weights=rows["FBB-128"]["frames"]) == pytest.approx(figure)
    other = tables() | {"FBB-128-s2": measured(1, 1, utterances=4)}
    with pytest.raises(DataError, match="different utterances"):
        pooled(other)


def test_agreement_is_of_ranks():
    same = {
        f"{stack}-{nodes}": measured(f["rmse_appearance"] / 300, 0.5) for (stack, nodes), f in PAPER.topologies.items()
    }
    frame = topology_frame(same | {"training_mean": measured(1.0, 0.0)}, PAPER)
    assert agreement(frame) == (pytest.approx(1.0), 17)
    assert np.isnan(agreement(topology_frame(tables(), PAPER))[0])


def test_layout_is_the_papers_in_every_form():
    frame = topology_frame(tables(), PAPER)
    made = topology_sheets(frame, (("corpus", "demo"),), PAPER)
    assert [sheet.groups for sheet in made[:2]] == [(("128", 4), ("256", 4)), (("128", 3), ("256", 3))]
    assert [name for name, _ in made[0].rows] == ["FBB", "FFF"]
    assert [name for name, _ in made[2].rows] == ["BBB", "BBF", "BFB", "BFF", "FBB", "FBF", "FFB", "FFF"]
    assert made[2].groups == (("128", 4), ("256", 4), ("512", 4))
    text = forms.to_markdown(made)
    assert "**156.502**" in text and "*213.354†*" in text and "0.734" in text
    assert "(1 of 2 seeds)" in text and "± 0.0" in text
    assert all(sign in forms.to_latex(made) for sign in (r"\textbf{156.502}", r"\multicolumn{4}{c}{512}", r"$\pm$"))
    page = forms.to_html_page(made, "Topologies")
    assert '<th scope="colgroup" colspan="4">512</th>' in page and "<strong>156.502</strong>" in page
    assert "<em>213.354†</em>" in page and "http" not in page


def test_the_training_mean_is_asked_for():
    with pytest.raises(DataError, match="training_mean"):
        topology_frame({"FBB-128": measured(1.0, 0.5)})
