"""A table as people read it: cells, rows, headings that span columns, facts, notes, definitions.

A :class:`Table` holds text, already rounded to what is shown. :mod:`visualspeech.evaluation.forms` writes it as
Markdown, LaTeX and HTML; the figures that it was made from are written beside it as TSV. So the forms cannot disagree.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from visualspeech.evaluation.metrics import Metric


@dataclass(frozen=True)
class Cell:
    """What a cell shows.

    Parameters
    ----------
    text : the figure; empty is shown as a dash
    small : beside it, less prominent: an interval, a deviation
    best : shown in bold
    collapsed : shown in italics with a dagger; a note says what that means
    """

    text: str
    small: str = ""
    best: bool = False
    collapsed: bool = False


@dataclass(frozen=True)
class Row:
    """One row.

    Parameters
    ----------
    title : heading of the row
    cells : as many as the table has columns; none: the title is a heading over the rows below it
    role : of :data:`visualspeech.models.rows.ROLES`; baselines and the floor are less prominent
    """

    title: str
    cells: tuple[Cell, ...] = ()
    role: str = "model"


@dataclass(frozen=True)
class Table:
    """One table.

    Parameters
    ----------
    title : above it
    columns : headings of the lower line, without that of the first column
    rows : see :class:`Row`
    groups : headings of the upper line, each with the number of columns it spans; empty: there is no upper line
    facts : (name, text) pairs: what the figures were computed on
    notes : sentences below it
    definitions : (term, definition) pairs below it
    corner : heading of the first column
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    groups: tuple[tuple[str, int], ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    definitions: tuple[tuple[str, str], ...] = ()
    corner: str = ""


def shown(value: float, digits: int) -> str:
    """A figure with a number of digits after the point; empty where it is NaN."""
    if value != value:
        return ""
    text = f"{value:.{digits}f}"
    # No negative zero: "-0.000" would look like a finding.
    return text.removeprefix("-") if float(text) == 0 else text


def interval(low: str, high: str) -> str:
    """An interval of two figures as shown; empty where there is none."""
    return f"[{low}, {high}]" if low and high else ""


def best_of(metric: Metric, figures: Mapping[str, str]) -> set[str]:
    """The keys with the best figure as shown, ties all count; empty where there is nothing to compare."""
    # Rounded, so that 0.9 and 1.1 are equally far from 1.
    costs = {key: round(metric.cost(float(text)), 12) for key, text in figures.items() if text}
    return {key for key, cost in costs.items() if cost == min(costs.values())} if len(costs) > 1 else set()


def definitions_of(metrics: Sequence[Metric]) -> tuple[tuple[str, str], ...]:
    """Measures and what they mean, for :attr:`Table.definitions`."""
    return tuple((metric.title, f"{metric.definition}.") for metric in metrics)
