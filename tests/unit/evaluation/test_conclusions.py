"""The sentence about a system: what is chosen, and what is called better."""

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import BASELINES, hmm, stack, statistics
from tests.unit.evaluation.test_across_systems import lips
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.conclusions import BETTER, UNDECIDED, WORSE, choose, conclude
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.models.rows import ModelRow

BOOTSTRAP = BootstrapSettings(100)
HMM = hmm("hmm_mge", "MGE-trained HMM")
MEAN = BASELINES["training_mean"]


def of(errors):
    """Lip statistics of utterances of 40 frames whose lip distance is given for each."""
    table = pandas.concat([lips(0.5)] * -(-len(errors) // 8), ignore_index=True)[: len(errors)]
    errors = np.asarray(errors, float)
    return table.assign(id=[f"u{i}" for i in range(len(errors))], frames=40.0, lip_distance_sum=40 * errors)


def found(rows, validation, test, **settings):
    """The conclusion from errors on validation (name -> error), and on the test utterances (name -> errors)."""
    statistics_of = {name: statistics(np.full(3, error)) for name, error in validation.items()}
    measured = MeasuredRows(tuple(rows), {row.name: of(test[row.name]) for row in rows})
    return conclude(rows, statistics_of, measured, ComparisonSettings(**settings), BOOTSTRAP)


NOISE = np.linspace(-0.1, 0.1, 12)
ROWS = [stack("FBB-64", "FBB", 64), stack("FFF-64", "FFF", 64), HMM, MEAN]


def test_the_model_is_chosen_on_validation_and_not_on_test():
    test = {"FBB-64": 1.0 + NOISE, "FFF-64": 0.2 + NOISE, "hmm_mge": 1.5 + NOISE, "training_mean": 3.0 + NOISE}
    one = found(ROWS, {"FBB-64": 0.5, "FFF-64": 0.6, "hmm_mge": 0.7}, test)
    assert one.choice.ranked == ("FBB-64", "FFF-64", "hmm_mge")
    assert (one.choice.best, one.choice.reference, one.choice.baseline) == ("FBB-64", "hmm_mge", "training_mean")
    assert one.text.startswith("FBB-64 is the best of 3 models on the validation utterances (lowest RMSE(appearance)).")
    assert "On the 12 test utterances its lips are on average 1.00 % [0.9" in one.text
    assert one.best.value == pytest.approx(1.0)


def test_better_needs_figure_and_test():
    test = {"FBB-64": 1.0 + NOISE, "FFF-64": 1.2 + NOISE, "hmm_mge": 0.5 + NOISE, "training_mean": 3.0 + 2 * NOISE}
    one = found(ROWS, {"FBB-64": 0.5, "FFF-64": 0.6, "hmm_mge": 0.7}, test)
    assert [(versus.row, versus.verdict) for versus in one.versus] == [("training_mean", BETTER), ("hmm_mge", WORSE)]
    assert "better than the Training mean (3.00 %, p < 0.001)" in one.text
    assert "worse than the MGE-trained HMM (0.50 %, p < 0.001)" in one.text


def test_a_figure_without_its_test_is_not_better():
    mixed = np.where(np.arange(12) % 2, 0.4, -0.3)
    test = {"FBB-64": 1.0 + NOISE, "FFF-64": 2.0 + NOISE, "hmm_mge": 1.0 + NOISE + mixed, "training_mean": 3.0 + NOISE}
    one = found(ROWS, {"FBB-64": 0.5, "FFF-64": 0.6, "hmm_mge": 0.7}, test)
    assert one.versus[1].own.value > one.best.value and one.versus[1].verdict == UNDECIDED
    assert "not significantly different from the MGE-trained HMM" in one.text and one.text.count("better") == 1


def test_a_test_that_disagrees_with_the_figure_is_not_better():
    # Most utterances favour the HMM by a little; a long tail makes its figure the worse one.
    far = np.r_[np.full(60, -0.01), np.full(4, 5.0)]
    base = 1.0 + np.linspace(0, 0.1, 64)
    test = {"FBB-64": base, "FFF-64": base + 1, "hmm_mge": base + far, "training_mean": base + 2}
    one = found(ROWS, {"FBB-64": 0.5, "FFF-64": 0.6, "hmm_mge": 0.7}, test)
    versus = one.versus[1]
    assert versus.p < 0.05 and versus.own.value > one.best.value and versus.verdict == UNDECIDED


def test_too_few_utterances_for_any_difference_are_said():
    test = {"FBB-64": [1.0, 1.1, 1.2, 1.0], "FFF-64": [2.0] * 4, "hmm_mge": [2.0] * 4, "training_mean": [3.0] * 4}
    one = found(ROWS, {"FBB-64": 0.5, "FFF-64": 0.6, "hmm_mge": 0.7}, test)
    assert {versus.verdict for versus in one.versus} == {UNDECIDED}
    assert one.text.endswith("With 4 utterances no difference can be significant.")


def test_the_reference_of_an_hmm_is_a_network_and_seeds_are_one_model():
    rows = [stack("FBB-64", "FBB", 64), stack("FBB-64-s2", "FBB", 64, 2), HMM, MEAN]
    test = {row.name: 1.0 + NOISE for row in rows}
    one = found(rows, {"FBB-64": 0.5, "FBB-64-s2": 0.9, "hmm_mge": 0.6}, test)
    assert one.choice.ranked == ("hmm_mge", "FBB-64") and one.choice.reference == "FBB-64"
    assert "MGE-trained HMM is the best of 2 models" in one.text
    assert "not significantly different from FBB-64 (1.00 %" in one.text


def test_oracles_and_baselines_are_not_chosen():
    oracle = ModelRow("dv", "oracle DV", "dnn", role="oracle")
    tables = {
        name: statistics(np.full(3, error)) for name, error in (("FBB-64", 0.5), ("dv", 0.1), ("training_mean", 0))
    }
    choice = choose([stack("FBB-64", "FBB", 64), oracle, MEAN], tables)
    assert choice.ranked == ("FBB-64",) and choice.reference == ""


def test_a_system_without_models_or_lips_still_has_a_sentence():
    rows = [stack("FBB-64", "FBB", 64), MEAN]
    assert found([MEAN], {}, {"training_mean": 1.0 + NOISE}).choice is None
    tables = {row.name: of(1.0 + NOISE).drop(columns="lip_distance_sum") for row in rows}
    measured = MeasuredRows(tuple(rows), tables)
    one = conclude(rows, {"FBB-64": statistics(np.ones(3))}, measured, ComparisonSettings(), BOOTSTRAP)
    assert one.text == "FBB-64 is the only model. Its lips cannot be compared with the recorded ones."
    assert choose(rows, {"FBB-64": statistics(np.full(3, np.nan))}) is None
