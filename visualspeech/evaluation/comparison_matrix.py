"""All paired comparisons of a system as one table: a line per row, a column per measure."""

from collections.abc import Mapping
from dataclasses import replace

from visualspeech.evaluation.layout import Cell, Row, Table, shown
from visualspeech.evaluation.metrics import ABSOLUTE, METRICS
from visualspeech.models.rows import ModelRow


def comparison_matrix(frame, rows: Mapping[str, ModelRow], level: float, digits: int = 3) -> Table:
    """The table: each figure with the numbers of rows from which it differs significantly.

    Parameters
    ----------
    frame : from :func:`visualspeech.evaluation.comparisons.compare`
    rows : name of a pooled row -> row, in the order of the table
    level : significance level of the comparisons
    """
    metrics = list(dict.fromkeys(frame["metric"]))
    values, wins, losses, best = {}, {}, {}, {}
    for line in frame.itertuples():
        values[line.first, line.metric], values[line.second, line.metric] = line.first_value, line.second_value
        best.setdefault(line.metric, line.first)  # the pairs of a measure begin with its best row
        if line.better:
            loser = line.second if line.better == line.first else line.first
            wins[line.better, line.metric] = wins.get((line.better, line.metric), 0) + 1
            losses[loser, line.metric] = losses.get((loser, line.metric), 0) + 1

    def cell(row: str, metric: str) -> Cell:
        key = row, metric
        parts = (f"▲ {wins[key]}" if key in wins else "", f"▼ {losses[key]}" if key in losses else "")
        value = values.get(key, float("nan"))
        return Cell(shown(value, digits), " ".join(filter(None, parts)), best=best.get(metric) == row)

    compared = [name for name in rows if any((name, metric) in values for metric in metrics)]
    pairs = max((int((frame["metric"] == metric).sum()) for metric in metrics), default=0)
    notes = (
        f"▲: number of rows that this row is significantly better than; ▼: significantly worse than. Holm-corrected p "
        f"below {level:g} for the {pairs} pairs of rows of a measure, and the figure agrees. The best value is bold. "
        "Differences, intervals and p values of all pairs are in the TSV file.",
    )
    if not wins:
        notes = (f"No two rows differ significantly in any measure (Holm-corrected p at least {level:g}).", *notes)
    return Table(
        "Figures, and how many rows each row differs from",
        tuple(map(_heading, metrics)),
        tuple(
            Row(rows[name].title, tuple(cell(name, metric) for metric in metrics), rows[name].role) for name in compared
        ),
        notes=notes,
    )


def _heading(name: str) -> str:
    """Heading of a measure; its name where it is a user's own, which only the jobs that compute it know."""
    if name not in METRICS:
        return name
    metric = METRICS[name]
    return (replace(metric, title=f"{metric.title}, absolute") if metric.protocol == ABSOLUTE else metric).heading
