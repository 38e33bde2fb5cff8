"""Preference statistics against sums of binomial probabilities, enumerated permutations, and many simulated studies."""

from itertools import product
from math import comb

import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.participants_statistics import bootstrap_interval, sign_flip_test, smallest_p
from visualspeech.study.preference_statistics import (
    FIRST,
    MISSING,
    NEITHER,
    SECOND,
    Choices,
    evaluate_preference,
    exact_interval,
    sign_test,
)

#: Fan et al. (2015), Fig. 4.
PUBLISHED = np.array([0.615, 0.155, 0.230])
FAST = EvaluationSettings(samples=500, permutations=500)


def choices(answers):
    answers = np.asarray(answers)
    people, items = answers.shape
    return Choices(tuple(f"p{i}" for i in range(people)), tuple(f"s{i}" for i in range(items)), answers)


def tail(low, high, total, share):
    """Probability of a count from ``low`` to ``high`` inclusive."""
    return sum(comb(total, k) * share**k * (1 - share) ** (total - k) for k in range(low, high + 1))


@pytest.mark.parametrize(("count", "total", "level"), [(123, 200, 0.95), (31, 200, 0.95), (0, 12, 0.95), (7, 9, 0.9)])
def test_exact_intervals_are_where_a_tail_reaches_half_of_the_rest(count, total, level):
    """The definition of Clopper and Pearson (1934)."""
    found, rest = exact_interval(count, total, level), (1 - level) / 2
    if count:
        assert tail(count, total, total, found.low) == pytest.approx(rest, rel=1e-6)
    else:
        assert found.low == 0
    assert tail(0, count, total, found.high) == pytest.approx(rest, rel=1e-6)


def test_the_exact_interval_of_the_published_share():
    """statsmodels 0.15.0: ``proportion_confint(123, 200, method="beta")``."""
    found = exact_interval(123, 200, 0.95)
    assert (found.low, found.high) == pytest.approx((0.5437613072, 0.6827754746), abs=1e-9)
    nothing = exact_interval(0, 0, 0.95)
    assert (nothing.low, nothing.high) == (0, 1)


@pytest.mark.parametrize(("first", "decided"), [(123, 169), (5, 10), (0, 5), (10, 10), (3, 4)])
def test_the_sign_test_sums_both_tails(first, decided):
    far = max(first, decided - first)
    assert sign_test(first, decided) == pytest.approx(min(1, 2 * tail(far, decided, decided, 0.5)))
    assert sign_test(0, 0) == 1


def test_sign_flips_are_enumerated_for_few_participants():
    values = np.array([3.0, 1.0, -2.0, 4.0, 0.0, 2.5])
    means = [np.mean(values * signs) for signs in product((-1, 1), repeat=len(values))]
    expected = np.mean(np.abs(means) >= abs(values.mean()) - 1e-12)
    assert sign_flip_test(values, EvaluationSettings()) == pytest.approx(expected)
    assert sign_flip_test(np.ones(8), EvaluationSettings()) == pytest.approx(smallest_p(8, EvaluationSettings()))
    many = np.ones(40)
    assert sign_flip_test(many, EvaluationSettings()) == pytest.approx(smallest_p(40, EvaluationSettings()))
    assert sign_flip_test(np.zeros(5), EvaluationSettings()) == sign_flip_test(np.ones(1), EvaluationSettings()) == 1
    assert np.isnan(sign_flip_test(np.zeros(0), EvaluationSettings()))


def test_bootstrap_intervals_are_quantiles_of_drawn_participants():
    """Two participants: four equally likely samples, whose shares are 1/4, 1/2 (twice) and 3/4."""
    found = bootstrap_interval(np.array([1, 3]), np.array([4, 4]), EvaluationSettings())
    assert (found.low, found.high) == (0.25, 0.75)
    half = bootstrap_interval(np.array([1, 3]), np.array([4, 4]), EvaluationSettings(level=0.3))
    assert (half.low, half.high) == (0.5, 0.5)
    assert np.isnan(bootstrap_interval(np.array([1]), np.array([4]), EvaluationSettings()).low)


def test_a_hand_counted_study():
    """Four participants, three sentences; one answer is missing."""
    found = evaluate_preference(
        choices([[FIRST, FIRST, SECOND], [FIRST, NEITHER, SECOND], [FIRST, SECOND, MISSING], [SECOND, FIRST, NEITHER]]),
        FAST,
    )
    assert [share.count for share in found.shares] == [5, 2, 4] and {share.total for share in found.shares} == {11}
    assert found.decided.count == 5 and found.decided.total == 9 and found.participants == 4
    assert found.p == pytest.approx(2 * sum(comb(9, k) for k in range(5, 10)) / 2**9)
    # Differences of the shares: 1/3, 0, 0, 0; half of the sign patterns are as extreme on either side.
    assert found.p_participants == 1
    votes = found.majority
    assert votes.counts.tolist() == [[3, 0, 1], [2, 1, 1], [0, 1, 2]]
    assert votes.winners.tolist() == [FIRST, FIRST, SECOND]
    assert (votes.won(FIRST), votes.won(NEITHER), votes.won(SECOND)) == (2, 0, 1)
    assert votes.p == pytest.approx(1.0)


def test_ties_and_unanswered_items():
    found = evaluate_preference(choices([[FIRST, MISSING, FIRST], [SECOND, MISSING, NEITHER]]), FAST)
    assert found.majority.items == ("s0", "s2") and found.majority.winners.tolist() == [NEITHER, FIRST]
    assert found.majority.p == 1


def test_nobody_prefers_anything():
    found = evaluate_preference(choices(np.full((3, 4), NEITHER)), FAST)
    assert found.p == found.p_participants == found.majority.p == 1
    assert found.decided.total == 0 and np.isnan(found.decided.value)
    assert found.shares[NEITHER].value == 1 and found.majority.won(NEITHER) == 4


def test_one_participant_has_no_interval_over_participants():
    found = evaluate_preference(choices([[FIRST, FIRST, SECOND]]), FAST)
    assert found.shares[FIRST].value == pytest.approx(2 / 3) and np.isnan(found.shares[FIRST].clustered.low)
    assert found.p_participants == 1


@pytest.mark.parametrize(
    ("answers", "message"),
    [(np.full((2, 2), MISSING), "no answer"), (np.array([[7]]), "none of first"), (np.zeros((2, 0), int), "no answer")],
)
def test_impossible_answers(answers, message):
    with pytest.raises(DataError, match=message):
        choices(answers)
    with pytest.raises(DataError, match="do not belong"):
        Choices(("a",), ("b", "c"), np.zeros((2, 1), int))


def test_the_published_preference_is_recovered():
    """20 participants with 10 sentences each; the shares lie in their intervals."""
    answers = np.random.default_rng(2015).choice(3, size=(20, 10), p=PUBLISHED)
    found = evaluate_preference(choices(answers), FAST)
    for share, true in zip(found.shares, PUBLISHED, strict=True):
        assert share.exact.low < true < share.exact.high and share.clustered.low < true < share.clustered.high
    assert found.p < 0.001 and found.p_participants < 0.01


def test_exact_intervals_cover_the_published_shares():
    """Of 20,000 simulated studies of 200 answers at least 95 % of the intervals hold the share, and not nearly all."""
    counts = np.random.default_rng(1).multinomial(200, PUBLISHED, size=20_000)
    ends = np.array([(one.low, one.high) for one in (exact_interval(k, 200, 0.95) for k in range(201))])
    low, high = np.moveaxis(ends[counts], -1, 0)
    covered = ((low <= PUBLISHED) & (high >= PUBLISHED)).mean(axis=0)
    assert (covered > 0.95).all() and (covered < 0.98).all()


def test_participants_who_differ_need_intervals_over_participants():
    """Participants with preferences of their own: exact intervals are too narrow."""
    generator, exact, clustered = np.random.default_rng(3), 0, 0
    studies, settings = 200, EvaluationSettings(samples=400)
    for _ in range(studies):
        own = generator.dirichlet(PUBLISHED * 2, size=20)
        counts = np.array([generator.multinomial(10, shares)[0] for shares in own])
        one = exact_interval(int(counts.sum()), 200, 0.95)
        other = bootstrap_interval(counts, np.full(20, 10), settings)
        exact += one.low <= PUBLISHED[0] <= one.high
        clustered += other.low <= PUBLISHED[0] <= other.high
    assert exact < 0.8 * studies < 0.88 * studies < clustered


def test_the_sign_flip_test_keeps_its_level_where_the_binomial_test_does_not():
    """No preference on average, but each participant has one: the level of 5 % holds over participants alone."""
    generator, exact, flipped = np.random.default_rng(4), 0, 0
    studies, settings = 200, EvaluationSettings(permutations=400)
    for _ in range(studies):
        first = generator.binomial(10, generator.beta(0.5, 0.5, size=16))
        exact += sign_test(int(first.sum()), 160) < 0.05
        flipped += sign_flip_test((2.0 * first - 10) / 10, settings) < 0.05
    assert flipped < 0.1 * studies < 0.3 * studies < exact
