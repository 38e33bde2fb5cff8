"""Preference test of two models (Fan et al. 2015, section 5.4 and Fig. 4): pairs, key, and count of the answers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.published_results import Published

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
    """Randomly chosen sentences in random order; each model is on the left in half of the pairs (rounded).

    Parameters
    ----------
    ids : test utterances
    models : the two models
    count : number of pairs, at most one per test utterance

    Raises
    ------
    SettingError
        There are not two different models, or there is no pair to show.
    """
    if len(set(models)) != 2 or len(models) != 2:
        raise SettingError(f"`preference.models: {list(models)}` must be two different models, for example FBB-128.")
    if count < 1 or not len(ids):
        raise SettingError(
            f"`preference.count: {count}` of {len(ids)} test utterances leaves no pair to show; give at least 1 and a "
            "corpus with test utterances."
        )
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
    listeners, pairs : numbers of listeners and of pairs with an answer
    p : of the two-sided sign test of the two models over listeners and pairs, without neutral answers; the answers of
        one listener are treated as independent, as is usual for such tests
    blank : rows of the answer sheets without an answer
    """

    counts: Mapping[str, int]
    listeners: int
    pairs: int
    p: float
    blank: int = 0

    def share(self, name: str) -> float:
        """Share of all answers."""
        return self.counts[name] / sum(self.counts.values())


def tally(answers, key, path: str = "the answer sheet") -> Preference:
    """Count filled-in answer sheets by the key; rows without an answer are ignored.

    Parameters
    ----------
    answers : data frame with the columns ``listener``, ``pair``, ``answer``
    key : from :func:`key_table`
    path : the file of the answers, for messages

    Raises
    ------
    DataError
        There is no answer, an answer is not A, neutral or B, or its pair is not in the key.
    """
    from scipy.stats import binomtest

    answers = answers.assign(answer=answers["answer"].astype(str).str.strip())
    given = answers[answers["answer"] != ""]
    if not len(given):
        raise DataError(
            f"{path} holds no answers. Fill in its columns `listener` and `answer` ({', '.join(ANSWERS)}), one row per "
            "listener and pair, and run the same command again."
        )
    videos = {row.pair: (row.A, row.B) for row in key.itertuples()}
    models = sorted({model for pair in videos.values() for model in pair})
    counts = {models[0]: 0, "neutral": 0, models[1]: 0}
    for row in given.itertuples():
        if row.answer not in ANSWERS or row.pair not in videos:
            raise DataError(
                f"{path}: the answer {row.answer!r} of listener {row.listener!r} to pair {row.pair!r} cannot be "
                f"counted. Answers are {', '.join(ANSWERS)}; pairs are 1 to {len(videos)}. Correct the row and run the "
                "same command again."
            )
        counts["neutral" if row.answer == "neutral" else videos[row.pair][row.answer == "B"]] += 1
    decided = counts[models[0]] + counts[models[1]]
    p = binomtest(counts[models[0]], decided).pvalue if decided else 1.0
    listeners, pairs = given["listener"].nunique(), given["pair"].nunique()
    return Preference(counts, listeners, pairs, float(p), len(answers) - len(given))


def preference_frame(found: Preference, paper: Published | None = None):
    """Shares of answers as a data frame: source, answer, count, share."""
    import pandas

    lines = [("run", name, count, found.share(name)) for name, count in found.counts.items()]
    lines += [("published", name, np.nan, share) for name, share in (paper.preference if paper else {}).items()]
    return pandas.DataFrame(lines, columns=["source", "answer", "count", "share"])


def preference_tables(
    found: Preference,
    facts: Sequence[tuple[str, str]] = (),
    paper: Published | None = None,
    titles: Mapping[str, str] | None = None,
) -> tuple[Table, ...]:
    """Shares of answers, of the run and as published.

    Parameters
    ----------
    facts : what the models were trained on
    titles : name of a model -> its title
    """
    columns = tuple((titles or {}).get(name, name) for name in found.counts)
    shares = tuple(Cell(f"{found.share(name):.1%}", f"({count})") for name, count in found.counts.items())
    lines = (
        *facts,
        ("listeners", str(found.listeners)),
        ("pairs", str(found.pairs)),
        ("sign test", f"p = {found.p:.2g}"),
        *((("rows without an answer, ignored", str(found.blank)),) if found.blank else ()),
    )
    note = "The sign test leaves neutral answers out and takes all answers as independent."
    title, row = "Preference test", "share of answers"
    tables = [Table(title, columns, (Row(row, shares),), facts=lines, notes=(note,))]
    if paper and paper.preference:
        shares = tuple(Cell(f"{share:.1%}") for share in paper.preference.values())
        source = (("source", paper.source),)
        tables.append(Table(f"{title} as published", tuple(paper.preference), (Row(row, shares),), facts=source))
    return tuple(tables)
