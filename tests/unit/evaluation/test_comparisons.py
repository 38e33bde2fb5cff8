"""Paired tests: against hand-counted and simulated p values, Holm by definition, and what is called better."""

from itertools import product

import numpy as np
import pandas
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.comparisons import (
    ComparisonSettings,
    compare,
    comparison_sheets,
    holm,
    sign_permutation,
    signed_rank,
)
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP = BootstrapSettings(300, 0.95, 1)


def table(values, corr=0.5):
    columns = {"id": [f"u{i}" for i in range(len(values))], "frames": np.arange(len(values)) + 20}
    columns |= {name: values for name in METRICS}
    return pandas.DataFrame(columns | {"corr": corr, "corr_undefined": 0, "true_scatter": 2.0})


def rows(utterances=30):
    generator = np.random.default_rng(4)
    base = generator.uniform(1, 3, utterances)
    return {
        "worse": table(base + 0.5 + 0.05 * generator.normal(size=utterances)),
        "good": table(base),
        "same": table(base + 0.05 * generator.normal(size=utterances)),
        "worst": table(base + 0.9),
    }


def all_signs(differences):
    """Every change of signs, counted one by one: the exact p values of both statistics."""
    ranks = np.argsort(np.argsort(np.abs(differences))) + 1
    sums, ranked = [], []
    for signs in product((-1, 1), repeat=len(differences)):
        sums.append(abs(np.dot(signs, np.abs(differences))))
        ranked.append(abs(np.dot(signs, ranks)))
    own_sum, own_rank = abs(differences.sum()), abs(np.dot(np.sign(differences), ranks))
    return np.mean(np.array(sums) >= own_sum - 1e-12), np.mean(np.array(ranked) >= own_rank)


@pytest.mark.parametrize("seed", range(4))
def test_p_values_are_those_of_all_changes_of_signs(seed):
    differences = np.random.default_rng(seed).normal(0.4, 1.0, size=9)
    by_sum, by_rank = all_signs(differences)
    assert signed_rank(differences) == pytest.approx(by_rank)
    assert sign_permutation(differences, ComparisonSettings("permutation")) == pytest.approx(by_sum)


def test_no_difference_is_no_finding():
    for p in (signed_rank(np.zeros(8)), sign_permutation(np.zeros(8), ComparisonSettings("permutation"))):
        assert p == 1.0


def test_holm_by_its_definition():
    p = np.array([0.04, 0.001, 0.5, 0.012, 0.03])
    order = sorted(range(5), key=lambda i: p[i])
    slow = [0.0] * 5
    for place, index in enumerate(order):
        slow[index] = min(1.0, max((5 - k) * p[order[k]] for k in range(place + 1)))
    np.testing.assert_allclose(holm(p), slow)
    assert holm(np.array([])).shape == (0,)


def test_holm_keeps_the_error_rate_of_the_family():
    """With every null hypothesis true, a false finding in about one family of twenty."""
    generator = np.random.default_rng(2)
    wrong = [(holm([signed_rank(generator.normal(size=12)) for _ in range(8)]) < 0.05).any() for _ in range(200)]
    assert np.mean(wrong) < 0.05 + 3 * np.sqrt(0.05 * 0.95 / 200)


@pytest.mark.parametrize("test", ["wilcoxon", "permutation"])
def test_real_differences_are_found_and_others_are_not(test):
    frame = compare(rows(), ["rmse_shape"], ComparisonSettings(test, permutations=2000), BOOTSTRAP)
    assert len(frame) == 6
    assert list(dict.fromkeys(frame["first"])) in (["good", "same", "worse"], ["same", "good", "worse"])
    real = {frozenset((line.first, line.second)): line.better for line in frame.itertuples()}
    assert real[frozenset(("good", "same"))] == ""
    assert real[frozenset(("worse", "worst"))] == "worse" and real[frozenset(("good", "worst"))] == "good"
    for line in frame.itertuples():
        figures = [corpus_figure(rows()[row], "rmse_shape") for row in (line.first, line.second)]
        assert (line.first_value, line.second_value) == pytest.approx(figures)
        assert line.low <= line.difference <= line.high and line.difference <= 0
        assert line.p <= line.p_holm


def test_high_is_better_where_it_is():
    found = {"a": table(np.ones(20), np.linspace(0.4, 0.6, 20)), "b": table(np.ones(20), np.linspace(0.5, 0.8, 20))}
    frame = compare(found, ["corr", "variance_kept"], None, BOOTSTRAP)
    assert list(frame["first"])[0] == "b" and frame["better"][0] == "b"
    assert frame["p"][1] == 1.0 and frame["better"][1] == ""


def test_same_answer_again():
    settings = ComparisonSettings("permutation", seed=5, permutations=500)
    pandas.testing.assert_frame_equal(
        compare(rows(), ["corr", "rmse_texture"], settings, BOOTSTRAP),
        compare(rows(), ["corr", "rmse_texture"], settings, BOOTSTRAP),
    )


def test_sheets_count_and_say_what_they_cannot():
    settings = ComparisonSettings()
    frame = compare(rows(), ["rmse_shape"], settings, BOOTSTRAP)
    (sheet,) = comparison_sheets(frame, 30, settings)
    cells = {name: [cell.text for cell in line] for name, line in sheet.rows}
    assert cells["worst"][3:] == ["0", "3"] and cells["worse"][3:] == ["1", "2"]
    assert "all 6 pairs" in sheet.notes[0] and len(sheet.notes) == 1
    few = comparison_sheets(compare(rows(6), ["rmse_shape"], settings, BOOTSTRAP), 6, settings)[0]
    assert "nothing can be significant" in few.notes[1]


def test_mistakes_are_named():
    with pytest.raises(DataError, match="`b` was evaluated on other utterances"):
        compare({"a": table(np.ones(4)), "b": table(np.ones(5))}, ["corr"])
    for wrong in ({"test": "t"}, {"level": 0.0}, {"permutations": 3}):
        with pytest.raises(SettingError, match="tables.comparison"):
            ComparisonSettings(**wrong)
