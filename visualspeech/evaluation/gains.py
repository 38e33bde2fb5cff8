"""Gains of the best network over reference models, as in Table 3 of Fan et al. (2015), with confidence intervals."""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.comparisons import ComparisonSettings, holm, paired_test
from visualspeech.evaluation.layout import Cell, Row, Table, interval
from visualspeech.evaluation.measured import MeasuredRows, cells_of
from visualspeech.evaluation.metrics import METRICS, Metric, corpus_figure, metric_named, statistics_of
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.statistics import BootstrapSettings, Sampled, draws, figure, sample_row
from visualspeech.models.rows import ModelRow

RUN, PUBLISHED = "run", "published"
COLUMNS = ("source", "row", "metric", "value", "low", "high", "gain", "gain_low", "gain_high", "p", "p_holm",
           "significant")  # fmt: skip


def best_cell(rows: Sequence[ModelRow], validation: Mapping[str, object], metric: str = "rmse_appearance") -> str:
    """The cell with the lowest centred RMSE(appearance) on the validation utterances among the candidates.

    It is chosen on the validation utterances, so that its figures on the test utterances are not biased by the choice.
    Figures of the seeds of one cell are averaged.

    Parameters
    ----------
    rows : of which the candidates are those in ``validation``
    validation : name of a candidate -> statistics of the validation utterances
    metric : another measure to choose by

    Raises
    ------
    DataError
        There is no candidate.
    """
    ranked = ranked_cells(rows, validation, METRICS[metric])
    if not ranked:
        raise DataError("the table of gains has no candidate. Name a model in the settings of the tables.")
    return ranked[0]


def ranked_cells(rows: Sequence[ModelRow], validation: Mapping[str, object], metric: Metric) -> list[str]:
    """The cells of the candidates, those in ``validation``, from the best figure to the worst.

    Figures of the seeds of one cell are averaged. Cells with an undefined figure come last.
    """
    costs = {
        cell: float(np.mean([metric.cost(corpus_figure(validation[row.name], metric.name)) for row in repetitions]))
        for cell, repetitions in cells_of([row for row in rows if row.name in validation]).items()
    }
    return sorted(costs, key=lambda cell: (np.isnan(costs[cell]), costs[cell]))


def rows_of_gains(measured: MeasuredRows, best: str, references: Sequence[str]) -> MeasuredRows:
    """The rows of the table: the reference models and the best cell.

    Raises
    ------
    DataError
        There is no reference.
    """
    if not references:
        raise DataError("the table of gains has no reference model. Name one in the settings of the tables.")
    return measured.where(lambda row: row.name in references or (row.cell or row.name) == best)


def gains_frame(
    measured: MeasuredRows,
    best: str,
    metrics: Sequence[str],
    paper: Published | None = None,
    settings: ComparisonSettings | None = None,
    bootstrap: BootstrapSettings | None = None,
):
    """Figures of the reference models and of the best network as a data frame with :data:`COLUMNS`.

    ``gain`` is the gain of the network over a reference: for errors the share by which the error is lower (``1 -
    network / reference``), for other measures the difference. Its interval is a paired one. P values are Holm-corrected
    over all lines; ``significant`` is 1 where one is below the level and the test agrees with the gain in direction.
    Published rows have a value and a gain only.

    Parameters
    ----------
    measured : from :func:`rows_of_gains`; repetitions are pooled
    best : the cell that the others are compared with
    metrics : names of measures
    """
    import pandas

    settings, bootstrap = settings or ComparisonSettings(), bootstrap or BootstrapSettings()
    measured = measured.pooled()
    drawn, lines, tested = draws(measured.utterances, bootstrap), [], []
    for row in _best_last([row.name for row in measured.rows], best):
        for metric in map(metric_named, metrics):
            own, of_best = (sample_row(measured, one, metric, drawn, bootstrap) for one in (row, best))
            shown, gain = figure(own, bootstrap.level), (np.nan,) * 3
            if row != best:
                found = figure(_gain(metric, of_best, own), bootstrap.level)
                gain = (found.value, found.low, found.high)
                statistics = [statistics_of(measured.tables[one], metric) for one in (best, row)]
                # A row has its lower costs where the network gains.
                p, direction = paired_test(metric, *statistics, settings)
                agrees = direction * np.sign(metric.cost(of_best.value) - metric.cost(own.value)) > 0
                tested.append((p, agrees))
            lines.append((RUN, row, metric.name, shown.value, shown.low, shown.high, *gain))
    missing, p = [np.nan] * len(metrics), np.array([one[0] for one in tested])
    corrected = holm(p)
    significant = [float(value < settings.level and one[1]) for value, one in zip(corrected, tested, strict=True)]
    parts = {"p": p, "p_holm": corrected, "significant": significant}
    frame = pandas.DataFrame(lines, columns=list(COLUMNS[:9]))
    frame = frame.assign(**{name: [*values, *missing] for name, values in parts.items()})
    return pandas.concat([frame, _published_frame(paper)], ignore_index=True) if paper and paper.gains else frame


def _best_last(rows: Sequence[str], best: str) -> list[str]:
    return [*(row for row in rows if row != best), best]


def _gain(metric: Metric, network: Sampled, reference: Sampled) -> Sampled:
    if metric.is_error:
        return Sampled(1 - network.value / reference.value, 1 - network.samples / reference.samples)
    return Sampled(network.value - reference.value, network.samples - reference.samples)


def _published_frame(paper: Published):
    import pandas

    best, lines = paper.gains[paper.best], []
    for row in _best_last(list(paper.gains), paper.best):
        for metric, value in paper.gains[row].items():
            gain = np.nan
            if row != paper.best:
                gain = 1 - best[metric] / value if METRICS[metric].is_error else best[metric] - value
            lines.append({"source": PUBLISHED, "row": row, "metric": metric, "value": value, "gain": gain})
    return pandas.DataFrame(lines, columns=list(COLUMNS)).astype({name: float for name in COLUMNS[3:]})


def gains_tables(
    frame,
    measured: MeasuredRows,
    best: str,
    facts: Sequence[tuple[str, str]],
    paper: Published | None,
    settings: ComparisonSettings,
    digits: int = 3,
) -> tuple[Table, ...]:
    """The table in the paper's layout, of the run and as published, each followed by the gains of the network.

    Parameters
    ----------
    frame, measured, best : as made by and given to :func:`gains_frame`
    facts : what the figures of the run were computed on
    settings : those of the tests
    """
    titles = measured.pooled().titles
    title = titles[best]
    notes = (
        "The best value in each column is bold.",
        f"{title} is the candidate with the lowest centred RMSE(appearance) on the validation utterances. Intervals "
        "are those of the other tables.",
    )
    note = (
        "For errors, the share by which the network's error is lower; for other measures, the difference; with paired "
        f"bootstrap intervals. A gain is bold if the Holm-corrected p value of a paired test over utterances is below "
        f"{settings.level:g} and the test agrees with the gain in direction."
    )
    heading = "Best network and reference models"
    titles |= {best: f"Best network ({title})"}
    tables = _tables(frame[frame["source"] == RUN], heading, titles, facts, (notes, (note,)), digits)
    part = frame[frame["source"] == PUBLISHED]
    if len(part):
        source, notes = (("source", paper.source),), (notes[:1], ("The paper gives no intervals.",))
        tables += _tables(part, f"{heading} as published", {}, source, notes, digits)
    return tuple(tables)


def _tables(part, heading: str, titles: Mapping[str, str], facts, notes, digits: int) -> list[Table]:
    """The table of figures, and the table of the last row's gains over the others; ``notes`` has those of both."""
    found = {(row.row, row.metric): row for row in part.itertuples()}
    rows, metrics = (list(dict.fromkeys(part[column])) for column in ("row", "metric"))
    best = {m: min(rows, key=lambda row: METRICS[m].cost(found[row, m].value)) for m in metrics}  # noqa: B023
    figures = [
        Row(titles.get(row, row), tuple(_figure(found[row, m], best[m] == row, digits) for m in metrics))
        for row in rows
    ]
    gains = [Row(titles.get(row, row), tuple(_shown_gain(found[row, m]) for m in metrics)) for row in rows[:-1]]
    return [
        Table(heading, tuple(METRICS[m].heading for m in metrics), tuple(figures), facts=tuple(facts), notes=notes[0]),
        Table(
            f"{heading}: gain", tuple(METRICS[m].title for m in metrics), tuple(gains), notes=notes[1], corner="over"
        ),
    ]


def _figure(row, best: bool, digits: int) -> Cell:
    return Cell(f"{row.value:.{digits}f}", _interval(row.low, row.high, f"{{:.{digits}f}}".format), best=best)


def _shown_gain(row) -> Cell:
    form = ("{:.1%}" if METRICS[row.metric].is_error else "{:.3f}").format
    return Cell(form(row.gain), _interval(row.gain_low, row.gain_high, form), best=bool(row.significant == 1))


def _interval(low: float, high: float, form) -> str:
    return interval(form(low), form(high)) if low == low else ""
