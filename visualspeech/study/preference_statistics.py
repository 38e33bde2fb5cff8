"""Statistics of a preference test of two conditions (Fan et al. 2015, Fig. 4; Thangthai et al. 2016, section 5.4)."""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.participants_statistics import Interval, bootstrap_interval, sign_flip_test

#: Codes of an answer, in the order of the shares; and of an item that a participant did not answer.
FIRST, NEITHER, SECOND = 0, 1, 2
MISSING = -1


@dataclass(frozen=True)
class Choices:
    """Answers of a preference test of two conditions.

    Parameters
    ----------
    participants, items : their names
    answers : shape (participants, items): ``FIRST``, ``NEITHER``, ``SECOND`` or ``MISSING``

    Raises
    ------
    DataError
        The shape is another one, a code is unknown, or there is no answer.
    """

    participants: tuple[str, ...]
    items: tuple[str, ...]
    answers: np.ndarray

    def __post_init__(self) -> None:
        answers = np.asarray(self.answers)
        if answers.shape != (len(self.participants), len(self.items)):
            raise DataError(
                f"answers of shape {answers.shape} do not belong to {len(self.participants)} participants and "
                f"{len(self.items)} items."
            )
        if not np.isin(answers, (MISSING, FIRST, NEITHER, SECOND)).all():
            raise DataError("an answer is none of first, neither and second.")
        if not (answers != MISSING).any():
            raise DataError("there is no answer to evaluate.")


@dataclass(frozen=True)
class Share:
    """A share of answers.

    Parameters
    ----------
    count, total : the share is ``count / total``; NaN if ``total`` is 0
    exact : Clopper-Pearson interval (1934), which takes all answers as independent
    clustered : percentile bootstrap interval over participants
    """

    count: int
    total: int
    exact: Interval
    clustered: Interval

    @property
    def value(self) -> float:
        return self.count / self.total if self.total else np.nan


@dataclass(frozen=True)
class Majority:
    """Which condition the viewers of each item preferred.

    An item goes to the condition that more participants chose than the other one; equal numbers are a tie. Answers for
    neither condition do not count.

    Parameters
    ----------
    items : their names
    counts : shape (items, 3): participants who chose the first, neither and the second condition
    winners : shape (items,): ``FIRST``, ``SECOND``, or ``NEITHER`` for a tie
    p : exact binomial test of the items won, without ties
    """

    items: tuple[str, ...]
    counts: np.ndarray
    winners: np.ndarray
    p: float

    def won(self, code: int) -> int:
        """Number of items that went to a condition, or are a tie (``NEITHER``)."""
        return int((self.winners == code).sum())


@dataclass(frozen=True)
class Preference:
    """What viewers preferred.

    Parameters
    ----------
    shares : of the first condition, of neither and of the second, among all answers
    decided : share of the first condition among the answers for one of the two
    p : two-sided exact binomial test of ``decided`` against one half (sign test); takes all answers as independent
    p_participants : two-sided sign-flip test over participants of the difference of the shares of both conditions among
        a participant's answers
    majority : by item
    participants : number of participants with an answer
    """

    shares: tuple[Share, Share, Share]
    decided: Share
    p: float
    p_participants: float
    majority: Majority
    participants: int


def evaluate_preference(choices: Choices, settings: EvaluationSettings | None = None) -> Preference:
    """Shares, tests and majorities of a preference test.

    Answers for neither condition are part of the shares; the tests leave them out, as the sign test does (Dixon and
    Mood 1946). Participants and items without an answer do not count.
    """
    settings = settings or EvaluationSettings()
    answers = np.asarray(choices.answers)
    answers = answers[(answers != MISSING).any(axis=1)]
    by_person = np.stack([(answers == code).sum(axis=1) for code in (FIRST, NEITHER, SECOND)], axis=1)
    given = by_person.sum(axis=1)
    # Participants who never chose one of the two say nothing about the share among decided answers.
    decided = by_person[:, FIRST] + by_person[:, SECOND]
    chose = decided > 0
    return Preference(
        shares=tuple(share(by_person[:, code], given, settings) for code in (FIRST, NEITHER, SECOND)),
        decided=share(by_person[chose, FIRST], decided[chose], settings),
        p=sign_test(int(by_person[:, FIRST].sum()), int(decided.sum())),
        p_participants=sign_flip_test((by_person[:, FIRST] - by_person[:, SECOND]) / given, settings),
        majority=majority(choices),
        participants=len(answers),
    )


def share(counts: np.ndarray, totals: np.ndarray, settings: EvaluationSettings) -> Share:
    """The share of some answers, with both intervals.

    Parameters
    ----------
    counts, totals : shape (participants,); of each participant the number of these answers and of all
    """
    count, total = int(counts.sum()), int(totals.sum())
    return Share(
        count, total, exact_interval(count, total, settings.level), bootstrap_interval(counts, totals, settings)
    )


def exact_interval(count: int, total: int, level: float) -> Interval:
    """Clopper-Pearson interval of ``count`` of ``total``; the whole range from 0 to 1 if ``total`` is 0."""
    from scipy.stats import binomtest

    if not total:
        return Interval(0.0, 1.0)
    found = binomtest(count, total).proportion_ci(level, method="exact")
    return Interval(float(found.low), float(found.high))


def sign_test(first: int, decided: int) -> float:
    """Two-sided exact binomial test of ``first`` of ``decided`` against one half; 1 if there is nothing to test."""
    from scipy.stats import binomtest

    return float(binomtest(first, decided).pvalue) if decided else 1.0


def majority(choices: Choices) -> Majority:
    """The condition that the viewers of each answered item preferred."""
    answers = np.asarray(choices.answers)
    asked = np.flatnonzero((answers != MISSING).any(axis=0))
    counts = np.stack([(answers[:, asked] == code).sum(axis=0) for code in (FIRST, NEITHER, SECOND)], axis=1)
    ahead = np.sign(counts[:, FIRST] - counts[:, SECOND])
    winners = np.choose(ahead + 1, (SECOND, NEITHER, FIRST))
    won = int((winners == FIRST).sum())
    return Majority(
        items=tuple(choices.items[number] for number in asked),
        counts=counts,
        winners=winners,
        p=sign_test(won, won + int((winners == SECOND).sum())),
    )
