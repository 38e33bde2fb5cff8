"""Intervals and tests with participants as the unit.

A viewer judges several items, and his answers resemble each other. Intervals and tests that take all answers as
independent can therefore be too narrow or too small; those of this module draw or exchange participants.
"""

from dataclasses import dataclass

import numpy as np

from visualspeech.study.evaluation_settings import EvaluationSettings

#: Numbers in a block of bootstrap samples or permutations, which limits the memory.
BLOCK = 1_000_000


@dataclass(frozen=True)
class Interval:
    """A confidence interval; NaN where there is none."""

    low: float
    high: float


NO_INTERVAL = Interval(np.nan, np.nan)


def bootstrap_interval(sums: np.ndarray, counts: np.ndarray, settings: EvaluationSettings) -> Interval:
    """Percentile bootstrap interval (Efron 1979) of ``sums.sum() / counts.sum()`` over participants.

    Parameters
    ----------
    sums, counts : shape (participants,); of each participant the sum of the answers and their number

    Returns
    -------
    Interval
        :data:`NO_INTERVAL` for fewer than two participants
    """
    from scipy.stats import bootstrap

    if len(sums) < 2:
        return NO_INTERVAL
    found = bootstrap(
        (sums, counts),
        lambda one, number, axis: one.sum(axis=axis) / number.sum(axis=axis),
        paired=True,
        vectorized=True,
        n_resamples=settings.samples,
        batch=max(1, BLOCK // len(sums)),
        confidence_level=settings.level,
        method="percentile",
        rng=np.random.default_rng(settings.seed),
    )
    return Interval(float(found.confidence_interval.low), float(found.confidence_interval.high))


def sign_flip_test(differences: np.ndarray, settings: EvaluationSettings) -> float:
    """Two-sided p value of the mean of paired differences, by random signs (Fisher 1935); exact for few participants.

    Parameters
    ----------
    differences : shape (participants,)

    Returns
    -------
    float
        1 where all differences are 0 or there are fewer than two; NaN where there is none
    """
    from scipy.stats import permutation_test

    if not len(differences):
        return np.nan
    if len(differences) < 2 or not np.any(differences):
        return 1.0
    found = permutation_test(
        (differences,),
        lambda values, axis: values.mean(axis=axis),
        permutation_type="samples",
        vectorized=True,
        n_resamples=settings.permutations,
        batch=max(1, BLOCK // len(differences)),
        rng=np.random.default_rng(settings.seed),
    )
    return float(found.pvalue)


def smallest_p(participants: int, settings: EvaluationSettings) -> float:
    """The smallest p value that :func:`sign_flip_test` can give."""
    if participants < 2:
        return 1.0
    # All sign patterns where they are few (two of them are as extreme as the most extreme one), else drawn ones.
    exact = 2.0 ** (1 - participants)
    return exact if 2**participants <= settings.permutations else 2.0 / (settings.permutations + 1)
