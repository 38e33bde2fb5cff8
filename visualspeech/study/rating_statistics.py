"""Statistics of a rating test: means, Cronbach's alpha, analysis of variance and pairwise comparisons.

Sadoughi and Busso (2017), section 5.2, compare the conditions by a one-way analysis of variance of all ratings and by
pairwise comparisons. Both take all ratings as independent, although each participant rates every condition. Tests that
do not, stand beside them: Friedman's test, and sign-flip tests of the participants' means.
"""

import warnings
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.comparisons import holm
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.participants_statistics import NO_INTERVAL, Interval, bootstrap_interval, sign_flip_test


@dataclass(frozen=True)
class Ratings:
    """Answers to one question of a rating test.

    Parameters
    ----------
    participants, conditions : their names
    condition : shape (stimuli,), integers: the condition that each stimulus shows
    values : shape (participants, stimuli), NaN where a participant did not rate a stimulus

    Raises
    ------
    DataError
        The shape is another one, or there are fewer than two conditions with ratings.
    """

    participants: tuple[str, ...]
    conditions: tuple[str, ...]
    condition: np.ndarray
    values: np.ndarray

    def __post_init__(self) -> None:
        if np.shape(self.values) != (len(self.participants), len(self.condition)):
            raise DataError(
                f"ratings of shape {np.shape(self.values)} do not belong to {len(self.participants)} participants and "
                f"{len(self.condition)} stimuli."
            )
        empty = [name for name, own in zip(self.conditions, self.groups(), strict=True) if not len(own)]
        if empty or len(self.conditions) < 2:
            raise DataError(
                f"there is no rating of {', '.join(empty)}." if empty else "one condition alone cannot be compared."
            )

    def groups(self) -> list[np.ndarray]:
        """All ratings of each condition."""
        own = (np.asarray(self.values)[:, np.asarray(self.condition) == one] for one in range(len(self.conditions)))
        return [values[np.isfinite(values)] for values in own]

    def sums(self) -> tuple[np.ndarray, np.ndarray]:
        """Sum and number of the ratings that a participant gave a condition, (participants, conditions) each."""
        members = np.eye(len(self.conditions))[np.asarray(self.condition)]
        known = np.isfinite(self.values)
        return np.where(known, self.values, 0.0) @ members, known @ members


@dataclass(frozen=True)
class Mean:
    """The ratings of one condition.

    Parameters
    ----------
    condition : name
    ratings : their number
    value, deviation : mean and sample standard deviation over all ratings
    independent : interval of the mean by Student's t, which takes all ratings as independent
    clustered : percentile bootstrap interval over participants
    """

    condition: str
    ratings: int
    value: float
    deviation: float
    independent: Interval
    clustered: Interval


@dataclass(frozen=True)
class Omnibus:
    """A test of all conditions; NaN where it is not defined.

    Parameters
    ----------
    statistic : F or chi-squared
    freedom : degrees of freedom
    p : value
    """

    statistic: float
    freedom: tuple[int, ...]
    p: float


@dataclass(frozen=True)
class Pair:
    """Comparison of two conditions; ``difference`` is first minus second, of the means over all ratings.

    Parameters
    ----------
    first, second : numbers of the conditions
    interval : simultaneous interval of the difference by Tukey's test
    p_tukey : Tukey's honestly significant difference, Tukey-Kramer for unequal numbers (all ratings as independent)
    p_participants : sign-flip test of the participants' differences, Holm-corrected over the pairs
    """

    first: int
    second: int
    difference: float
    interval: Interval
    p_tukey: float
    p_participants: float


@dataclass(frozen=True)
class Alpha:
    """Agreement of the participants: Cronbach's alpha (1951); NaN where it is not defined.

    Parameters
    ----------
    value : alpha, participants as the items of the test, stimuli as its cases
    raters, stimuli : numbers of those that it is computed from
    """

    value: float
    raters: int
    stimuli: int


@dataclass(frozen=True)
class Rated:
    """The evaluation of one question."""

    means: tuple[Mean, ...]
    alpha: Alpha
    anova: Omnibus
    friedman: Omnibus
    pairs: tuple[Pair, ...]
    complete: int
    """Participants who rated every condition, on whom Friedman's and the sign-flip tests rest."""


def evaluate_ratings(ratings: Ratings, settings: EvaluationSettings | None = None) -> Rated:
    """Means, agreement and tests of one question of a rating test."""
    settings = settings or EvaluationSettings()
    groups, (sums, counts) = ratings.groups(), ratings.sums()
    complete = (counts > 0).all(axis=1)
    own = sums[complete] / counts[complete]
    means = tuple(
        _mean(name, group, sums[:, number], counts[:, number], settings)
        for number, (name, group) in enumerate(zip(ratings.conditions, groups, strict=True))
    )
    return Rated(
        means=means,
        alpha=cronbach_alpha(np.asarray(ratings.values)),
        anova=one_way_anova(groups),
        friedman=friedman_test(own),
        pairs=compare_pairs(groups, own, settings),
        complete=len(own),
    )


def _mean(name: str, group: np.ndarray, sums: np.ndarray, counts: np.ndarray, settings: EvaluationSettings) -> Mean:
    rated = counts > 0
    return Mean(
        condition=name,
        ratings=len(group),
        value=float(group.mean()),
        deviation=float(group.std(ddof=1)) if len(group) > 1 else np.nan,
        independent=t_interval(group, settings.level),
        clustered=bootstrap_interval(sums[rated], counts[rated], settings),
    )


def t_interval(values: np.ndarray, level: float) -> Interval:
    """Student's interval of a mean; none for fewer than two values."""
    from scipy.stats import sem, t

    if len(values) < 2:
        return NO_INTERVAL
    reach = float(sem(values)) * float(t.ppf((1 + level) / 2, len(values) - 1))
    return Interval(float(values.mean()) - reach, float(values.mean()) + reach)


def cronbach_alpha(values: np.ndarray) -> Alpha:
    """Cronbach's alpha of raters (Cronbach 1951, Eq. 2): k / (k - 1) (1 - sum of rater variances / variance of sums).

    Parameters
    ----------
    values : shape (raters, stimuli); only raters of all stimuli that anyone rated count, as alpha needs all ratings
    """
    values = values[:, np.isfinite(values).any(axis=0)]
    values = values[np.isfinite(values).all(axis=1)]
    raters, stimuli = values.shape
    if raters < 2 or stimuli < 2:
        return Alpha(np.nan, raters, stimuli)
    whole = values.sum(axis=0).var(ddof=1)
    if whole <= 0:
        return Alpha(np.nan, raters, stimuli)
    own = values.var(axis=1, ddof=1).sum()
    return Alpha(float(raters / (raters - 1) * (1 - own / whole)), raters, stimuli)


def one_way_anova(groups: list[np.ndarray]) -> Omnibus:
    """One-way analysis of variance of all ratings; undefined if no ratings of a condition differ."""
    from scipy.stats import f_oneway

    freedom = (len(groups) - 1, sum(map(len, groups)) - len(groups))
    if freedom[1] < 1 or not any(np.ptp(group) for group in groups):
        return Omnibus(np.nan, freedom, np.nan)
    found = f_oneway(*groups)
    return Omnibus(float(found.statistic), freedom, float(found.pvalue))


def friedman_test(means: np.ndarray) -> Omnibus:
    """Friedman's test (1937) of the participants' means, (participants, conditions), of three or more conditions."""
    from scipy.stats import friedmanchisquare

    freedom = (means.shape[1] - 1,)
    # Rounded, so that equal means are ties; otherwise rounding errors would rank them.
    means = np.round(means, 10)
    if means.shape[1] < 3 or len(means) < 2 or not np.ptp(means, axis=1).any():
        return Omnibus(np.nan, freedom, np.nan)
    found = friedmanchisquare(*means.T)
    return Omnibus(float(found.statistic), freedom, float(found.pvalue))


def compare_pairs(groups: list[np.ndarray], means: np.ndarray, settings: EvaluationSettings) -> tuple[Pair, ...]:
    """All pairs of conditions, by Tukey's test of the ratings and by sign-flip tests of the participants' means.

    Parameters
    ----------
    groups : all ratings of each condition
    means : of the participants who rated every condition, shape (participants, conditions)
    """
    chosen = list(combinations(range(len(groups)), 2))
    p_tukey, low, high = _tukey(groups, settings.level)
    flipped = holm([sign_flip_test(np.round(means[:, one] - means[:, two], 10), settings) for one, two in chosen])
    return tuple(
        Pair(
            first=one,
            second=two,
            difference=float(groups[one].mean() - groups[two].mean()),
            interval=Interval(float(low[one, two]), float(high[one, two])),
            p_tukey=float(p_tukey[one, two]),
            p_participants=float(p),
        )
        for (one, two), p in zip(chosen, flipped, strict=True)
    )


def _tukey(groups: list[np.ndarray], level: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P values, lower and upper ends of Tukey's test, (conditions, conditions) each; NaN where it is not defined."""
    from scipy.stats import tukey_hsd

    if min(map(len, groups)) < 2 or not any(np.ptp(group) for group in groups):
        return (np.full((len(groups), len(groups)), np.nan),) * 3
    with warnings.catch_warnings():
        # A condition whose ratings are all equal is no concern: the variance is pooled.
        warnings.simplefilter("ignore", RuntimeWarning)
        found = tukey_hsd(*groups)
        ends = found.confidence_interval(level)
    return found.pvalue, ends.low, ends.high
