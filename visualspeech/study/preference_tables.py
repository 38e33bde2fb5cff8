"""Tables and figures of a preference test."""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.comparisons import holm
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.plot_style import COLOURS
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.report import Picture
from visualspeech.study.evaluation_tables import (
    Context,
    Drawing,
    Part,
    p_phrase,
    participants_note,
    percent,
    percent_interval,
)
from visualspeech.study.figures import NEUTRAL, Bar, share_bars
from visualspeech.study.layouts import ITEM, LEFT, NONE
from visualspeech.study.participants_statistics import smallest_p
from visualspeech.study.preference_statistics import (
    FIRST,
    MISSING,
    NEITHER,
    SECOND,
    Choices,
    Preference,
    evaluate_preference,
    exact_interval,
    sign_test,
)
from visualspeech.study.records import Question

#: Colours of the first condition, of neither and of the second.
SHARE_COLOURS = (COLOURS[0], NEUTRAL, COLOURS[1])
NO_DIFFERENCE = "no difference"


@dataclass(frozen=True)
class Compared:
    """Two conditions that were compared under one question.

    Parameters
    ----------
    question : that participants answered
    conditions : names of the first and the second
    result : statistics
    left, decided : number of answers for the left video, and for one of the two
    """

    question: Question
    conditions: tuple[str, str]
    result: Preference
    left: int
    decided: int


def compare_conditions(context: Context) -> tuple[Compared, ...]:
    """The statistics of every pair of conditions and question of a preference study.

    Raises
    ------
    DataError
        An item does not compare two different conditions of the key.
    """
    found = []
    for question in context.study.questions:
        for pair, items in _items_of_pairs(context).items():
            answers = [(code, one) for code, one in context.screening.answers
                       if one.question == question.name and one.item in items]  # fmt: skip
            choices = _choices(context, pair, items, answers)
            decided = [one for _, one in answers if one.value != NONE]
            left = sum(one.value == LEFT for one in decided)
            found.append(Compared(question, pair, evaluate_preference(choices, context.settings), left, len(decided)))
    return tuple(found)


def _items_of_pairs(context: Context) -> dict[tuple[str, str], dict[str, str]]:
    """Pair of conditions, in the order of the key -> item -> utterance."""
    order = {one.name: number for number, one in enumerate(context.key.conditions)}
    found: dict[tuple[str, str], dict[str, str]] = {}
    for item in context.study.of_role(ITEM):
        shown = [context.key.stimuli[name] for name in item.stimuli]
        pair = tuple(sorted(set(shown[0].conditions), key=lambda name: order.get(name, -1)))
        if len(pair) != 2 or any(set(one.conditions) != set(pair) for one in shown) or not set(pair) <= set(order):
            raise DataError(
                f"key.json: the item {item.id} of the study {context.study.name} does not compare two of its "
                "conditions. Make the study again, or copy the whole folder again."
            )
        found.setdefault(pair, {})[item.id] = shown[0].utterance
    return found


def _choices(context: Context, pair: tuple[str, str], items: dict[str, str], answers) -> Choices:
    people = list(dict.fromkeys(code for code, _ in answers))
    rows = {code: number for number, code in enumerate(people)}
    columns = {name: number for number, name in enumerate(items)}
    codes = {pair[0]: FIRST, NONE: NEITHER, pair[1]: SECOND}
    values = np.full((len(people), len(items)), MISSING)
    for code, one in answers:
        values[rows[code], columns[one.item]] = codes[context.key.preferred(context.study, one)]
    return Choices(tuple(people), tuple(items.values()), values)


def preference_parts(context: Context, compared: tuple[Compared, ...], paper: Published | None) -> tuple[Part, ...]:
    """The tables of shares and of sentences."""
    corrected = holm([one.result.p for one in compared])
    shares = [_share_table(context, one, p, len(compared)) for one, p in zip(compared, corrected, strict=True)]
    sentences = [_sentence_table(context, one) for one in compared]
    return (
        Part(
            "preference",
            context.titled("preference test"),
            _share_frame(context, compared, corrected, paper),
            (*map(context.marked, shares), *published_tables(paper)),
        ),
        Part(
            "sentences",
            context.titled("majority of viewers by sentence"),
            _sentence_frame(context, compared),
            tuple(map(context.marked, sentences)),
        ),
    )


def _heading(context: Context, one: Compared) -> str:
    first, second = map(context.title_of, one.conditions)
    asked = f": {one.question.text}" if len(context.study.questions) > 1 else ""
    return f"{first} against {second}{asked}"


def _columns(context: Context, one: Compared) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Headings and codes of the answers, without `no difference` where the choice is forced."""
    first, second = map(context.title_of, one.conditions)
    if NONE in one.question.choices:
        return (first, NO_DIFFERENCE, second), (FIRST, NEITHER, SECOND)
    return (first, second), (FIRST, SECOND)


def _share_table(context: Context, one: Compared, corrected: float, comparisons: int) -> Table:
    names, codes = _columns(context, one)
    shares = [one.result.shares[code] for code in codes]
    level, settings, found = context.level(), context.settings, one.result
    first = context.title_of(one.conditions[0])
    notes = [
        f"Exact intervals are Clopper-Pearson intervals of {level}; they, and the exact binomial test, take all "
        "answers as independent, although each participant gave several.",
        f"Intervals over participants are percentile bootstrap intervals of {level} with {settings.samples} samples of "
        "participants. The sign-flip test exchanges the two conditions for whole participants.",
        "Tests are two-sided. "
        + (
            f"Answers for “{NO_DIFFERENCE}” are part of the shares and left out of the tests. "
            if len(codes) == 3
            else ""
        )
        + "A sentence goes to the condition that more viewers chose than the other one; equal numbers are a tie, which "
        "the test of the sentences leaves out.",
        *participants_note(found.participants),
    ]
    if found.participants > 1 and smallest_p(found.participants, settings) > 0.05:
        notes.append(
            f"With {found.participants} participants the sign-flip test cannot fall below "
            f"p = {smallest_p(found.participants, settings):.4f}."
        )
    decided = (
        f"{percent(found.decided.value)} {percent_interval(found.decided.exact)}" if found.decided.total else "none"
    )
    facts = (
        *context.facts(),
        ("sentences", str(len(found.majority.items))),
        (f"{first} among the {found.decided.total} answers for one of the two", decided),
        ("exact binomial test", p_phrase(found.p)),
        *((((f"Holm-corrected for {comparisons} comparisons"), p_phrase(corrected)),) if comparisons > 1 else ()),
        (
            "sign-flip test over participants",
            p_phrase(found.p_participants) if found.participants > 1 else "not defined",
        ),
        ("majority of viewers", _majority_text(context, one)),
        ("answers for the left video", _left_text(context, one)),
    )
    rows = (
        Row("share of answers", tuple(Cell(percent(share.value), percent_interval(share.exact)) for share in shares)),
        Row("interval over participants", tuple(Cell(percent_interval(share.clustered)) for share in shares)),
        Row("answers", tuple(Cell(str(share.count)) for share in shares)),
    )
    return Table(_heading(context, one), names, rows, facts=facts, notes=tuple(notes))


def _majority_text(context: Context, one: Compared) -> str:
    first, second = map(context.title_of, one.conditions)
    won = one.result.majority
    ties = won.won(NEITHER)
    return (
        f"{first} in {won.won(FIRST)} of {len(won.items)} sentences, {second} in {won.won(SECOND)}, "
        f"{ties} {'tie' if ties == 1 else 'ties'}; exact binomial test of the sentences {p_phrase(won.p)}"
    )


def _left_text(context: Context, one: Compared) -> str:
    if not one.decided:
        return "none"
    found = percent_interval(exact_interval(one.left, one.decided, context.settings.level))
    return f"{percent(one.left / one.decided)} {found} of {one.decided}, {p_phrase(sign_test(one.left, one.decided))}"


def _sentence_table(context: Context, one: Compared) -> Table:
    names, codes = _columns(context, one)
    winner = {
        FIRST: context.title_of(one.conditions[0]), NEITHER: "tie", SECOND: context.title_of(one.conditions[1])
    }  # fmt: skip
    won = one.result.majority
    rows = tuple(
        Row(name, (*(Cell(str(counts[code]), best=code == side != NEITHER) for code in codes), Cell(winner[int(side)])))
        for name, counts, side in zip(won.items, won.counts, won.winners, strict=True)
    )
    return Table(
        f"Majority of viewers by sentence, {_heading(context, one)}",
        (*names, "majority"),
        rows,
        facts=(*context.facts(), ("majority of viewers", _majority_text(context, one))),
        notes=("Numbers of participants; that of the condition that a sentence goes to is bold.",),
        corner="Sentence",
    )


def published_tables(paper: Published | None) -> tuple[Table, ...]:
    """What a paper prints of its own preference test."""
    if paper is None:
        return ()
    found = []
    for row, shares in (("share of answers", paper.preference), ("sentences by majority", paper.majority)):
        if shares:
            cells = tuple(Cell(percent(share)) for share in shares.values())
            title = "Preference test as published"
            found.append(Table(title, tuple(shares), (Row(row, cells),), facts=(("source", paper.source),)))
    return tuple(found)


def _share_frame(context: Context, compared, corrected, paper: Published | None):
    import pandas

    lines = []
    for one, p_holm in zip(compared, corrected, strict=True):
        found = one.result
        won = {FIRST: FIRST, NEITHER: NEITHER, SECOND: SECOND}
        names = {FIRST: one.conditions[0], NEITHER: NONE, SECOND: one.conditions[1]}
        for code, share in enumerate(found.shares):
            lines.append(
                {
                    "answers": context.source(), "question": one.question.name, "first": one.conditions[0],
                    "second": one.conditions[1], "answer": names[code], "count": share.count, "share": share.value,
                    "low": share.exact.low, "high": share.exact.high, "participants_low": share.clustered.low,
                    "participants_high": share.clustered.high, "sentences": found.majority.won(won[code]),
                    "p": found.p, "p_holm": p_holm, "p_participants": found.p_participants,
                    "p_sentences": found.majority.p,
                }
            )  # fmt: skip
    frame = pandas.DataFrame(lines)
    printed = [
        {"answers": "published", "answer": name, "share": share}
        for name, share in (paper.preference if paper else {}).items()
    ]
    return pandas.concat([frame, pandas.DataFrame(printed)], ignore_index=True) if printed else frame


def _sentence_frame(context: Context, compared):
    import pandas

    return pandas.DataFrame(
        [
            (context.source(), one.question.name, *one.conditions, name, *map(int, counts),
             {FIRST: one.conditions[0], NEITHER: "tie", SECOND: one.conditions[1]}[int(side)])
            for one in compared
            for won in (one.result.majority,)
            for name, counts, side in zip(won.items, won.counts, won.winners, strict=True)
        ],
        columns=["answers", "question", "first", "second", "utterance", "count_first", "count_none", "count_second",
                 "majority"],
    )  # fmt: skip


def preference_drawings(
    context: Context, compared: tuple[Compared, ...], paper: Published | None
) -> tuple[Drawing, ...]:
    """The figure of the shares (Fan et al. 2015, Fig. 4) and that of the sentences, of each comparison."""
    found = []
    for number, one in enumerate(compared, 1):
        heading, suffix = _heading(context, one), f"_{number}" if len(compared) > 1 else ""
        bars = [_share_bar(context, one), *_published_bars(paper)]
        png = share_bars(bars, SHARE_COLOURS, f"Preference of viewers, {heading}", context.simulated)
        published = "; hatched: as published" if len(bars) > 1 else ""
        caption = f"Shares of the answers of {one.result.participants} viewers, {heading}{published}"
        found.append(Drawing(f"preference{suffix}", Picture(png, context.titled(caption))))
        png = share_bars(_sentence_bars(one), SHARE_COLOURS, f"Viewers by sentence, {heading}", context.simulated)
        first, second = map(context.title_of, one.conditions)
        caption = f"Numbers of viewers who preferred {first} (blue) and {second} (orange), by sentence; grey: neither"
        found.append(Drawing(f"sentences{suffix}", Picture(png, context.titled(caption))))
    return tuple(found)


def _share_bar(context: Context, one: Compared) -> Bar:
    first, second = map(context.title_of, one.conditions)
    shares = tuple(share.value for share in one.result.shares)
    whose = "simulated" if context.simulated else "this study"
    return Bar(whose, (first, NO_DIFFERENCE, second), shares, tuple(map(percent, shares)))


def _published_bars(paper: Published | None) -> list[Bar]:
    """The published shares; a paper without `no difference` has two."""
    shares = dict(paper.preference) if paper else {}
    if not shares:
        return []
    labels, values = list(shares), list(shares.values())
    if len(values) == 2:
        labels.insert(1, ""), values.insert(1, 0.0)
    return [Bar("as published", tuple(labels), tuple(values), tuple(map(percent, values)), published=True)]


def _sentence_bars(one: Compared) -> list[Bar]:
    won = one.result.majority
    return [
        Bar(name, (), tuple(counts / counts.sum()), tuple(str(count) if count else "" for count in counts))
        for name, counts in zip(won.items, won.counts, strict=True)
    ]
