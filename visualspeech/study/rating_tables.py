"""Tables and figures of a rating test."""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.layout import Cell, Row, Table, interval, shown
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.report import Picture
from visualspeech.study.evaluation_tables import Context, Drawing, Part, listed, p_text, participants_note
from visualspeech.study.figures import Rating, rating_bars
from visualspeech.study.layouts import ITEM
from visualspeech.study.participants_statistics import Interval, smallest_p
from visualspeech.study.rating_statistics import Alpha, Omnibus, Pair, Rated, Ratings, cronbach_alpha, evaluate_ratings
from visualspeech.study.records import REMEDY, Question


@dataclass(frozen=True)
class Judged:
    """One question of a rating test.

    Parameters
    ----------
    question : that participants answered
    ratings : the answers
    result : statistics
    """

    question: Question
    ratings: Ratings
    result: Rated


def judge_conditions(context: Context) -> tuple[Judged, ...]:
    """The statistics of every question of a rating study.

    Raises
    ------
    DataError
        An item shows no condition of the key, or fewer than two conditions have ratings.
    """
    conditions = [one.name for one in context.key.conditions]
    items = context.study.of_role(ITEM)
    shown = []
    for item in items:
        name, *others = context.key.stimuli[item.stimuli[0]].conditions
        if others or name not in conditions:
            raise DataError(f"key.json: the item {item.id} does not show one of the conditions. {REMEDY}")
        shown.append(conditions.index(name))
    people = list(dict.fromkeys(code for code, _ in context.screening.answers))
    rows = {code: number for number, code in enumerate(people)}
    columns = {item.id: number for number, item in enumerate(items)}
    found = []
    for question in context.study.questions:
        values = np.full((len(people), len(items)), np.nan)
        for code, one in context.screening.answers:
            if one.question == question.name:
                values[rows[code], columns[one.item]] = one.value
        ratings = Ratings(tuple(people), tuple(conditions), np.array(shown), values)
        found.append(Judged(question, ratings, evaluate_ratings(ratings, context.settings)))
    return tuple(found)


def rating_parts(context: Context, judged: tuple[Judged, ...], paper: Published | None) -> tuple[Part, ...]:
    """The tables of means, of tests and of pairs of conditions."""
    overall = cronbach_alpha(np.concatenate([one.ratings.values for one in judged], axis=1))
    return (
        Part(
            "ratings",
            context.titled("ratings"),
            _mean_frame(context, judged),
            (context.marked(_mean_table(context, judged)),),
        ),
        Part(
            "rating_tests",
            context.titled("tests of the ratings"),
            _test_frame(context, judged, overall),
            (context.marked(_test_table(context, judged, overall)), *_published_table(paper)),
        ),
        Part(
            "pairs",
            context.titled("pairs of conditions"),
            _pair_frame(context, judged),
            (context.marked(_pair_table(context, judged)),),
        ),
    )


def _titles(context: Context) -> list[str]:
    return [one.title or one.name for one in context.key.conditions]


def _mean_table(context: Context, judged: tuple[Judged, ...]) -> Table:
    level, participants = context.level(), len(judged[0].ratings.participants)
    rows = []
    for number, title in enumerate(_titles(context)):
        means = [one.result.means[number] for one in judged]
        rows.append(Row(title, tuple(Cell(shown(mean.value, 2), _interval(mean.clustered)) for mean in means)))
    first = judged[0].question
    stimuli = len(context.study.of_role(ITEM))
    return Table(
        "Mean ratings",
        tuple(f"{one.question.name} ({one.question.minimum}–{one.question.maximum})" for one in judged),
        tuple(rows),
        facts=(*context.facts(), ("videos", str(stimuli)), ("scale", _scale(first))),
        notes=(
            f"Intervals are percentile bootstrap intervals of {level} with {context.settings.samples} samples of "
            "participants. ratings.tsv also has those by Student's t, which take all ratings as independent.",
            *participants_note(participants),
        ),
        definitions=tuple((one.question.name, one.question.text) for one in judged),
        corner="Condition",
    )


def _scale(question: Question) -> str:
    ends = [f"{value} = {text}" if text else str(value) for value, text in
            ((question.minimum, question.lowest), (question.maximum, question.highest))]  # fmt: skip
    return " to ".join(ends)


def _interval(given: Interval, digits: int = 2) -> str:
    return interval(shown(given.low, digits), shown(given.high, digits))


def _test_table(context: Context, judged: tuple[Judged, ...], overall: Alpha) -> Table:
    rows = [
        Row(
            one.question.name,
            (
                Cell(shown(one.result.alpha.value, 4)),
                Cell(_statistic("F", one.result.anova)),
                Cell(p_text(one.result.anova.p)),
                Cell(_statistic("chi-squared", one.result.friedman)),
                Cell(p_text(one.result.friedman.p)),
            ),
        )
        for one in judged
    ]
    if len(judged) > 1:
        rows.append(Row("all questions", (Cell(shown(overall.value, 4)), *(Cell(""),) * 4)))
    alpha = judged[0].result.alpha
    return Table(
        "Agreement of the participants, and tests of all conditions",
        ("Cronbach's alpha", "one-way ANOVA", "p", "Friedman's test", "p"),
        tuple(rows),
        facts=context.facts(),
        notes=(
            f"Cronbach's alpha takes participants as the items of the test and videos as its cases ({alpha.raters} "
            f"participants and {alpha.stimuli} videos; all questions: one case per video and question).",
            "One-way ANOVA, as Sadoughi and Busso (2017) report it, takes all ratings as independent, although each "
            "participant rated every condition. Friedman's test ranks the conditions by each participant's mean "
            "rating, and takes participants as independent; it needs three conditions.",
            *undefined_notes(judged),
        ),
        corner="Question",
    )


def undefined_notes(judged: tuple[Judged, ...]) -> tuple[str, ...]:
    """Why tests and agreement are not defined; empty where they are."""
    notes = []
    for one in judged:
        known = one.ratings.values[np.isfinite(one.ratings.values)]
        if not np.ptp(known):
            notes.append(
                f"All {len(known)} ratings of “{one.question.name}” are {known[0]:g}: there is no variance, and "
                "neither agreement nor tests are defined."
            )
        elif one.result.anova.p != one.result.anova.p:
            notes.append(f"The ratings of “{one.question.name}” do not vary within a condition: ANOVA is not defined.")
    return tuple(notes)


def _statistic(letter: str, test: Omnibus) -> str:
    if test.statistic != test.statistic:
        return ""
    return f"{letter}({', '.join(map(str, test.freedom))}) = {test.statistic:.2f}"


def _published_table(paper: Published | None) -> tuple[Table, ...]:
    if paper is None or not paper.ratings:
        return ()
    rows = tuple(Row(name, (Cell(text),)) for name, text in paper.ratings.items())
    return (Table("Ratings as published", ("in the paper",), rows, facts=(("source", paper.source),)),)


def _pair_table(context: Context, judged: tuple[Judged, ...]) -> Table:
    titles, settings = _titles(context), context.settings
    pairs = judged[0].result.pairs
    rows = tuple(
        Row(
            f"{titles[pair.first]} − {titles[pair.second]}",
            tuple(cell for one in judged for cell in _pair_cells(one.result.pairs[number], settings.star_level)),
        )
        for number, pair in enumerate(pairs)
    )
    notes = [
        "Differences of the means over all ratings, with simultaneous intervals by Tukey's honestly significant "
        f"difference ({context.level()}; Tukey-Kramer). It takes all ratings as independent, and its p values hold for "
        f"all {len(pairs)} pairs of a question together.",
        "Sign-flip: exchanges the two conditions for whole participants (their mean ratings), two-sided, "
        f"Holm-corrected for the {len(pairs)} pairs of a question. p values below {settings.star_level:g} are bold.",
    ]
    complete = judged[0].result.complete
    least = smallest_p(complete, settings) * len(pairs)
    if least >= settings.star_level:
        notes.append(
            f"With {complete} participants and {len(pairs)} pairs the smallest of the corrected sign-flip p values "
            f"cannot fall below {min(1.0, least):.2g}, so that none is below {settings.star_level:g}."
        )
    return Table(
        "Pairs of conditions",
        ("difference", "p (Tukey)", "p (sign-flip)") * len(judged),
        rows,
        groups=tuple((one.question.name, 3) for one in judged),
        facts=context.facts(),
        notes=tuple(notes),
        corner="Pair",
    )


def _pair_cells(pair: Pair, level: float) -> tuple[Cell, Cell, Cell]:
    return (
        Cell(shown(pair.difference, 2), _interval(pair.interval)),
        Cell(p_text(pair.p_tukey), best=pair.p_tukey < level),
        Cell(p_text(pair.p_participants), best=pair.p_participants < level),
    )


def _mean_frame(context: Context, judged: tuple[Judged, ...]):
    import pandas

    return pandas.DataFrame(
        [
            (context.source(), one.question.name, mean.condition, mean.ratings, mean.value, mean.deviation,
             mean.independent.low, mean.independent.high, mean.clustered.low, mean.clustered.high)
            for one in judged
            for mean in one.result.means
        ],
        columns=["answers", "question", "condition", "ratings", "mean", "deviation", "low", "high", "participants_low",
                 "participants_high"],
    )  # fmt: skip


def _test_frame(context: Context, judged: tuple[Judged, ...], overall: Alpha):
    import pandas

    lines = []
    for one in judged:
        found = one.result
        lines.append(
            {
                "answers": context.source(), "question": one.question.name, "alpha": found.alpha.value,
                "raters": found.alpha.raters, "cases": found.alpha.stimuli, "f": found.anova.statistic,
                "f_between": found.anova.freedom[0], "f_within": found.anova.freedom[1], "f_p": found.anova.p,
                "friedman": found.friedman.statistic, "friedman_freedom": found.friedman.freedom[0],
                "friedman_p": found.friedman.p,
            }
        )  # fmt: skip
    lines.append(
        {"answers": context.source(), "question": "all", "alpha": overall.value, "raters": overall.raters,
         "cases": overall.stimuli}
    )  # fmt: skip
    return pandas.DataFrame(lines)


def _pair_frame(context: Context, judged: tuple[Judged, ...]):
    import pandas

    names = [one.name for one in context.key.conditions]
    return pandas.DataFrame(
        [
            (context.source(), one.question.name, names[pair.first], names[pair.second], pair.difference,
             pair.interval.low, pair.interval.high, pair.p_tukey, pair.p_participants)
            for one in judged
            for pair in one.result.pairs
        ],
        columns=["answers", "question", "first", "second", "difference", "low", "high", "p_tukey", "p_participants"],
    )  # fmt: skip


def rating_drawings(context: Context, judged: tuple[Judged, ...]) -> tuple[Drawing, ...]:
    """The figure of the means (Sadoughi and Busso 2017, Fig. 6)."""
    level = context.settings.star_level
    rows = []
    for one in judged:
        above = _higher(one.result, level)
        rows.append(
            [
                Rating(mean.value, mean.clustered.low, mean.clustered.high, *above[number])
                for number, mean in enumerate(one.result.means)
            ]
        )
    questions = [one.question for one in judged]
    scale = min(one.minimum for one in questions), max(one.maximum for one in questions)
    names = [one.name for one in questions]
    png = rating_bars(names, _titles(context), rows, scale, "Mean ratings of the participants", context.simulated)
    caption = (
        f"Mean ratings ({listed(names)}) with {context.level()} intervals over participants. A star has the colour of "
        f"the condition that its bar is significantly higher than (p < {level:g}, Tukey's test); it is filled where "
        "the sign-flip test over participants, Holm-corrected, agrees, and hollow where it does not"
    )
    return (Drawing("ratings", Picture(png, context.titled(caption))),)


def _higher(result: Rated, level: float) -> list[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Of each condition the conditions that it is significantly higher than: by Tukey's test, and also by the other."""
    above: list[list[int]] = [[] for _ in result.means]
    firm: list[list[int]] = [[] for _ in result.means]
    for pair in result.pairs:
        if pair.p_tukey < level:
            high, low = (pair.first, pair.second) if pair.difference > 0 else (pair.second, pair.first)
            above[high].append(low)
            if pair.p_participants < level:
                firm[high].append(low)
    return [(tuple(one), tuple(other)) for one, other in zip(above, firm, strict=True)]
