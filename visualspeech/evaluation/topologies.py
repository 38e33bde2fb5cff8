"""Networks by topology and width, as in Table 1 of Fan et al. (2015), with published figures."""

from collections.abc import Sequence

import numpy as np

from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS, corpus_figure
from visualspeech.evaluation.published_results import Published
from visualspeech.models.rows import ModelRow

FAMILY = "stack"
COLUMNS = ("source", "group", "topology", "nodes", "metric", "value", "deviation", "ratio", "ratio_deviation", "seeds",
           "collapsed", "best")  # fmt: skip
RUN, PUBLISHED = "run", "published"

#: A collapsed network predicts one constant face: its error is that of the training mean, and nothing moves. Its
#: correlation is chance in the absolute protocol of papers (at most .03 in the collapsed cells of Fan et al. and at
#: least .19 in the others); of what is centred it can be anything, since any small movement correlates.
MIN_CORRELATION = 0.1
MIN_VARIANCE = 0.02
MIN_GAIN = 0.02


def is_collapsed(signal: float, least: float, ratio: float) -> bool:
    """Whether a network has collapsed to the mean predictor.

    Parameters
    ----------
    signal, least : its CORR (Eq. 19) with MIN_CORRELATION, or its global-variance ratio with MIN_VARIANCE
    ratio : its RMSE(appearance) over that of the training mean
    """
    return bool(abs(signal) < least and ratio > 1 - MIN_GAIN)


def topology_frame(measured: MeasuredRows, metrics: Sequence[str], paper: Published | None = None):
    """All figures of the table of topologies as a data frame with :data:`COLUMNS`, one line per cell and measure.

    Figures of the run are means over the seeds of a cell with the sample standard deviation (NaN of one seed);
    ``collapsed`` counts the seeds that collapsed to the mean predictor. Ratios to the training mean are given for
    errors. If a paper prints no such row, :func:`inferred_training_mean` is used. ``best`` marks the best value of each
    measure in each group and source.

    Parameters
    ----------
    measured : the stacks (rows of the family ``stack`` with the settings ``letters`` and ``nodes``) and the training
        mean; other rows are left out
    metrics : names of measures
    paper : the published figures, if there are any

    Raises
    ------
    DataError
        The training mean is missing.
    """
    import pandas

    table = measured.tables[measured.base.name]
    base = {metric: corpus_figure(table, metric) for metric in {*metrics, "rmse_appearance"}}
    lines = []
    for rows in _stacks(measured).values():
        first, collapsed = rows[0], sum(_collapsed(measured, row, base["rmse_appearance"]) for row in rows)
        cell = (RUN, first.group, first.settings["letters"], first.settings["nodes"])
        for metric in metrics:
            figure = measured.mean_and_deviation(rows, metric)
            ratio = [value / base[metric] if METRICS[metric].is_error else np.nan for value in figure]
            lines.append((*cell, metric, *figure, *ratio, len(rows), collapsed, False))
    if paper is not None:
        lines += _published_lines(paper)
    return _with_best(pandas.DataFrame(lines, columns=list(COLUMNS)))


def _stacks(measured: MeasuredRows) -> dict[str, tuple[ModelRow, ...]]:
    return {cell: rows for cell, rows in measured.cells().items() if rows[0].family == FAMILY}


def _collapsed(measured: MeasuredRows, row: ModelRow, base: float) -> bool:
    table = measured.tables[row.name]
    variance, ratio = corpus_figure(table, "gv_ratio"), corpus_figure(table, "rmse_appearance") / base
    return is_collapsed(variance, MIN_VARIANCE, ratio)


def inferred_training_mean(paper: Published) -> dict[str, float]:
    """Errors of the training mean by measure, inferred for a paper that does not print them; empty if impossible.

    A network that predicts one constant face has a CORR of about 0. The cells of Fan et al. with a CORR below .1 agree
    in their errors within 1 in 300, as predictors of the same constant must; the median of their errors is taken. It is
    an inference from the paper's table and not a figure of it.
    """
    flat = [cell for cell in paper.topologies.values() if abs(cell.get("corr", 1.0)) < MIN_CORRELATION]
    errors = [metric for metric in paper.metrics if METRICS[metric].is_error]
    return {metric: float(np.median([cell[metric] for cell in flat])) for metric in errors} if flat else {}


def _published_lines(paper: Published) -> list[tuple]:
    base, lines = inferred_training_mean(paper), []
    for (stack, nodes), figures in paper.topologies.items():
        ratio = figures["rmse_appearance"] / base["rmse_appearance"] if "rmse_appearance" in base else 0.0
        cell, collapsed = (
            (PUBLISHED, "", stack, nodes),
            int(is_collapsed(figures.get("corr", 1.0), MIN_CORRELATION, ratio)),
        )
        for metric in paper.metrics:
            of_base = figures[metric] / base[metric] if metric in base else np.nan
            lines.append((*cell, metric, figures[metric], np.nan, of_base, np.nan, 1, collapsed, False))
    return lines


def _with_best(frame):
    cost = frame["value"].copy()
    for name in frame["metric"].unique():
        of_metric = frame["metric"] == name
        cost[of_metric] = METRICS[name].cost(frame.loc[of_metric, "value"])
    lowest = cost.groupby([frame["source"], frame["group"], frame["metric"]]).transform("min")
    return frame.assign(best=cost == lowest)


def agreement(frame) -> tuple[float, int]:
    """Spearman's rank correlation of the run's RMSE(appearance) with the published one, and the number of cells.

    Cells of the first group are compared, without those that collapsed in the run or in the paper, whose order is
    random. The correlation is NaN for fewer than four cells.
    """
    from scipy.stats import spearmanr

    errors = frame[(frame["metric"] == "rmse_appearance") & (frame["collapsed"] == 0)]
    first = frame.loc[frame["source"] == RUN, "group"].head(1)
    run, published = (
        errors[(errors["source"] == source) & errors["group"].isin(groups)].set_index(["topology", "nodes"])["value"]
        for source, groups in ((RUN, first), (PUBLISHED, [""]))
    )
    common = [cell for cell in run.index if cell in published.index]
    if len(common) < 4:
        return float("nan"), len(common)
    return float(spearmanr(run[common], published[common]).statistic), len(common)


def topology_tables(
    frame,
    measured: MeasuredRows,
    facts: Sequence[tuple[str, str]],
    paper: Published | None = None,
    digits: int = 3,
    ratio_digits: int = 3,
) -> tuple[Table, ...]:
    """Tables in the paper's layout, with nodes across and topologies down: figures and ratios for each group.

    Parameters
    ----------
    frame, measured : from :func:`topology_frame`, and the rows it was made of
    facts : what the figures of the run were computed on
    paper : source of the published figures, for the notes
    digits, ratio_digits : number of decimals
    """
    tables, groups = [], list(dict.fromkeys(frame.loc[frame["source"] == RUN, "group"]))
    mean = f"ratio to the {measured.base.title.lower()}"
    rank = agreement(frame)
    if rank[0] == rank[0]:
        text = f"{rank[0]:.2f} over {rank[1]} cells"
        facts = (*facts, ("rank correlation of RMSE(appearance) with the published one", text))
    for number, group in enumerate(groups):
        part = frame[(frame["source"] == RUN) & (frame["group"] == group)]
        title = "Networks by topology and nodes" + (f": {group}" if len(groups) > 1 else "")
        shown = (*(facts if number == 0 else ()), *_stack_facts(measured, group))
        tables += _tables(part, title, mean, shown, _notes(part), digits, ratio_digits)
    part = frame[frame["source"] == PUBLISHED]
    if len(part):
        shown = (("source", paper.source), ("corpus of the paper", paper.corpus))
        title, to = "Networks by topology and nodes as published", "ratio to the collapsed cells"
        tables += _tables(part, title, to, shown, [*_notes(part), *_paper_notes(paper)], digits, ratio_digits)
    return tuple(tables)


def _stack_facts(measured: MeasuredRows, group: str) -> tuple[tuple[str, str], ...]:
    """Facts about the networks of a group: their input blocks, and what their number of nodes counts."""
    first = next(row for row in measured.rows if row.family == FAMILY and row.group == group)
    counts = first.settings.get("b_nodes", "")
    lines = (
        ("input blocks", ", ".join(first.inputs)),
        ("nodes of a B layer count", {"direction": "one direction", "layer": "both directions"}.get(counts, counts)),
    )
    return tuple((name, text) for name, text in lines if text)


def _tables(part, title: str, ratio: str, facts, notes, digits: int, ratio_digits: int) -> list[Table]:
    """The table of figures, and the table of ratios if there are any."""
    metrics = list(dict.fromkeys(part["metric"]))
    errors = [metric for metric in metrics if METRICS[metric].is_error]
    tables = [_table(part, "value", metrics, digits, title, facts, notes)]
    if part["ratio"].notna().any():
        tables.append(_table(part, "ratio", errors, ratio_digits, f"{title}: {ratio}", (), ()))
    return tables


def _table(part, column: str, metrics, digits: int, title: str, facts, notes) -> Table:
    widths = sorted(part["nodes"].unique())
    found = {(row.topology, row.nodes, row.metric): row for row in part.itertuples()}
    rows = (
        Row(
            topology,
            tuple(_cell(found.get((topology, n, metric)), column, digits) for n in widths for metric in metrics),
        )
        for topology in dict.fromkeys(part["topology"])
    )
    return Table(
        title=title,
        columns=tuple(METRICS[metric].heading for _ in widths for metric in metrics),
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


def _notes(part) -> list[str]:
    notes = ["The best value of each measure is bold."]
    if part["seeds"].max() > 1:
        notes.append(f"Mean and standard deviation over {part['seeds'].max()} seeds.")
    if (part["collapsed"] > 0).any():
        cells = part.loc[part["collapsed"] > 0, ["topology", "nodes"]].drop_duplicates()
        of_run = (part["source"] == RUN).all()
        sign = f"global-variance ratio below {MIN_VARIANCE:g}" if of_run else f"|CORR| below {MIN_CORRELATION:g}"
        notes.append(
            f"† {len(cells)} of {len(part[['topology', 'nodes']].drop_duplicates())} cells collapsed to the mean "
            f"predictor: {sign} and RMSE(appearance) less than {MIN_GAIN:.0%} better "
            "than that of the training mean. Such a network predicts one constant face."
        )
    return notes


def _paper_notes(paper: Published) -> list[str]:
    notes, base = [], inferred_training_mean(paper)
    if base:
        figures = ", ".join(f"{METRICS[metric].title} {value:.3f}" for metric, value in base.items())
        notes.append(
            "The paper prints no row of the training mean. Its cells with a CORR of about 0 agree in their errors, as "
            f"predictors of one constant face do; their median ({figures}) is used as that row in the ratios. It is "
            "inferred from the table and is not a figure of the paper."
        )
    trained = len(paper.stacks) * len(paper.nodes)
    if trained > len(paper.topologies):
        notes.append(f"The paper trained {trained} networks and prints the figures of {len(paper.topologies)}.")
    return [
        *notes,
        "Figures of two corpora are in different units: compare ratios and ranks. The paper removes no drift between "
        "recordings, so its figures are absolute.",
    ]
