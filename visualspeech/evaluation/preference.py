"""A preference test of two models (Fan et al. 2015, section 5.4 and Fig. 4): what is shown, the key, the count."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.sheets import Cell, Sheet

ANSWERS = ("A", "neutral", "B")


@dataclass(frozen=True)
class Pair:
    """Two videos of one sentence side by side.

    Parameters
    ----------
    number : of the pair, from 1 in the order in which they are shown
    utterance : id of the sentence
    left, right : models of the videos A and B
    """

    number: int
    utterance: str
    left: str
    right: str


def draw_pairs(ids: Sequence[str], models: Sequence[str], count: int, seed: int) -> tuple[Pair, ...]:
    """Sentences chosen at random, in random order, each model on the left in half of them (one more or less if odd).

    Parameters
    ----------
    ids : test utterances
    models : the two models
    count : number of pairs; all sentences where there are fewer

    Raises
    ------
    SettingError
        The models are not two, or there is no pair to show.
    """
    if len(set(models)) != 2 or len(models) != 2:
        raise SettingError(f"`preference.models: {list(models)}` must be two different models, for example FBB-128.")
    if count < 1 or not len(ids):
        raise SettingError(f"`preference.count: {count}` of {len(ids)} test utterances: there is no pair to show.")
    generator = np.random.default_rng(seed)
    chosen = generator.permutation(sorted(ids))[:count]
    swapped = generator.permutation((np.arange(len(chosen)) + generator.integers(2)) % 2)
    return tuple(
        Pair(number, str(name), *(models[::-1] if swap else models))
        for number, (name, swap) in enumerate(zip(chosen, swapped, strict=True), 1)
    )


def key_table(pairs: Sequence[Pair]):
    """The key as a data frame: pair, utterance, A, B."""
    import pandas

    return pandas.DataFrame(
        [(pair.number, pair.utterance, pair.left, pair.right) for pair in pairs],
        columns=["pair", "utterance", "A", "B"],
    )


def answer_sheet(pairs: Sequence[Pair]):
    """The sheet that one listener fills in, as a data frame: listener, pair, answer (A, neutral or B)."""
    import pandas

    return pandas.DataFrame({"listener": "", "pair": [pair.number for pair in pairs], "answer": ""})


@dataclass(frozen=True)
class Preference:
    """What listeners preferred.

    Parameters
    ----------
    counts : answers for each of the two models and for ``neutral``
    listeners, pairs : how many took part, how many pairs they saw
    p : of the sign test of the two models over listeners and pairs, neutral answers left out, two-sided; answers of
        one listener are taken as independent, as such tests do
    """

    counts: Mapping[str, int]
    listeners: int
    pairs: int
    p: float

    def share(self, name: str) -> float:
        """Share of all answers."""
        return self.counts[name] / sum(self.counts.values())


def tally(answers, key) -> Preference:
    """Count filled-in answer sheets (a data frame: listener, pair, answer) by the key.

    Raises
    ------
    DataError
        An answer is none of A, neutral and B, names a pair that the key lacks, or there is none.
    """
    from scipy.stats import binomtest

    shown = {row.pair: (row.A, row.B) for row in key.itertuples()}
    models = sorted({model for pair in shown.values() for model in pair})
    counts = {models[0]: 0, "neutral": 0, models[1]: 0}
    for row in answers.itertuples():
        if row.answer not in ANSWERS or row.pair not in shown:
            raise DataError(
                f"the answer {row.answer!r} of listener {row.listener!r} to pair {row.pair!r} cannot be counted: "
                f"answers are {', '.join(ANSWERS)}, pairs are 1 to {len(shown)}."
            )
        counts["neutral" if row.answer == "neutral" else shown[row.pair][row.answer == "B"]] += 1
    if not len(answers):
        raise DataError("there is no answer to count. Fill in the answer sheet, a row for each listener and pair.")
    decided = counts[models[0]] + counts[models[1]]
    p = binomtest(counts[models[0]], decided).pvalue if decided else 1.0
    return Preference(counts, answers["listener"].nunique(), answers["pair"].nunique(), float(p))


def preference_frame(found: Preference, published: Mapping[str, float]):
    """Shares of answers as a data frame: source, answer, count, share."""
    import pandas

    lines = [("ours", name, count, found.share(name)) for name, count in found.counts.items()]
    lines += [("published", name, np.nan, share) for name, share in published.items()]
    return pandas.DataFrame(lines, columns=["source", "answer", "count", "share"])


def preference_sheets(found: Preference, published: Mapping[str, float], source: str) -> tuple[Sheet, ...]:
    """Fig. 4 as a table: ours, and as published."""
    ours = tuple(Cell(f"{found.share(name):.1%}", f"({count})") for name, count in found.counts.items())
    facts = (("listeners", str(found.listeners)), ("pairs", str(found.pairs)), ("sign test", f"p = {found.p:.2g}"))
    note = "The sign test leaves neutral answers out and takes all answers as independent."
    sheets = [Sheet("Preference", tuple(found.counts), (("share of answers", ours),), facts=facts, notes=(note,))]
    if published:
        theirs = tuple(Cell(f"{share:.1%}") for share in published.values())
        facts = (("source", source),)
        sheets.append(Sheet("The same as published", tuple(published), (("share of answers", theirs),), facts=facts))
    return tuple(sheets)
