"""Tables and figures of a preference test."""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.plot_style import COLOURS
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.report import Picture
from visualspeech.study.evaluation_tables import (
    Context,
    Drawing,
    Part,
    p_phrase,
    p_text,
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
from visualspeech.study.records import REMEDY

#: Colours of the first condition, of neither and of the second.
SHARE_COLOURS = (COLOURS[0], NEUTRAL, COLOURS[1])
NO_DIFFERENCE = "no difference"


@dataclass(frozen=True)
class Compared:
    """What viewers of a preference study preferred.

    Parameters
    ----------
    conditions : names of the first and the second condition, in the order of the key
    result : statistics
    left, decided : number of answers for the left video, and for one of the two
    """

    conditions: tuple[str, str]
    result: Preference
    left: int
    decided: int


def compare_conditions(context: Context) -> Compared:
    """The statistics of a preference study.

    Raises
    ------
    DataError
        The key does not have two conditions, or an item does not compare them.
    """
    first, *rest = (one.name for one in context.key.conditions)
    if len(rest) != 1:
        raise DataError(f"key.json: a preference study compares two conditions, not {1 + len(rest)}. {REMEDY}")
    pair, items = (first, rest[0]), {}
    for item in context.study.of_role(ITEM):
        shown = [context.key.stimuli[name] for name in item.stimuli]
        if any(sorted(one.conditions) != sorted(pair) for one in shown):
            raise DataError(f"key.json: the item {item.id} does not compare {first} and {rest[0]}. {REMEDY}")
        items[item.id] = shown[0].utterance
    answers = context.screening.answers
    decided = [one for _, one in answers if one.value != NONE]
    return Compared(
        conditions=pair,
        result=evaluate_preference(_choices(context, pair, items), context.settings),
        left=sum(one.value == LEFT for one in decided),
        decided=len(decided),
    )


def _choices(context: Context, pair: tuple[str, str], items: dict[str, str]) -> Choices:
    people = list(dict.fromkeys(code for code, _ in context.screening.answers))
    rows = {code: number for number, code in enumerate(people)}
    columns = {name: number for number, name in enumerate(items)}
    codes = {pair[0]: FIRST, NONE: NEITHER, pair[1]: SECOND}
    values = np.full((len(people), len(items)), MISSING)
    for code, one in context.screening.answers:
        values[rows[code], columns[one.item]] = codes[context.key.preferred(context.study, one)]
    return Choices(tuple(people), tuple(items.values()), values)


def preference_parts(context: Context, compared: Compared, paper: Published | None) -> tuple[Part, ...]:
    """The tables of shares and of sentences."""
    return (
        Part(
            "preference",
            context.titled("preference test"),
            _share_frame(context, compared, paper),
            (
                context.marked(_share_table(context, compared)),
                context.marked(_test_table(context, compared)),
                *published_tables(paper),
            ),
        ),
        Part(
            "sentences",
            context.titled("majority of viewers by sentence"),
            _sentence_frame(context, compared),
            (context.marked(_sentence_table(context, compared)),),
        ),
    )


def _heading(context: Context, one: Compared) -> str:
    return " against ".join(map(context.title_of, one.conditions))


def _columns(context: Context, one: Compared) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Headings and codes of the answers, without `no difference` where the choice is forced."""
    first, second = map(context.title_of, one.conditions)
    if context.study.forced:
        return (first, second), (FIRST, SECOND)
    return (first, NO_DIFFERENCE, second), (FIRST, NEITHER, SECOND)


def _share_table(context: Context, one: Compared) -> Table:
    names, codes = _columns(context, one)
    shares, level, settings = [one.result.shares[code] for code in codes], context.level(), context.settings
    rows = (
        Row("share of answers", tuple(Cell(percent(share.value), percent_interval(share.exact)) for share in shares)),
        Row("interval over participants", tuple(Cell(percent_interval(share.clustered)) for share in shares)),
        Row("answers", tuple(Cell(str(share.count)) for share in shares)),
    )
    notes = (
        f"Intervals below the shares are Clopper-Pearson intervals of {level}, which take all answers as independent, "
        "although each participant gave several. Intervals over participants are percentile bootstrap intervals of "
        f"{level} with {settings.samples} samples of participants.",
        *participants_note(one.result.participants),
    )
    facts = (
        *context.facts(),
        ("sentences", str(len(one.result.majority.items))),
        ("answers for the left video", _left_text(context, one)),
    )
    return Table(_heading(context, one), names, rows, facts=facts, notes=notes)


def _test_table(context: Context, one: Compared) -> Table:
    """The tests of the preference over answers, participants and sentences."""
    first, found, level = context.title_of(one.conditions[0]), one.result, context.settings.level
    won, total = found.majority.won(FIRST), len(found.majority.items) - found.majority.won(NEITHER)
    of_sentences = percent_interval(exact_interval(won, total, level)) if total else ""
    decided = percent_interval(found.decided.exact) if found.decided.total else ""
    alone = found.participants < 2
    rows = (
        Row(
            "answers: exact binomial test",
            _tested(found.decided.count, found.decided.total, decided, found.p),
        ),
        Row(
            "participants: sign-flip test",
            (Cell(""), Cell(str(found.participants)), Cell(""), Cell("" if alone else p_text(found.p_participants))),
        ),
        Row("sentences by majority: exact binomial test", _tested(won, total, of_sentences, found.majority.p)),
    )
    neither = "" if context.study.forced else f"Answers for “{NO_DIFFERENCE}” are left out of the binomial tests. "
    notes = [
        f"Two-sided tests of no preference, with Clopper-Pearson intervals. {neither}The binomial test of the answers "
        "takes all of them as independent. The sign-flip test exchanges the two conditions for whole participants, by "
        "the difference of both shares of a participant's answers.",
        f"A sentence goes to the condition that more viewers chose than the other one; {_ties(one)}, which its test "
        "leaves out.",
    ]
    least = smallest_p(found.participants, context.settings)
    if not alone and least > 0.05:
        notes.append(
            f"With {found.participants} participants the p value of the sign-flip test is at least {least:.2g}."
        )
    return Table(f"Tests of {_heading(context, one)}", (f"for {first}", "of", "share", "p"), rows, notes=tuple(notes))


def _tested(count: int, total: int, within: str, p: float) -> tuple[Cell, ...]:
    share = percent(count / total) if total else ""
    return Cell(str(count)), Cell(str(total)), Cell(share, within), Cell(p_text(p) if total else "")


def _ties(one: Compared) -> str:
    ties = one.result.majority.won(NEITHER)
    return f"{ties} are ties" if ties > 1 else "one is a tie" if ties else "none is a tie"


def _majority_text(context: Context, one: Compared) -> str:
    first, second = map(context.title_of, one.conditions)
    won = one.result.majority
    return f"{first} {won.won(FIRST)}, {second} {won.won(SECOND)}; {_ties(one)} ({len(won.items)} sentences)"


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


def _share_frame(context: Context, one: Compared, paper: Published | None):
    import pandas

    found = one.result
    names = {FIRST: one.conditions[0], NEITHER: NONE, SECOND: one.conditions[1]}
    lines = [
        {
            "answers": context.source(), "answer": names[code], "count": share.count, "share": share.value,
            "low": share.exact.low, "high": share.exact.high, "participants_low": share.clustered.low,
            "participants_high": share.clustered.high, "sentences": found.majority.won(code), "p": found.p,
            "p_participants": found.p_participants, "p_sentences": found.majority.p,
        }
        for code, share in enumerate(found.shares)
    ]  # fmt: skip
    printed = [
        {"answers": "published", "answer": name, "share": share}
        for name, share in (paper.preference if paper else {}).items()
    ]
    # Counts of published shares are empty, and the others stay whole numbers.
    return pandas.DataFrame([*lines, *printed]).astype({"count": "Int64", "sentences": "Int64"})


def _sentence_frame(context: Context, one: Compared):
    import pandas

    won, names = one.result.majority, {FIRST: one.conditions[0], NEITHER: "tie", SECOND: one.conditions[1]}
    return pandas.DataFrame(
        [
            (context.source(), name, *map(int, counts), names[int(side)])
            for name, counts, side in zip(won.items, won.counts, won.winners, strict=True)
        ],
        columns=["answers", "utterance", "count_first", "count_none", "count_second", "majority"],
    )


def preference_drawings(context: Context, one: Compared, paper: Published | None) -> tuple[Drawing, ...]:
    """The figure of the shares (Fan et al. 2015, Fig. 4), and that of the sentences."""
    heading, (first, second) = _heading(context, one), map(context.title_of, one.conditions)
    bars = [_share_bar(context, one), *_published_bars(paper)]
    published = "; hatched: as published" if len(bars) > 1 else ""
    shares = share_bars(bars, SHARE_COLOURS, f"Preference of viewers, {heading}", context.simulated)
    sentences = share_bars(_sentence_bars(one), SHARE_COLOURS, f"Viewers by sentence, {heading}", context.simulated)
    captions = (
        f"Shares of the answers of {one.result.participants} viewers, {heading}{published}",
        f"Numbers of viewers who preferred {first} (blue) and {second} (orange), by sentence; grey: neither",
    )
    return tuple(
        Drawing(name, Picture(png, context.titled(caption)))
        for name, png, caption in zip(("preference", "sentences"), (shares, sentences), captions, strict=True)
    )


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
