"""The table of models by region of the face: Table 1 of Sadoughi and Busso (2017), with intervals and cost of training.

The figures over all test frames as one sequence in the absolute protocol are those of the paper. Further tables have
the same in the centred protocol, the means over utterances, and what the paper prints.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

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
from visualspeech.evaluation.metrics import ABSOLUTE, CENTRED, PROTOCOLS, REGIONAL, Metric, metric_named
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.statistics import BootstrapSettings, draws, figure, sample_row
from visualspeech.models.rows import ModelRow
from visualspeech.models.size import parameter_count

RUN, PUBLISHED = "run", "published"
COLUMNS = ("source", "row", "nodes", "parameters", "epochs", "seconds", "metric", "value", "low", "high")
#: Headings of measures below the name of a region.
SHORT = {"ccc": "CCC", "mse": "MSE", "gv_ratio": "GV ratio"}
#: What input blocks are computed from, in words.
KNOWN = {"text": "its words and the times of its phones", "audio": "its sound", "faces": "its recorded face"}
_TABLES = (  # title, protocol, measures of each region, ending of their names
    ("Regions of the face", ABSOLUTE, ("ccc", "mse"), ""),
    ("Regions of the face, centred", CENTRED, ("ccc", "mse", "gv_ratio"), ""),
    ("Regions of the face per turn", ABSOLUTE, ("ccc", "mse"), "_turn"),
    ("Regions of the face per turn, centred", CENTRED, ("ccc", "mse"), "_turn"),
)


@dataclass(frozen=True)
class Cost:
    """Size of a model and cost of its training; NaN where it has none.

    Parameters
    ----------
    parameters : number of numbers that its training has estimated
    epochs : of its training
    seconds : of wall-clock time that these took
    """

    parameters: float = np.nan
    epochs: float = np.nan
    seconds: float = np.nan


def cost_of(arrays: Mapping[str, np.ndarray], curve) -> Cost:
    """The cost of a model.

    Parameters
    ----------
    arrays : of its file
    curve : its learning curve, a row an epoch with the column ``seconds``, or without rows
    """
    timed = "epoch" in curve and "seconds" in curve and len(curve)
    epochs, seconds = (float(curve["epoch"].max()), float(curve["seconds"].sum())) if timed else (np.nan, np.nan)
    return Cost(float(parameter_count(arrays)), epochs, seconds)


def region_frame(
    measured: MeasuredRows,
    costs: Mapping[str, Cost],
    bootstrap: BootstrapSettings | None = None,
    paper: Published | None = None,
):
    """All figures by region as a data frame with :data:`COLUMNS`, one line per row and measure.

    Parameters
    ----------
    measured : the rows in the order of the table; repetitions are pooled
    costs : name of a row -> its cost; of repetitions, the mean is taken. Rows without one have none
    bootstrap : of the intervals
    paper : whose table of regions is added, if it has one

    Raises
    ------
    DataError
        There is no test utterance.
    """
    import pandas

    bootstrap, pooled = bootstrap or BootstrapSettings(), measured.pooled()
    drawn, cells, lines = draws(pooled.utterances, bootstrap), measured.cells(), []
    for metric in pooled.metrics(list(REGIONAL)):
        for row in pooled.rows:
            cost = _mean_cost([costs.get(one.name, Cost()) for one in cells[row.name]])
            found = figure(sample_row(pooled, row.name, metric, drawn, bootstrap), bootstrap.level)
            nodes = row.settings.get("nodes", np.nan)
            lines.append((RUN, row.name, nodes, *cost, metric.name, found.value, found.low, found.high))
    for title, nodes, parameters, figures in paper.regions.rows if paper and paper.regions else ():
        size = float(parameters.removesuffix("M")) * 1e6
        for metric, value in figures.items():
            lines.append((PUBLISHED, title, nodes, size, np.nan, np.nan, metric, value, np.nan, np.nan))
    return pandas.DataFrame(lines, columns=list(COLUMNS))


def _mean_cost(costs: Sequence[Cost]) -> tuple[float, float, float]:
    return tuple(float(np.mean([getattr(one, name) for one in costs])) for name in ("parameters", "epochs", "seconds"))


def region_tables(
    frame,
    measured: MeasuredRows,
    facts: Sequence[tuple[str, str]],
    bootstrap: BootstrapSettings,
    paper: Published | None = None,
    digits: int = 3,
    needs: Mapping[str, Sequence[str]] | None = None,
) -> tuple[Table, ...]:
    """The tables of :func:`region_frame`: in the paper's layout, centred, per turn, and as published.

    Parameters
    ----------
    frame, measured, bootstrap, paper : as made by and given to :func:`region_frame`
    facts : what the figures were computed on
    needs : input block -> what it is computed from, as for :func:`knowledge_note`
    """
    pooled = measured.pooled()
    run = {(line.row, line.metric): line for line in frame[frame["source"] == RUN].itertuples()}
    given = (("intervals", bootstrap.text(pooled)),)
    tables = []
    for title, protocol, measures, ending in _TABLES:
        grouped = regions_of(pooled, protocol, measures, ending)
        if grouped:
            first = (*facts, *given) if not tables else given
            table = _table(title, pooled, run, grouped, digits, not tables)
            notes = (*table.notes, *(() if tables else knowledge_note(pooled.rows, needs or {})))
            tables.append(replace(table, facts=(*first, ("protocol", PROTOCOLS[protocol])), notes=notes))
    if paper is not None and paper.regions is not None:
        tables.append(_published(paper))
    return tuple(tables)


def regions_of(
    measured: MeasuredRows, protocol: str, measures: Sequence[str], ending: str = ""
) -> dict[str, list[Metric]]:
    """Region -> those of the measures of one protocol that the rows have, both in order.

    Parameters
    ----------
    measures : beginnings of names: ``ccc``, ``mse``, ``gv_ratio``
    ending : of the names before that of the protocol: empty, or ``_turn``
    """
    found: dict[str, list[Metric]] = {}
    for region in dict.fromkeys(metric.region for metric in REGIONAL.values()):
        absolute = "_absolute" if protocol == ABSOLUTE else ""
        names = [f"{measure}_{region}{ending}{absolute}" for measure in measures]
        if own := measured.metrics(names, protocol):
            found[region] = own
    return found


def knowledge_note(rows: Sequence[ModelRow], needs: Mapping[str, Sequence[str]]) -> tuple[str, ...]:
    """What rows know of a test utterance, as a sentence; empty if nothing is known of the blocks that they read.

    Parameters
    ----------
    needs : input block -> what it is computed from (:func:`visualspeech.features.blocks.base.needs_of`)
    """
    found: dict[str, list[str]] = {}
    for row in rows:
        known = [text for need, text in KNOWN.items() if any(need in needs.get(name, ()) for name in row.reads)]
        if known:
            found.setdefault(" and ".join(known) if len(known) > 1 else f"{known[0]} alone", []).append(row.title)
    said = "; ".join(f"{text}: {', '.join(dict.fromkeys(titles))}" for text, titles in found.items())
    return (f"What rows know of a test utterance: {said}.",) if said else ()


def without_region(metric: Metric) -> Metric:
    """The measure with a title for a column below the name of its region."""
    return replace(
        metric, title=next(text for beginning, text in SHORT.items() if metric.name.startswith(f"{beginning}_"))
    )


def headings_of(grouped: Mapping[str, Sequence[Metric]]) -> tuple[str, ...]:
    """Headings of the columns below the names of the regions."""
    return tuple(without_region(metric).heading for own in grouped.values() for metric in own)


def groups_of(grouped: Mapping[str, Sequence[Metric]]) -> tuple[tuple[str, int], ...]:
    """The names of the regions above their columns."""
    return tuple((f"{region.capitalize()} face", len(own)) for region, own in grouped.items())


def _table(title: str, pooled: MeasuredRows, run: Mapping, grouped: Mapping, digits: int, with_cost: bool) -> Table:
    """One table; the first one has sizes and the cost of training."""
    metrics = [metric for own in grouped.values() for metric in own]
    best = {
        (row, metric.name)
        for metric in metrics
        for row in best_of(
            metric,
            {row.name: shown(run[row.name, metric.name].value, digits) for row in pooled.rows if competes(row)},
        )
    }

    def cells(row) -> tuple[Cell, ...]:
        lines = [run[row.name, metric.name] for metric in metrics]
        figures = tuple(
            Cell(
                shown(line.value, digits),
                interval(shown(line.low, digits), shown(line.high, digits)),
                best=(row.name, line.metric) in best,
            )
            for line in lines
        )
        if not with_cost:
            return figures
        size = (Cell(shown(lines[0].nodes, 0)), Cell(_thousands(lines[0].parameters)))
        return (*size, *figures, Cell(shown(lines[0].epochs, 0)), Cell(shown(lines[0].seconds, 0)))

    groups, columns = groups_of(grouped), headings_of(grouped)
    notes = ("The best value in each column is bold.", *oracle_note(pooled.rows))
    if with_cost:
        groups = (("", 2), *groups, ("Training", 2))
        columns = ("Nodes per layer", "Parameters", *columns, "Epochs", "Seconds")
        notes += (
            "Parameters are in the units of the visual coding; of a coding that divides them by their deviation over "
            "training frames, a model that gives the mean has an MSE of about 1.",
            "Seconds of training are wall-clock time on one core of the machine of this run, and the only figures here "
            "that another run does not repeat.",
        )
    return Table(
        title,
        columns,
        tuple(Row(row.title, cells(row), row.role) for row in pooled.rows),
        groups=groups,
        notes=notes,
        definitions=definitions_of(list(map(without_region, next(iter(grouped.values()))))),
    )


def _thousands(number: float) -> str:
    return "" if number != number else f"{number:,.0f}"


def _published(paper: Published) -> Table:
    """The paper's own figures, in the layout of the paper."""
    printed = paper.regions
    metrics = tuple(map(metric_named, printed.metrics))
    grouped = {one.region: [other for other in metrics if other.region == one.region] for one in metrics}
    rows = (
        Row(title, (Cell(str(nodes)), Cell(size), *(Cell(shown(of[m.name], printed.digits[m.name])) for m in metrics)))
        for title, nodes, size, of in printed.rows
    )
    return Table(
        "Regions of the face, as published",
        ("Nodes per layer", "Parameters", *headings_of(grouped)),
        tuple(rows),
        groups=(("", 2), *groups_of(grouped)),
        facts=(("source", paper.source), ("corpus of the paper", paper.corpus)),
        notes=("Over all test turns as one sequence. Figures of two corpora differ: compare the order of the rows.",),
    )
