"""Ablation: pairs of models that differ in one thing, with the paired differences of their figures."""

from collections.abc import Mapping, Sequence

from visualspeech.evaluation.layout import Cell, Row, Table, definitions_of, interval, shown
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import metric_named
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample_row

COLUMNS = ("row", "column", "model", "metric", "value", "low", "high", "difference", "difference_low",
           "difference_high")  # fmt: skip


def ablation_frame(
    measured: MeasuredRows,
    columns: Sequence[str],
    rows: Mapping[str, Sequence[str]],
    metrics: Sequence[str],
    bootstrap: BootstrapSettings | None = None,
):
    """Figures of models and their differences to the first model of their row: a data frame with :data:`COLUMNS`.

    Parameters
    ----------
    measured : the models; repetitions are pooled, and their spread is part of the intervals
    columns : what the models of a row have or lack, the reference first
    rows : heading -> cell of the model in each column
    metrics : names of measures
    bootstrap : of the intervals; those of differences are paired
    """
    import pandas

    bootstrap = bootstrap or BootstrapSettings()
    measured = measured.pooled()
    drawn, lines = draws(measured.utterances, bootstrap), []
    for row, models in rows.items():
        for metric in map(metric_named, metrics):
            sampled = [sample_row(measured, model, metric, drawn, bootstrap) for model in models]
            for column, model, own in zip(columns, models, sampled, strict=True):
                value = figure(own, bootstrap.level)
                between = Sampled(own.value - sampled[0].value, own.samples - sampled[0].samples)
                difference = figure(between, bootstrap.level)
                lines.append(
                    (row, column, model, metric.name, value.value, value.low, value.high, difference.value,
                     difference.low, difference.high)
                )  # fmt: skip
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def ablation_tables(
    frame, measured: MeasuredRows, facts: Sequence[tuple[str, str]], bootstrap: BootstrapSettings, digits: int = 3
) -> tuple[Table, ...]:
    """The table of :func:`ablation_frame`: for each row its models, and the differences to the first of them.

    Parameters
    ----------
    measured, bootstrap : as given to :func:`ablation_frame`
    facts : what the figures were computed on
    """
    metrics = tuple(map(metric_named, dict.fromkeys(frame["metric"])))
    columns = list(dict.fromkeys(frame["column"]))
    found = {(line.row, line.column, line.metric): line for line in frame.itertuples()}
    rows = []
    for row in dict.fromkeys(frame["row"]):
        rows.append(Row(row))
        rows += [Row(one, tuple(_value(found[row, one, m.name], digits) for m in metrics)) for one in columns]
        rows += [
            Row(f"{one} minus {columns[0]}", tuple(_difference(found[row, one, m.name], digits) for m in metrics))
            for one in columns[1:]
        ]
    table = Table(
        "Ablation",
        tuple(metric.heading for metric in metrics),
        tuple(rows),
        facts=(*facts, ("intervals", bootstrap.text(measured.pooled()))),
        notes=("Intervals of differences are paired. A difference is bold if its interval excludes 0.",),
        definitions=definitions_of(metrics),
    )
    return (table,)


def _value(line, digits: int) -> Cell:
    return Cell(shown(line.value, digits), interval(shown(line.low, digits), shown(line.high, digits)))


def _difference(line, digits: int) -> Cell:
    low, high = line.difference_low, line.difference_high
    text = interval(shown(low, digits), shown(high, digits))
    return Cell(shown(line.difference, digits), text, best=bool(low > 0 or high < 0))
