"""Table 3: who is chosen by what, and that gains are paired."""

import numpy as np
import pandas
import pytest

from visualspeech.errors import DataError
from visualspeech.evaluation import sheets as forms
from visualspeech.evaluation.comparisons import ComparisonSettings, holm, signed_rank
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.evaluation.published_results import published
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.systems import best_network, system_frame, system_sheets

PAPER = published("fan2015")
BOOTSTRAP = BootstrapSettings(400, 0.95, 1)
ERRORS = [name for name, metric in METRICS.items() if metric.best == "low"]


def table(values, corr):
    frame = pandas.DataFrame({"id": [f"u{i}" for i in range(len(values))], "frames": 20 + np.arange(len(values))})
    return frame.assign(**{name: values for name in ERRORS}, corr=corr, variance_kept=1.0, true_scatter=1.0)


def tables():
    generator = np.random.default_rng(1)
    hmm = generator.uniform(1, 3, 40)
    corr = generator.uniform(0.5, 0.7, 40)
    return {
        "FBB-128": table(0.95 * hmm, corr + 0.05),
        "training_mean": table(2 * hmm, 0 * corr),
        "hmm_tied": table(1.1 * hmm, corr - 0.1),
        "hmm_mge": table(hmm, corr + 0.05 + 0.2 * generator.normal(size=40)),
    }


def test_validation_chooses_among_networks_with_a_b():
    curves = {
        "FFF-128": [0.1, 0.2], "FBB-128": [0.9, 0.5], "FBB-128-s2": [0.8, 0.3], "BFF-128": [0.39, 0.6],
        "FBB-128-rich": [0.1], "hmm_mge": [0.0],
    }  # fmt: skip
    frames = {name: pandas.DataFrame({"validation": values}) for name, values in curves.items()}
    assert best_network(frames) == "BFF-128"
    del frames["BFF-128"]
    assert best_network(frames) == "FBB-128"
    with pytest.raises(DataError, match="networks.stacks"):
        best_network({"FFF-128": frames["FFF-128"]})


def test_gains_are_paired():
    frame = system_frame(tables(), "FBB-128", PAPER, None, BOOTSTRAP)
    ours = frame[frame["source"] == "ours"].set_index(["system", "metric"])
    assert set(ours.index.get_level_values(0)) == {"hmm_tied", "hmm_mge", "FBB-128"}
    # The network's error is 5 % lower in every utterance: the pair has no uncertainty at all, each row has much.
    row = ours.loc["hmm_mge", "rmse_appearance"]
    assert (row["gain"], row["gain_low"], row["gain_high"]) == pytest.approx((0.05,) * 3)
    assert row["high"] - row["low"] > 0.2
    assert ours.loc["hmm_tied", "rmse_shape"]["gain"] == pytest.approx(1 - 0.95 / 1.1)
    assert ours.loc["hmm_mge", "corr"]["gain"] == pytest.approx(
        corpus_figure(tables()["FBB-128"], "corr") - corpus_figure(tables()["hmm_mge"], "corr")
    )
    assert np.isnan(ours.loc["FBB-128", "corr"]["gain"])


def test_p_values_are_corrected_over_all_gains():
    frame = system_frame(tables(), "FBB-128", None, None, BOOTSTRAP)
    own = [
        signed_rank((tables()["FBB-128"][metric] - tables()[system][metric]).to_numpy())
        for system in ("hmm_tied", "hmm_mge")
        for metric in ("rmse_shape", "rmse_texture", "rmse_appearance", "corr")
    ]
    np.testing.assert_allclose(frame["p"].dropna(), own)
    np.testing.assert_allclose(frame["p_holm"].dropna(), holm(np.array(own)))


def test_the_published_gain_is_the_papers():
    frame = system_frame(tables(), "FBB-128", PAPER, None, BOOTSTRAP)
    gain = frame[(frame["source"] == "published") & (frame["system"] == "HMM")].set_index("metric")["gain"]
    assert gain["rmse_appearance"] == pytest.approx(0.0659, abs=1e-4) and gain["corr"] == pytest.approx(0.065)


def test_layout():
    frame = system_frame(tables(), "FBB-128", PAPER, None, BOOTSTRAP)
    made = system_sheets(frame, "FBB-128", (("corpus", "demo"),), PAPER, ComparisonSettings())
    assert [name for name, _ in made[2].rows] == ["HMM", "deep BLSTM"]
    text = forms.to_markdown(made)
    assert "deep BLSTM (FBB-128)" in text and "**5.0%** \\[5.0%, 5.0%\\]" in text and "**1.122**" in text
    assert "6.6%" in text and "lowest error on the validation" in text
    assert forms.to_latex(made).count(r"\begin{table}") == 4 and "http" not in forms.to_html_page(made, "Table 3")


def test_other_utterances_are_named():
    wrong = tables() | {"hmm_mge": tables()["hmm_mge"].iloc[:-1]}
    with pytest.raises(DataError, match="different utterances"):
        system_frame(wrong, "FBB-128")
