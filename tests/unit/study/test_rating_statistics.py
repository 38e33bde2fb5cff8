"""Rating statistics against sums of squares, Hoyt's reliability, ranks by hand, and values of other packages."""

import numpy as np
import pytest
from scipy import stats

from visualspeech.errors import DataError
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.rating_statistics import (
    Ratings,
    compare_pairs,
    cronbach_alpha,
    evaluate_ratings,
    friedman_test,
    one_way_anova,
    t_interval,
)

FAST = EvaluationSettings(samples=500, permutations=500)


def ratings(values, condition, names="abcde"):
    values, condition = np.asarray(values, float), np.asarray(condition)
    people = tuple(f"p{i}" for i in range(len(values)))
    return Ratings(people, tuple(names[: condition.max() + 1]), condition, values)


def drawn(people=20, conditions=5, turns=10, seed=0):
    """Ratings of participants who differ; the first condition is rated higher."""
    generator = np.random.default_rng(seed)
    condition = np.repeat(np.arange(conditions), turns)
    mean = 5 + 2.0 * (condition == 0) + generator.normal(0, 1, (people, 1))
    return ratings(np.clip(np.rint(generator.normal(mean, 1.5, (people, len(condition)))), 1, 10), condition)


def test_anova_by_sums_of_squares():
    groups = drawn(seed=1).groups()
    every = np.concatenate(groups)
    between = sum(len(one) * (one.mean() - every.mean()) ** 2 for one in groups)
    within = sum(((one - one.mean()) ** 2).sum() for one in groups)
    expected = (between / 4) / (within / (len(every) - 5))
    found = one_way_anova(groups)
    assert found.statistic == pytest.approx(expected) and found.freedom == (4, len(every) - 5)
    assert found.p == pytest.approx(stats.f.sf(expected, 4, len(every) - 5))


def test_alpha_is_hoyts_reliability():
    """Hoyt (1941): one less the mean square of the residuals, divided by that of the stimuli, in a two-way layout."""
    values = drawn(people=7, seed=2).values
    raters, stimuli = values.shape
    rows, columns, mean = values.mean(axis=1, keepdims=True), values.mean(axis=0, keepdims=True), values.mean()
    between = raters * ((columns - mean) ** 2).sum() / (stimuli - 1)
    residual = ((values - rows - columns + mean) ** 2).sum() / ((stimuli - 1) * (raters - 1))
    found = cronbach_alpha(values)
    assert found.value == pytest.approx(1 - residual / between)
    assert (found.raters, found.stimuli) == (raters, stimuli)


def test_alpha_of_another_package():
    """Three raters of ten stimuli; the value is of pingouin 0.7.0 (``cronbach_alpha``)."""
    items = np.array([[1, 2, 2, 3, 3, 4, 4, 5, 5, 5], [2, 1, 2, 3, 4, 3, 5, 4, 5, 4], [1, 1, 3, 2, 4, 4, 3, 5, 4, 5.0]])
    assert cronbach_alpha(items).value == pytest.approx(0.9157667387)


@pytest.mark.parametrize("copies", [2, 5])
def test_raters_who_agree_and_who_do_not(copies):
    own = np.random.default_rng(0).normal(size=30)
    assert cronbach_alpha(np.tile(own, (copies, 1))).value == pytest.approx(1)
    noise = np.random.default_rng(1).normal(size=(copies, 20_000))
    assert abs(cronbach_alpha(noise).value) < 0.1


def test_alpha_needs_ratings_that_vary_and_are_complete():
    values = drawn(people=6, seed=3).values
    holes = np.vstack([values, np.where(np.arange(50) == 3, np.nan, values[:1])])
    found = cronbach_alpha(holes)
    assert found.raters == 6 and found.value == pytest.approx(cronbach_alpha(values).value)
    nobody = np.hstack([values, np.full((6, 1), np.nan)])
    assert cronbach_alpha(nobody).stimuli == 50
    for flat in (np.full((4, 10), 5.0), values[:1], values[:, :1]):
        assert np.isnan(cronbach_alpha(flat).value)


def test_tukey_by_the_studentised_range_and_holm_by_hand():
    given = drawn(seed=4)
    groups, (sums, counts) = given.groups(), given.sums()
    found = compare_pairs(groups, sums / counts, FAST)
    size, freedom = len(groups[0]), sum(map(len, groups)) - 5
    pooled = sum(((one - one.mean()) ** 2).sum() for one in groups) / freedom
    for pair in found:
        difference = groups[pair.first].mean() - groups[pair.second].mean()
        spread = np.sqrt(pooled / size)
        assert pair.difference == pytest.approx(difference)
        assert pair.p_tukey == pytest.approx(stats.studentized_range.sf(abs(difference) / spread, 5, freedom), abs=1e-6)
        reach = stats.studentized_range.ppf(0.95, 5, freedom) * spread
        assert (pair.interval.low, pair.interval.high) == pytest.approx(
            (difference - reach, difference + reach), abs=1e-4
        )
    assert [(pair.first, pair.second) for pair in found[:5]] == [(0, 1), (0, 2), (0, 3), (0, 4), (1, 2)]
    # 500 draws: the smallest p value is 2 / 501, and Holm multiplies the four smallest by 10.
    assert {round(pair.p_participants, 6) for pair in found[:4]} == {round(20 / 501, 6)}


def test_the_example_of_another_package():
    """Fixed ratings; the values are of statsmodels 0.15.0 (``pairwise_tukeyhsd``, ``anova_oneway``)."""
    groups = [np.array([8, 9, 7, 8, 9.0]), np.array([5, 6, 4, 6, 5.0]), np.array([5, 7, 6, 6, 4.0])]
    found = compare_pairs(groups, np.array([one for one in zip(*groups, strict=True)]), FAST)
    assert [pair.p_tukey for pair in found] == pytest.approx([0.00083421, 0.00258534, 0.78669267], abs=1e-6)
    anova = one_way_anova(groups)
    assert (anova.statistic, anova.p) == pytest.approx((14.7407407407, 0.000586086780))


def test_friedman_by_ranks():
    means = np.random.default_rng(5).permuted(np.tile([1.0, 2.0, 3.0, 4.0], (9, 1)), axis=1)
    ranks = stats.rankdata(means, axis=1)
    expected = 12 / (9 * 4 * 5) * (ranks.sum(axis=0) ** 2).sum() - 3 * 9 * 5
    found = friedman_test(means)
    assert found.statistic == pytest.approx(expected) and found.p == pytest.approx(stats.chi2.sf(expected, 3))
    assert np.isnan(friedman_test(means[:, :2]).p) and np.isnan(friedman_test(means[:1]).p)
    assert np.isnan(friedman_test(np.ones((5, 3))).p)


def test_means_and_their_intervals():
    given = drawn(people=4, conditions=2, turns=3, seed=6)
    found = evaluate_ratings(given, FAST).means[1]
    own = given.values[:, 3:].ravel()
    low, high = stats.t.interval(0.95, len(own) - 1, own.mean(), own.std(ddof=1) / np.sqrt(len(own)))
    assert (found.value, found.deviation, found.ratings) == pytest.approx((own.mean(), own.std(ddof=1), 12))
    assert (found.independent.low, found.independent.high) == pytest.approx((low, high))
    people = given.values[:, 3:].mean(axis=1)
    assert people.min() <= found.clustered.low <= found.value <= found.clustered.high <= people.max()
    assert np.isnan(t_interval(np.array([3.0]), 0.95).low)


def test_missing_ratings_count_for_nobody():
    """A participant without a rating of one condition is left out of tests over participants, not of the means."""
    values = drawn(people=5, conditions=3, turns=2, seed=7).values
    values[4, 4:] = np.nan
    found = evaluate_ratings(ratings(values, [0, 0, 1, 1, 2, 2]), FAST)
    assert found.complete == 4 and [mean.ratings for mean in found.means] == [10, 10, 8]
    assert found.alpha.raters == 4
    without = evaluate_ratings(ratings(values[:4], [0, 0, 1, 1, 2, 2]), FAST)
    assert found.friedman == without.friedman and found.anova != without.anova


def test_ratings_without_variance_have_no_tests():
    found = evaluate_ratings(ratings(np.full((4, 6), 5.0), [0, 0, 1, 1, 2, 2]), FAST)
    assert np.isnan([found.alpha.value, found.anova.p, found.friedman.p, *(one.p_tukey for one in found.pairs)]).all()
    assert {one.p_participants for one in found.pairs} == {1.0} and found.means[0].value == 5
    # One condition always 9, the others always 3: still no variance within a condition.
    apart = evaluate_ratings(ratings(np.tile([9.0, 9, 3, 3, 3, 3], (4, 1)), [0, 0, 1, 1, 2, 2]), FAST)
    assert np.isnan(apart.anova.p) and apart.pairs[0].difference == 6 and apart.alpha.value == pytest.approx(1)


def test_one_participant():
    found = evaluate_ratings(ratings(drawn(people=1, seed=8).values, np.repeat(np.arange(5), 10)), FAST)
    assert np.isnan(found.alpha.value) and np.isnan(found.friedman.p) and np.isfinite(found.anova.p)
    assert np.isnan(found.means[0].clustered.low) and {one.p_participants for one in found.pairs} == {1.0}


def test_impossible_ratings():
    with pytest.raises(DataError, match="do not belong"):
        ratings(np.ones((2, 3)), [0, 1])
    with pytest.raises(DataError, match="no rating of b"):
        ratings([[1.0, np.nan]], [0, 1])
    with pytest.raises(DataError, match="one condition alone"):
        ratings([[1.0, 2.0]], [0, 0])


def test_the_recorded_motion_is_found_and_nothing_else():
    """The result of Sadoughi and Busso (2017, Fig. 6): the first condition is higher than all others."""
    found = evaluate_ratings(drawn(seed=9), EvaluationSettings(samples=500, permutations=5000))
    assert found.anova.p < 0.001 and found.friedman.p < 0.001
    for pair in found.pairs:
        assert (pair.p_tukey < 0.01) == (pair.p_participants < 0.01) == (pair.first == 0)


def test_tests_over_participants_keep_their_level_where_anova_does_not():
    """Each participant has favourites of his own, on average no condition is better: ANOVA of all ratings finds one."""
    generator = np.random.default_rng(10)
    anova = friedman = 0
    for _ in range(200):
        own = generator.normal(0, 1.5, (12, 4))
        values = np.repeat(own, 10, axis=1) + generator.normal(0, 1, (12, 40))
        given = ratings(values, np.repeat(np.arange(4), 10))
        anova += one_way_anova(given.groups()).p < 0.05
        friedman += friedman_test(values.reshape(12, 4, 10).mean(axis=2)).p < 0.05
    assert friedman < 0.1 * 200 < 0.5 * 200 < anova
