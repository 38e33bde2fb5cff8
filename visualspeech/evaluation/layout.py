"""Tables for readers: cells, rows, headings that span columns, facts, notes and definitions.

A :class:`Table` holds text that is already rounded. :mod:`visualspeech.evaluation.forms` writes it as Markdown, LaTeX
and HTML, which therefore show the same figures; the figures themselves are written as TSV.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from visualspeech.evaluation.metrics import Metric
from visualspeech.models.rows import ORACLE, ModelRow


@dataclass(frozen=True)
class Cell:
    """The content of a cell.

    Parameters
    ----------
    text : the figure; an empty text is shown as a dash
    small : interval or deviation, shown after the figure in small print
    best : whether the figure is bold
    collapsed : whether the figure is in italics with a dagger, which a note explains
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
    cells : one per column; none if the title is a heading of the rows below it
    role : of :data:`visualspeech.models.rows.ROLES`; baselines and the floor are less prominent
    name : of the model that the row is of, by which settings choose it; empty where it is of none
    """

    title: str
    cells: tuple[Cell, ...] = ()
    role: str = "model"
    name: str = ""


@dataclass(frozen=True)
class Table:
    """One table.

    Parameters
    ----------
    title : caption
    columns : headings of the columns after the first one
    rows : see :class:`Row`
    groups : headings above those of the columns, each with the number of columns that it spans; may be empty
    facts : (name, text) pairs that describe the data of the figures
    notes : sentences below the table
    definitions : (term, definition) pairs below the table
    corner : heading of the first column
    metrics : the measure that each column is of, by name, by which settings choose it; may be empty, of one or of all
    ranked : whether the best value in each column is bold
    ratios : whether the figures are ratios to the training mean
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    groups: tuple[tuple[str, int], ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    definitions: tuple[tuple[str, str], ...] = ()
    corner: str = ""
    metrics: tuple[str, ...] = ()
    ranked: bool = False
    ratios: bool = False


def shown(value: float, digits: int) -> str:
    """A figure with a number of decimals; empty for NaN."""
    if value != value:
        return ""
    text = f"{value:.{digits}f}"
    # Rounding may give "-0.000"; the sign of a zero means nothing.
    return text.removeprefix("-") if float(text) == 0 else text


def interval(low: str, high: str) -> str:
    """An interval of two figures as text; empty if one of them is empty."""
    return f"[{low}, {high}]" if low and high else ""


def best_of(metric: Metric, figures: Mapping[str, str]) -> set[str]:
    """Keys of the best figures after rounding, including ties; empty if there are fewer than two figures."""
    # Rounding makes 0.9 and 1.1 equally far from 1.
    costs = {key: round(metric.cost(float(text)), 12) for key, text in figures.items() if text}
    return {key for key, cost in costs.items() if cost == min(costs.values())} if len(costs) > 1 else set()


def competes(row: ModelRow) -> bool:
    """Whether a row can have the best value of a column; what is read off the recorded face cannot."""
    return row.role not in ("floor", ORACLE)


def oracle_note(rows: Sequence[ModelRow]) -> tuple[str, ...]:
    """What the rows know whose input is read off the recorded face; empty if there are none."""
    titles = list(dict.fromkeys(row.title for row in rows if row.role == ORACLE))
    if not titles:
        return ()
    return (
        f"Oracle rows: {', '.join(titles)}. Their input is read off the recorded face of the test utterance, which is "
        "the answer. They are no predictions from text, and none of their values is marked as the best.",
    )


def definitions_of(metrics: Sequence[Metric]) -> tuple[tuple[str, str], ...]:
    """Titles and definitions of measures, for :attr:`Table.definitions`."""
    return tuple((metric.title, f"{metric.definition}.") for metric in metrics)
