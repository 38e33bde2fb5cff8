"""Table 1: what is marked, what is a ratio to what, and that the published figures are the paper's."""

import numpy as np
import pytest

from tests.unit.evaluation.examples import hmm, measured, stack, statistics
from visualspeech.errors import DataError
from visualspeech.evaluation import forms
from visualspeech.evaluation.latex import to_latex
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.topologies import (
    MIN_CORRELATION,
    MIN_VARIANCE,
    agreement,
    inferred_training_mean,
    is_collapsed,
    topology_frame,
    topology_tables,
)

PAPER = published("fan2015")
FRAMES = np.arange(10, 15)


def of(rmse, corr, gv=0.5):
    return statistics(rmse * (1 + 0.1 * np.arange(5)), corr, gv, frames=FRAMES)


MEAN = measured(("training_mean", of(1.0, 0.0)))


def rows():
    return measured(
        (stack("FBB-128", "FBB", 128), of(0.7, 0.75)),
        (stack("FFF-128", "FFF", 128), of(0.999, 0.4, 0.001)),
        (stack("FBB-256", "FBB", 256), of(0.72, 0.74)),
        (stack("FBB-128-s2", "FBB", 128, 2), of(0.8, 0.70)),
        (stack("FFF-128-s2", "FFF", 128, 2), of(0.8, 0.5)),
        ("training_mean", of(1.0, 0.01)),
        (hmm("hmm_tied", "Tied-state triphone HMM"), of(0.75, 0.7)),
    )


def frame_of(found=None, paper=None):
    return topology_frame(found or rows(), PAPER.metrics, paper)


def cell(frame, source, topology, nodes, metric):
    found = frame.query("source == @source and topology == @topology and nodes == @nodes and metric == @metric")
    assert len(found) == 1
    return found.iloc[0]


def test_published_table_is_whole_and_its_best_cell_is_the_papers():
    assert len(PAPER.topologies) == 24 and {nodes for _, nodes in PAPER.topologies} == set(PAPER.nodes)
    assert {stack for stack, _ in PAPER.topologies} == {stack for stack in PAPER.stacks if len(stack) == 3}
    frame = frame_of(MEAN, PAPER)
    best = frame[frame["best"]]
    assert set(best["metric"]) == set(PAPER.metrics)
    assert set(zip(best["topology"], best["nodes"], strict=True)) == {("FBB", 128)}
    assert PAPER.gains[PAPER.best] == PAPER.topologies["FBB", 128]
    assert sum(PAPER.preference.values()) == pytest.approx(1)


def test_published_cells_that_collapsed_are_those_without_correlation():
    frame = frame_of(MEAN, PAPER)
    flat = {cell for cell, figures in PAPER.topologies.items() if abs(figures["corr"]) < 0.1}
    part = frame[frame["collapsed"] > 0]
    assert set(zip(part["topology"], part["nodes"], strict=True)) == flat and len(flat) == 7
    # A collapsed network is one constant: their errors agree, and those of the others do not.
    errors = [PAPER.topologies[one]["rmse_appearance"] for one in flat]
    assert np.ptp(errors) / np.median(errors) < 1 / 300
    assert inferred_training_mean(PAPER)["rmse_appearance"] == pytest.approx(np.median(errors))
    assert cell(frame, "published", "FBB", 128, "rmse_appearance")["ratio"] == pytest.approx(
        156.502 / 213.312, rel=1e-3
    )


def test_a_constant_prediction_is_collapsed_and_a_poor_one_is_not():
    """By the second route: figures of a real constant prediction, of one that hardly moves, and of some truth."""
    generator = np.random.default_rng(0)
    truth = generator.normal(size=(400, 12)) * np.linspace(3, 0.5, 12)
    truth -= truth.mean(axis=0)

    def figures(predicted):
        rmse = np.sqrt(((predicted - truth) ** 2).mean(axis=1)).mean()
        return np.mean([np.corrcoef(a, b)[0, 1] for a, b in zip(predicted, truth, strict=True)]), rmse

    mean = figures(1e-9 * generator.normal(size=truth.shape))[1]
    still = 0.02 * generator.normal(size=12)
    for predicted, expected in ((np.tile(still, (400, 1)), True), (0.3 * truth, False)):
        corr, rmse = figures(predicted)
        assert is_collapsed(corr, MIN_CORRELATION, rmse / mean) is expected
    # What is centred correlates however little it moves, so its variance decides.
    for predicted, expected in ((0.01 * truth, True), (0.3 * truth, False)):
        corr, rmse = figures(predicted)
        assert corr == pytest.approx(1)
        assert is_collapsed(predicted.var() / truth.var(), MIN_VARIANCE, rmse / mean) is expected


def test_seeds_are_averaged_and_collapsed_ones_counted():
    frame = frame_of()
    row = cell(frame, "run", "FBB", 128, "rmse_appearance")
    scale = np.average(1 + 0.1 * np.arange(5), weights=np.arange(10, 15))
    assert (row["value"], row["deviation"]) == pytest.approx((0.75 * scale, scale * 0.1 / np.sqrt(2)))
    assert (row["ratio"], row["ratio_deviation"]) == pytest.approx((0.75, 0.1 / np.sqrt(2)))
    assert (row["seeds"], row["collapsed"], row["best"]) == (2, 0, False)
    assert cell(frame, "run", "FFF", 128, "corr")["collapsed"] == 1
    lone = cell(frame, "run", "FBB", 256, "rmse_shape")
    assert lone["best"] and np.isnan(lone["deviation"])
    assert np.isnan(cell(frame, "run", "FBB", 128, "corr")["ratio"])
    assert "hmm_tied" not in set(frame["topology"])


def test_agreement_is_of_ranks():
    same = [
        (stack(f"{letters}-{nodes}", letters, nodes), of(figures["rmse_appearance"] / 300, 0.5))
        for (letters, nodes), figures in PAPER.topologies.items()
    ]
    # The same topologies reversed, in a second group: they do not count.
    other = [(stack(f"x{i}", "FBB", 128, group="other", cell=f"x{i}"), of(2.0, 0.5)) for i in range(2)]
    frame = frame_of(measured(*same, *other, ("training_mean", of(1.0, 0.0))), PAPER)
    assert agreement(frame) == (pytest.approx(1.0), 17)
    assert np.isnan(agreement(frame_of(None, PAPER))[0])


def test_layout_is_the_papers_in_every_form():
    made = topology_tables(frame_of(None, PAPER), rows(), (("corpus", "demo"),), PAPER)
    assert [table.groups for table in made[:2]] == [(("128", 4), ("256", 4)), (("128", 3), ("256", 3))]
    assert [row.title for row in made[0].rows] == ["FBB", "FFF"]
    assert dict(made[0].facts) == {
        "corpus": "demo", "input blocks": "tri", "nodes of a B layer count": "one direction",
    }  # fmt: skip
    assert [row.title for row in made[2].rows] == ["BBB", "BBF", "BFB", "BFF", "FBB", "FBF", "FFB", "FFF"]
    assert made[2].groups == (("128", 4), ("256", 4), ("512", 4))
    text = forms.to_markdown(made)
    assert "**156.502**" in text and "*213.354†*" in text and "0.734" in text
    assert "(1 of 2 seeds)" in text and "± 0.0" in text
    assert all(sign in to_latex(made) for sign in (r"\textbf{156.502}", r"\multicolumn{4}{c}{512}", r"$\pm$"))
    page = forms.to_html_page(made, "Topologies")
    assert '<th scope="colgroup" colspan="4">512</th>' in page and "<strong>156.502</strong>" in page
    assert "<em>213.354†</em>" in page and "http" not in page


def test_each_group_has_a_table_and_a_best_cell_of_its_own():
    enriched = stack("FBB-128-enriched", "FBB", 128, group="enriched", reads=("tri", "stress"), cell="FBB-128-enriched")
    found = measured(*((row, rows().tables[row.name]) for row in rows().rows), (enriched, of(0.6, 0.8)))
    frame = topology_frame(found, ["rmse_shape", "gv_ratio"])
    made = topology_tables(frame, found, (("corpus", "demo"),))
    titles = [table.title for table in made]
    assert titles == [
        "Networks by topology and nodes: nets",
        "Networks by topology and nodes: nets: ratio to the training mean",
        "Networks by topology and nodes: enriched",
        "Networks by topology and nodes: enriched: ratio to the training mean",
    ]
    assert dict(made[2].facts)["input blocks"] == "tri, stress" and "corpus" not in dict(made[2].facts)
    assert made[0].rows[0].cells[2].best and made[2].rows[0].cells[0].best


def test_the_training_mean_is_asked_for():
    with pytest.raises(DataError, match="training_mean"):
        frame_of(measured((stack("FBB-128", "FBB", 128), of(1.0, 0.5))))
