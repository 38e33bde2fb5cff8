"""Table 1 of Fan et al. (2015) from our networks, beside the figures that the paper prints."""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.evaluation.published_results import Published
from visualspeech.evaluation.repetitions import mean_and_deviation
from visualspeech.evaluation.sheets import Cell, Sheet
from visualspeech.evaluation.statistics import BASE_ROW
from visualspeech.evaluation.table_formats import column_title
from visualspeech.naming import cells_of, parse_name

#: The measures of Table 1, in its order.
PAPER_METRICS = ("rmse_shape", "rmse_texture", "rmse_appearance", "corr")
COLUMNS = ("source", "topology", "nodes", "metric", "value", "deviation", "ratio", "ratio_deviation", "seeds",
           "collapsed", "best")  # fmt: skip
OURS, PAPER = "ours", "published"

#: A network that learned nothing predicts one face whatever is said: its error is the training mean's, its
#: correlation is chance. Between the paper's collapsed cells (up to .03) and its worst others (.19 and .43) lies .1.
LEAST_CORRELATION = 0.1
LEAST_GAIN = 0.02


def is_collapsed(correlation: float, ratio: float) -> bool:
    """Whether a network has collapsed to the mean predictor.

    Parameters
    ----------
    correlation : its CORR (Eq. 19)
    ratio : its RMSE(appearance) over that of the training mean
    """
    return bool(abs(correlation) < LEAST_CORRELATION and ratio > 1 - LEAST_GAIN)


def topology_frame(tables: Mapping[str, object], paper: Published | None = None):
    """All figures of the table of topologies as a data frame with :data:`COLUMNS`, a line a cell and measure.

    Our figures are means over the seeds of a cell with the sample standard deviation (NaN of one seed); ``collapsed``
    counts the seeds that collapsed to the mean predictor. Ratios are given of errors and are to the training mean. The
    paper prints no such row: :func:`stand_in` serves instead. ``best`` marks the best of each measure and source.

    Parameters
    ----------
    tables : row name -> per-utterance table, with the training mean's; rows that are no network are left out
    paper : the published figures, if there are any

    Raises
    ------
    DataError
        The training mean is missing.
    """
    import pandas

    if BASE_ROW not in tables:
        raise DataError(f"the row `{BASE_ROW}` is missing; every network is shown as a ratio to it.")
    base = {metric: corpus_figure(tables[BASE_ROW], metric) for metric in PAPER_METRICS}
    lines = []
    for cell, names in cells_of(tables).items():
        repetitions = [tables[name] for name in names]
        place = (OURS, parse_name(cell).row, parse_name(cell).nodes)
        collapsed = sum(
            is_collapsed(
                corpus_figure(table, "corr"), corpus_figure(table, "rmse_appearance") / base["rmse_appearance"]
            )
            for table in repetitions
        )
        for metric in PAPER_METRICS:
            figure = mean_and_deviation(repetitions, metric)
            ratio = [part / base[metric] if METRICS[metric].best == "low" else np.nan for part in figure]
            lines.append((*place, metric, *figure, *ratio, len(names), collapsed, False))
    if paper is not None:
        lines += _published_lines(paper)
    return _with_best(pandas.DataFrame(lines, columns=list(COLUMNS)))


def stand_in(paper: Published) -> dict[str, float]:
    """The figures that serve as the training mean's of a paper that prints none, by measure; empty where none can.

    A network that predicts one constant face has a CORR of about 0. The paper's cells with a CORR below .1 agree in
    their errors within 1 in 300, as predictors of one and the same constant must; the median of their errors is taken.
    It is an inference from the paper's table and not a figure of it.
    """
    flat = [cell for cell in paper.topologies.values() if abs(cell["corr"]) < LEAST_CORRELATION]
    errors = [metric for metric in paper.metrics if METRICS[metric].best == "low"]
    return {metric: float(np.median([cell[metric] for cell in flat])) for metric in errors} if flat else {}


def _published_lines(paper: Published) -> list[tuple]:
    base, lines = stand_in(paper), []
    for (stack, nodes), figures in paper.topologies.items():
        ratio = figures["rmse_appearance"] / base["rmse_appearance"] if base else 0.0
        collapsed = int(is_collapsed(figures["corr"], ratio))
        for metric in paper.metrics:
            of_base = figures[metric] / base[metric] if metric in base else np.nan
            lines.append((PAPER, stack, nodes, metric, figures[metric], np.nan, of_base, np.nan, 1, collapsed, False))
    return lines


def _with_best(frame):
    cost = frame["value"].where(frame["metric"].map(lambda name: METRICS[name].best == "low"), -frame["value"])
    least = cost.groupby([frame["source"], frame["metric"]]).transform("min")
    return frame.assign(best=cost == least)


def agreement(frame) -> tuple[float, int]:
    """Spearman's rank correlation of our RMSE(appearance) with the paper's, and over how many cells.

    Cells that collapsed in either are left out: their order is chance. NaN of fewer than four cells.
    """
    from scipy.stats import spearmanr

    errors = frame[(frame["metric"] == "rmse_appearance") & (frame["collapsed"] == 0)]
    ours, theirs = (
        errors[errors["source"] == source].set_index(["topology", "nodes"])["value"] for source in (OURS, PAPER)
    )
    common = [cell for cell in ours.index if cell in theirs.index]
    if len(common) < 4:
        return float("nan"), len(common)
    return float(spearmanr(ours[common], theirs[common]).statistic), len(common)


def topology_sheets(
    frame, facts: Sequence[tuple[str, str]], paper: Published | None = None, digits: int = 3, ratio_digits: int = 3
) -> tuple[Sheet, ...]:
    """The table in the paper's layout: nodes across, topologies down, four measures each; figures, then ratios.

    Parameters
    ----------
    frame : from :func:`topology_frame`
    facts : what our figures were computed on
    paper : source of the published figures, for the notes
    digits, ratio_digits : after the point
    """
    sheets = []
    for source, title in ((OURS, "Networks by topology and nodes"), (PAPER, "The same as published")):
        part = frame[frame["source"] == source]
        if not len(part):
            continue
        notes = _notes(part, source, paper)
        if source == PAPER:
            facts = (("source", paper.source), ("its corpus", paper.corpus))
        elif (found := agreement(frame))[0] == found[0]:
            text = f"{found[0]:.2f} over {found[1]} cells"
            facts = (*facts, ("rank correlation of RMSE(appearance) with the published one", text))
        sheets.append(_sheet(part, "value", PAPER_METRICS, digits, title, facts, notes))
        errors = [metric for metric in PAPER_METRICS if METRICS[metric].best == "low"]
        if part["ratio"].notna().any():
            to = "training mean" if source == OURS else "cells that collapsed to a mean predictor"
            sheets.append(_sheet(part, "ratio", errors, ratio_digits, f"{title}: ratio to the {to}", (), ()))
    return tuple(sheets)


def _sheet(part, column: str, metrics, digits: int, title: str, facts, notes) -> Sheet:
    widths = sorted(part["nodes"].unique())
    topologies = list(dict.fromkeys(part["topology"]))
    found = {(row.topology, row.nodes, row.metric): row for row in part.itertuples()}
    rows = [
        (
            topology.replace("-rich", " (richer labels)"),
            tuple(
                _cell(found.get((topology, nodes, metric)), column, digits) for nodes in widths for metric in metrics
            ),
        )
        for topology in topologies
    ]
    return Sheet(
        title=title,
        columns=tuple(column_title(METRICS[metric]) for _ in widths for metric in metrics),
        rows=tuple(rows),
        groups=tuple((str(nodes), len(metrics)) for nodes in widths),
        facts=tuple(facts),
        notes=tuple(notes),
        corner="Nodes",
    )


def _cell(row, column: str, digits: int) -> Cell:
    if row is None or getattr(row, column) != getattr(row, column):
        return Cell("")
    deviation = getattr(row, "deviation" if column == "value" else "ratio_deviation")
    small = f"± {deviation:.{digits}f}" if deviation == deviation else ""
    if row.collapsed and row.seeds > 1:
        small += f" ({row.collapsed} of {row.seeds} seeds)"
    return Cell(f"{getattr(row, column):.{digits}f}", small.strip(), bool(row.best), bool(row.collapsed))


def _notes(part, source: str, paper: Published | None) -> list[str]:
    notes = ["The best figure of each measure is bold."]
    if part["seeds"].max() > 1:
        notes.append(f"Mean and standard deviation over {part['seeds'].max()} seeds.")
    if (part["collapsed"] > 0).any():
        cells = part.loc[part["collapsed"] > 0, ["topology", "nodes"]].drop_duplicates()
        notes.append(
            f"† {len(cells)} of {len(part[['topology', 'nodes']].drop_duplicates())} cells collapsed to the mean "
            f"predictor: |CORR| below {LEAST_CORRELATION:g} and RMSE(appearance) less than {LEAST_GAIN:.0%} better "
            "than the training mean's. Such a network shows one face whatever is said."
        )
    if source == PAPER:
        base = stand_in(paper)
        if base:
            figures = ", ".join(f"{METRICS[metric].title} {value:.3f}" for metric, value in base.items())
            notes.append(
                "The paper prints no row of the training mean. Its cells with a CORR of about 0 agree in their errors, "
                f"as predictors of one constant face do; their median ({figures}) stands for that row in the ratios. "
                "This is inferred from the table and is no figure of the paper."
            )
        if len(paper.stacks) * len(paper.nodes) > len(paper.topologies):
            notes.append(
                f"The paper trained {len(paper.stacks) * len(paper.nodes)} networks and prints the "
                f"{len(paper.topologies)} of three layers."
            )
        notes.append("Figures of two corpora are in different units: compare ratios and ranks.")
    return notes
