"""Tables of chosen rows and measures: mean and deviation over utterances, paired differences, published figures.

A paper's table is a selection of the rows of a system. Its figures are means over utterances with their standard
deviation, as papers print them. Where it is asked for, a second table shows the figures of the corpus with their
intervals, and the paired differences to one of the rows.
"""

from collections.abc import Sequence

import numpy as np

from visualspeech.evaluation.layout import (
    Cell,
    Row,
    Table,
    best_of,
    competes,
    definitions_of,
    interval,
    oracle_note,
    shown,
)
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import Metric, metric_named, over_utterances
from visualspeech.evaluation.published_results import Published, PublishedSelection
from visualspeech.evaluation.selection_settings import SelectionSettings
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample_row
from visualspeech.models.rows import ModelRow

RUN, PUBLISHED = "run", "published"
COLUMNS = ("source", "row", "metric", "mean", "deviation", "value", "low", "high", "reference", "difference",
           "difference_low", "difference_high")  # fmt: skip


def selection_frame(
    measured: MeasuredRows,
    settings: SelectionSettings,
    bootstrap: BootstrapSettings | None = None,
    paper: PublishedSelection | None = None,
):
    """All figures of a selection as a data frame with :data:`COLUMNS`, one line per row and measure.

    Parameters
    ----------
    measured : the chosen rows in the order of the table; repetitions are pooled
    settings : of the table; ``reference`` is the name of a row, or empty
    bootstrap : of the intervals; those of differences are paired
    paper : what the paper prints in this table, if anything: ``mean`` and ``deviation`` of rows of its own

    Raises
    ------
    SettingError
        A measure is unknown.
    DataError
        There is no test utterance.
    """
    import pandas

    bootstrap, pooled = bootstrap or BootstrapSettings(), measured.pooled()
    drawn, lines = draws(pooled.utterances, bootstrap), []
    for metric in map(metric_named, dict.fromkeys((*settings.metrics, *settings.intervals))):
        sampled = {name: sample_row(pooled, name, metric, drawn, bootstrap) for name in pooled.tables}
        base = sampled.get(settings.reference)
        for name, own in sampled.items():
            value = figure(own, bootstrap.level)
            spread = over_utterances(pooled.tables[name], metric)
            line = (RUN, name, metric.name, *spread, value.value, value.low, value.high)
            if base is None:
                lines.append((*line, "", np.nan, np.nan, np.nan))
            else:
                between = figure(Sampled(own.value - base.value, own.samples - base.samples), bootstrap.level)
                lines.append((*line, settings.reference, between.value, between.low, between.high))
    for row, figures in (paper.figures if paper else {}).items():
        for metric, (mean, deviation) in figures.items():
            lines.append((PUBLISHED, row, metric, mean, deviation, *[np.nan] * 3, "", *[np.nan] * 3))
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def selection_tables(
    frame,
    measured: MeasuredRows,
    settings: SelectionSettings,
    name: str,
    facts: Sequence[tuple[str, str]],
    bootstrap: BootstrapSettings,
    paper: Published | None = None,
    digits: int = 3,
) -> tuple[Table, ...]:
    """The tables of :func:`selection_frame`: over utterances, with intervals, as published.

    Parameters
    ----------
    frame, measured, settings, bootstrap : as made by and given to :func:`selection_frame`
    name : of the selection, by which the published one is found
    facts : what the figures were computed on
    paper : source of the published figures, if there are any
    """
    pooled, title = measured.pooled(), settings.title or name
    run = {(line.row, line.metric): line for line in frame[frame["source"] == RUN].itertuples()}
    metrics = tuple(map(metric_named, settings.metrics))
    best = {
        (row, metric.name)
        for metric in metrics
        for row in best_of(
            metric,
            {row.name: shown(run[row.name, metric.name].mean, digits) for row in pooled.rows if competes(row)},
        )
    }

    def cell(row: ModelRow, metric: Metric) -> Cell:
        line = run[row.name, metric.name]
        return _spread(line.mean, line.deviation, digits, best=(row.name, metric.name) in best)

    notes = (
        "Mean and standard deviation over test utterances. The best mean of each measure is bold.",
        *oracle_note(pooled.rows),
        *settings.notes,
    )
    first = Table(
        title,
        *_arranged(pooled.rows, metrics, settings, cell),
        facts=tuple(facts),
        notes=notes,
        definitions=definitions_of(metrics),
        corner=settings.down and f"{settings.down} / {settings.across}",
        metrics=tuple(metric.name for metric in metrics) if not settings.across else (),
        ranked=not settings.across,
    )
    tables = [first]
    if settings.intervals:
        tables.append(_with_intervals(run, pooled, settings, title, bootstrap, digits))
    printed = paper.selections.get(name) if paper else None
    if printed:
        tables.append(_published(printed, title, paper))
    return tuple(tables)


def _arranged(rows: Sequence[ModelRow], metrics: Sequence[Metric], settings: SelectionSettings, cell) -> tuple:
    """Columns, rows and groups of a table: a line per row, or one setting down and another across."""
    headings = tuple(metric.heading for metric in metrics)
    if not settings.across:
        return (
            headings,
            tuple(Row(row.title, tuple(cell(row, m) for m in metrics), row.role, row.name) for row in rows),
            (),
        )
    found = {(row.settings.get(settings.down), row.settings.get(settings.across)): row for row in rows}
    down, across = (list(dict.fromkeys(key[number] for key in found)) for number in range(2))
    lines = tuple(
        Row(
            str(one),
            tuple(
                cell(found[one, other], metric) if (one, other) in found else Cell("")
                for other in across
                for metric in metrics
            ),
        )
        for one in down
    )
    return headings * len(across), lines, tuple((str(other), len(metrics)) for other in across)


def _with_intervals(
    run, pooled: MeasuredRows, settings, title: str, bootstrap: BootstrapSettings, digits: int
) -> Table:
    """Figures of the corpus with intervals, and differences to the reference."""
    metrics, titles = tuple(map(metric_named, settings.intervals)), pooled.titles
    reference = titles.get(settings.reference, "")
    rows = []
    for row in pooled.rows:
        cells = []
        for metric in metrics:
            line = run[row.name, metric.name]
            cells.append(Cell(shown(line.value, digits), _interval(line.low, line.high, digits)))
            if reference:
                low, high = line.difference_low, line.difference_high
                own = row.name == settings.reference
                excludes = bool(low > 0 or high < 0)
                text = "" if own else shown(line.difference, digits)
                cells.append(Cell(text, "" if own else _interval(low, high, digits), best=not own and excludes))
        rows.append(Row(row.title, tuple(cells), row.role, row.name))
    difference = ("difference",) if reference else ()
    marked = f"Differences are to “{reference}”, paired over utterances, and bold if their interval excludes 0."
    return Table(
        f"{title}: figures of the corpus",
        tuple(heading for metric in metrics for heading in (metric.heading, *difference)),
        tuple(rows),
        facts=(
            ("protocol", ", ".join(dict.fromkeys(m.protocol for m in metrics))),
            ("intervals", bootstrap.text(pooled)),
        ),
        notes=((marked,) if reference else ()) + oracle_note(pooled.rows),
        definitions=definitions_of(metrics),
        metrics=tuple(metric.name for metric in metrics for _ in range(1 + bool(reference))),
    )


def _published(printed: PublishedSelection, title: str, paper: Published) -> Table:
    """The paper's own figures, in the layout of the paper."""
    metrics = tuple(map(metric_named, printed.metrics))
    rows = tuple(
        Row(row, tuple(_spread(*figures[m.name], printed.digits[m.name]) for m in metrics))
        for row, figures in printed.figures.items()
    )
    return Table(
        f"{title}, as published",
        tuple(metric.heading for metric in metrics),
        rows,
        facts=(("source", paper.source), ("corpus of the paper", paper.corpus)),
        notes=(
            "Mean and standard deviation over the paper's test utterances. Figures of two corpora are in different "
            "units: compare the order of the rows.",
            *printed.notes,
        ),
    )


def _spread(mean: float, deviation: float, digits: int, best: bool = False) -> Cell:
    text = shown(deviation, digits)
    return Cell(shown(mean, digits), f"± {text}" if text else "", best=best)


def _interval(low: float, high: float, digits: int) -> str:
    return interval(shown(low, digits), shown(high, digits))
