"""The result table of a system: every row with every measure, and errors as ratios to the training mean."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

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
from visualspeech.evaluation.metrics import METRICS, PROTOCOLS, Metric
from visualspeech.evaluation.selection_settings import NAMED
from visualspeech.evaluation.statistics import BootstrapSettings, summarise
from visualspeech.fields import Settings, setting

#: Columns of the summary for each row and measure; the columns of the TSV file are named after them.
PARTS = ("value", "low", "high", "ratio", "ratio_low", "ratio_high")


@dataclass(frozen=True)
class TableSettings(Settings):
    """Content of the result tables."""

    section = "tables"
    metrics: tuple[str, ...] = setting(
        tuple(
            name
            for name, metric in METRICS.items()
            if not metric.region and not name.startswith("ccc") and "first5" not in name
        ),
        "Measures shown, in the order of the columns; those of the absolute protocol in a table of their own, and only "
        "where they are defined.",
        item=NAMED,
        min_items=1,
        max_items=100,
        unique=True,
    )
    digits: int = setting(3, "Number of decimals of the measures.", minimum=0, maximum=12)
    ratio_digits: int = setting(3, "Number of decimals of the ratios to the training mean.", minimum=0, maximum=12)


def result_tables(
    measured: MeasuredRows,
    facts: Sequence[tuple[str, str]],
    settings: TableSettings | None = None,
    bootstrap: BootstrapSettings | None = None,
):
    """The result table of all rows, as a data frame and as tables for readers.

    Parameters
    ----------
    measured : the rows in the order of the table, with the training mean
    facts : what the figures were computed on (:meth:`visualspeech.evaluation.facts.TableFacts.lines`)
    settings, bootstrap : what is shown, and how the intervals are drawn

    Returns
    -------
    tuple
        a data frame with one line per row (column ``row``), where repetitions are pooled to one row and each stands
        below as well under the name ``<cell>-s<seed>``, and the columns ``metric``, ``metric_low``, ``metric_high``,
        ``metric_ratio``, ``metric_ratio_low``, ``metric_ratio_high`` of each measure, as text rounded to the digits
        shown; and :class:`Table`: for each protocol the figures, ratios to the training mean, and, where rows have
        several seeds, the figures of each

    Raises
    ------
    SettingError, DataError
        As :func:`visualspeech.evaluation.statistics.summarise`.
    """
    settings, bootstrap = settings or TableSettings(), bootstrap or BootstrapSettings()
    metrics, seeds, pooled = tuple(measured.metrics(settings.metrics)), measured.single(), measured.pooled()
    cells = _cells(pooled, metrics, settings, bootstrap)
    each = seeds and _cells(_with_base(seeds, measured), metrics, settings, bootstrap)
    tables = []
    for protocol, text in PROTOCOLS.items():
        part = tuple(metric for metric in metrics if metric.protocol == protocol)
        if part:
            lines = (*facts, ("protocol", text), ("intervals", bootstrap.text(pooled)), *_undefined(pooled, part))
            tables += _pair(pooled, part, cells, f"Objective measures, {protocol}", lines)
            tables += [_of_seeds(seeds, part, each, f"Objective measures, {protocol}")] if seeds else []
    frames = [_frame(pooled, metrics, cells)] + ([_frame(seeds, metrics, each)] if seeds else [])
    return _joined(frames), tuple(tables)


def _cells(measured: MeasuredRows, metrics, settings: TableSettings, bootstrap: BootstrapSettings) -> Mapping:
    """(row, measure) -> part of the summary -> text."""
    digits = {part: settings.ratio_digits if part.startswith("ratio") else settings.digits for part in PARTS}
    return {
        (line.row, line.metric): {part: shown(getattr(line, part), digits[part]) for part in PARTS}
        for line in summarise(measured, [metric.name for metric in metrics], bootstrap).itertuples()
    }


def _with_base(seeds: MeasuredRows, measured: MeasuredRows) -> MeasuredRows:
    """The seeds and the training mean, to which ratios are taken."""
    base = measured.base
    return MeasuredRows((*seeds.rows, base), {**seeds.tables, base.name: measured.tables[base.name]})


def _of_seeds(seeds: MeasuredRows, metrics, cells: Mapping, title: str) -> Table:
    """The figures of each seed of the pooled rows."""
    return Table(
        f"{title}: each seed",
        tuple(metric.heading for metric in metrics),
        _rows(seeds, metrics, cells, "value", frozenset()),
        notes=("Intervals are over utterances alone.",),
        metrics=tuple(metric.name for metric in metrics),
    )


def _pair(measured: MeasuredRows, metrics, cells: Mapping, title: str, facts) -> tuple[Table, Table]:
    """The table of figures of one protocol, and that of their ratios to the training mean."""
    base = measured.base.title.lower()
    figures = Table(
        title,
        tuple(metric.heading for metric in metrics),
        _rows(measured, metrics, cells, "value", best_cells(measured, metrics, cells)),
        facts=facts,
        notes=("The best value in each column is bold.", *oracle_note(measured.rows)),
        metrics=tuple(metric.name for metric in metrics),
        ranked=True,
    )
    ratios = Table(
        f"{title}: ratio to the {base}",
        tuple(metric.title for metric in metrics),
        _rows(measured, metrics, cells, "ratio", frozenset()),
        notes=_note(base, [cells[row.name, metric.name] for row in measured.rows for metric in metrics]),
        definitions=definitions_of(metrics),
        metrics=tuple(metric.name for metric in metrics),
        ratios=True,
    )
    return figures, ratios


def best_cells(measured: MeasuredRows, metrics: Sequence[Metric], cells: Mapping) -> frozenset[tuple[str, str]]:
    """The (row, metric) pairs with the best figures, without those of rows that are computed from the truth."""
    rows = [row.name for row in measured.rows if competes(row)]
    return frozenset(
        (row, metric.name)
        for metric in metrics
        for row in best_of(metric, {row: cells[row, metric.name]["value"] for row in rows})
    )


def _rows(measured: MeasuredRows, metrics, cells, part: str, best: frozenset) -> tuple[Row, ...]:
    low, high = ("low", "high") if part == "value" else ("ratio_low", "ratio_high")
    return tuple(
        Row(
            measured.title(row),
            tuple(
                Cell(cell[part], interval(cell[low], cell[high]), best=(row.name, metric.name) in best)
                for metric in metrics
                for cell in (cells[row.name, metric.name],)
            ),
            row.role,
            row.name,
        )
        for row in measured.rows
    )


def _frame(measured: MeasuredRows, metrics, cells):
    import pandas

    columns = {"row": [row.name for row in measured.rows]}
    for metric in metrics:
        for part in PARTS:
            name = metric.name if part == "value" else f"{metric.name}_{part}"
            columns[name] = [cells[row.name, metric.name][part] for row in measured.rows]
    return pandas.DataFrame(columns)


def _joined(frames: Sequence):
    import pandas

    return frames[0] if len(frames) == 1 else pandas.concat(frames, ignore_index=True)


def _undefined(measured: MeasuredRows, metrics) -> tuple[tuple[str, str], ...]:
    """The number of frames with undefined correlation by row; empty if there are none."""
    if not any(metric.name == "corr" for metric in metrics):
        return ()
    counts = {row.title: measured.tables[row.name]["corr_undefined"].sum() for row in measured.rows}
    text = ", ".join(f"{title} {count:.4g}" for title, count in counts.items() if count)
    return (("frames with undefined correlation, counted as 0", text),) if text else ()


def _note(base: str, cells: Sequence[Mapping]) -> tuple[str, ...]:
    """Why ratios are missing; empty if none is."""
    if all(cell["ratio"] for cell in cells):
        return ()
    return (
        f"Ratios are given for errors only: the {base} has no variance over time, and no correlation. No ratio is "
        "given where the interval of its error includes 0.",
    )
