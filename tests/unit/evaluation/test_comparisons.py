"""Paired tests: against hand-counted and simulated p values, Holm by definition, and what is called better."""

from itertools import product

import numpy as np
import pandas
import pytest

from tests.unit.evaluation.examples import measured, stack, statistics
from visualspeech.errors import SettingError
from visualspeech.evaluation.comparisons import (
    ComparisonSettings,
    compare,
    comparison_tables,
    exchange_test,
    holm,
    signed_rank,
)
from visualspeech.evaluation.metrics import METRICS, corpus_figure, statistics_of
from visualspeech.evaluation.statistics import BootstrapSettings

BOOTSTRAP = BootstrapSettings(300, 0.95, 1)


def of(tables):
    return measured(*((stack(name, "FBB", 128, cell=name), table) for name, table in tables.items()))


def rows(utterances=30):
    generator = np.random.default_rng(4)
    base = generator.uniform(1, 3, utterances)
    return of(
        {
            "worse": statistics(base + 0.5 + 0.05 * generator.normal(size=utterances)),
            "good": statistics(base),
            "same": statistics(base + 0.05 * generator.normal(size=utterances)),
            "worst": statistics(base + 0.9),
        }
    )


def all_signs(differences):
    """Every change of signs, counted one by one: the exact p values of both statistics."""
    ranks = np.argsort(np.argsort(np.abs(differences))) + 1
    sums, ranked = [], []
    for signs in product((-1, 1), repeat=len(differences)):
        sums.append(abs(np.dot(signs, np.abs(differences))))
        ranked.append(abs(np.dot(signs, ranks)))
    own_sum, own_rank = abs(differences.sum()), abs(np.dot(np.sign(differences), ranks))
    return np.mean(np.array(sums) >= own_sum - 1e-12), np.mean(np.array(ranked) >= own_rank)


def exchanged(metric, first, second):
    """Every exchange of utterances between two rows, counted one by one: twice the smaller tail."""
    found = []
    for swaps in product((False, True), repeat=len(first)):
        swap = np.array(swaps)[:, None]
        rows = np.where(swap, second, first), np.where(swap, first, second)
        figures = [metric.cost(float(metric.value(one.sum(axis=0)))) for one in rows]
        found.append(figures[0] - figures[1])
    own, found = found[0], np.array(found)
    return min(1.0, 2 * min(np.mean(found >= own - 1e-12), np.mean(found <= own + 1e-12)))


@pytest.mark.parametrize("seed", range(4))
def test_p_values_are_those_of_all_changes_of_signs(seed):
    differences = np.random.default_rng(seed).normal(0.4, 1.0, size=9)
    by_sum, by_rank = all_signs(differences)
    assert signed_rank(differences).p == pytest.approx(by_rank)
    assert signed_rank(-differences) == (signed_rank(differences).p, -signed_rank(differences).direction)
    # The same through the figures of two rows: an exchange of an utterance changes the sign of its difference.
    frames = np.full(9, 20.0)
    first, second = np.column_stack([3 + differences, frames]), np.column_stack([np.full(9, 3.0), frames])
    found = exchange_test(METRICS["rmse_shape"], first, second, ComparisonSettings("permutation"))
    assert found == (pytest.approx(by_sum), np.sign(differences.sum()))


@pytest.mark.parametrize("name", ["gv_ratio", "ccc"])
@pytest.mark.parametrize("seed", range(3))
def test_what_is_no_sum_over_utterances_is_tested_as_the_figure_of_the_corpus(name, seed):
    generator = np.random.default_rng(seed)
    tables = [statistics(np.ones(8), generator.uniform(0.2, 0.9, 8), generator.uniform(0.2, 1.6, 8)) for _ in range(2)]
    both = [statistics_of(table, METRICS[name]) for table in tables]
    found = exchange_test(METRICS[name], *both, ComparisonSettings(permutations=300))
    assert found.p == pytest.approx(exchanged(METRICS[name], *both))
    figures = [METRICS[name].cost(corpus_figure(table, name)) for table in tables]
    assert found.direction == np.sign(figures[0] - figures[1])


def test_a_variance_that_is_wrong_by_turns_is_not_better_than_a_steady_one():
    """.4 and 1.6 by turns are 1 over the corpus, farther from 1 in each utterance than a steady .8."""
    turns = statistics(np.ones(40), gv=np.resize([0.4, 1.6], 40))
    steady = statistics(np.ones(40), gv=0.8)
    (line,) = compare(of({"turns": turns, "steady": steady}), ["gv_ratio"], None, BOOTSTRAP).itertuples()
    assert (line.first, line.first_value, line.second_value) == ("turns", pytest.approx(1), pytest.approx(0.8))
    assert line.better == "" and line.p > 0.01
    # A ratio that is better in every utterance is better.
    (line,) = compare(
        of({"steady": steady, "low": statistics(np.ones(40), gv=np.linspace(0.5, 0.6, 40))}),
        ["gv_ratio"],
        None,
        BOOTSTRAP,
    ).itertuples()
    assert line.better == "steady" and line.p < 0.001


def test_figure_and_test_must_agree_in_direction():
    """A little better in most utterances and much worse in some: ranks and sums point in opposite directions."""
    base = np.linspace(2, 3, 60)
    mostly = np.where(np.arange(60) < 48, base - 0.1, base + 2.0)
    (line,) = compare(
        of({"mostly": statistics(mostly), "base": statistics(base)}), ["rmse_shape"], None, BOOTSTRAP
    ).itertuples()
    assert (line.first, line.second) == ("base", "mostly")
    assert line.p < 0.05 and line.better == ""


def test_no_difference_is_no_finding():
    same = statistics_of(statistics(np.linspace(1, 2, 8)), METRICS["rmse_shape"])
    assert (
        signed_rank(np.zeros(8)) == exchange_test(METRICS["rmse_shape"], same, same, ComparisonSettings()) == (1.0, 0)
    )


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
    wrong = [(holm([signed_rank(generator.normal(size=12)).p for _ in range(8)]) < 0.05).any() for _ in range(200)]
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
        figures = [corpus_figure(rows().tables[row], "rmse_shape") for row in (line.first, line.second)]
        assert (line.first_value, line.second_value) == pytest.approx(figures)
        assert line.low <= line.difference <= line.high and line.difference <= 0
        assert line.p <= line.p_holm


def test_high_is_better_where_it_is():
    corr = {"a": np.linspace(0.4, 0.6, 20), "b": np.linspace(0.5, 0.8, 20)}
    found = of({name: statistics(np.ones(20), values) for name, values in corr.items()})
    frame = compare(found, ["corr", "ccc", "gv_ratio"], None, BOOTSTRAP)
    assert list(frame["first"])[:2] == ["b", "b"] and list(frame["better"]) == ["b", "b", ""]
    assert frame["p"][2] == 1.0


def test_the_floor_is_left_out_and_seeds_are_one_row():
    base = np.linspace(1, 2, 12)
    found = measured(
        (stack("FBB-128", "FBB", 128), statistics(base)),
        (stack("FBB-128-s2", "FBB", 128, seed=2), statistics(base + 0.2)),
        ("training_mean", statistics(base + 1)),
        ("floor", statistics(0 * base)),
    )
    (line,) = compare(found, ["rmse_shape"], None, BOOTSTRAP).itertuples()
    assert (line.first, line.second) == ("FBB-128", "training_mean")
    assert line.first_value == pytest.approx(np.average(base + 0.1, weights=np.arange(12) + 20))


def test_same_answer_again():
    settings = ComparisonSettings("permutation", seed=5, permutations=500)
    pandas.testing.assert_frame_equal(
        compare(rows(), ["corr", "rmse_texture"], settings, BOOTSTRAP),
        compare(rows(), ["corr", "rmse_texture"], settings, BOOTSTRAP),
    )


def test_tables_count_and_say_what_they_cannot():
    settings = ComparisonSettings()
    frame = compare(rows(), ["rmse_shape"], settings, BOOTSTRAP)
    (sheet,) = comparison_tables(frame, rows(), settings)
    cells = {row.title: [cell.text for cell in row.cells] for row in sheet.rows}
    assert cells["worst"][3:] == ["0", "3"] and cells["worse"][3:] == ["1", "2"]
    assert "all 6 pairs" in sheet.notes[0] and len(sheet.notes) == 2
    few = comparison_tables(compare(rows(6), ["rmse_shape"], settings, BOOTSTRAP), rows(6), settings)[0]
    assert "no difference can be significant" in few.notes[2]


def test_mistakes_are_named():
    for wrong in ({"test": "t"}, {"level": 0.0}, {"permutations": 3}):
        with pytest.raises(SettingError, match="tables.comparison"):
            ComparisonSettings(**wrong)
