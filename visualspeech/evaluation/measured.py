"""Rows of a result table with the statistics of their test utterances."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.metrics import CENTRED, Metric, corpus_figure, is_measured, metric_named
from visualspeech.models.rows import ModelRow

#: Family of the base row of ratios: the mean of all training frames.
BASE_FAMILY = "mean"


def check_same_utterances(tables: Mapping[str, object], frames: bool = True) -> None:
    """Check that all tables have the same utterances in the same order, with the same numbers of frames.

    Parameters
    ----------
    tables : name of a row -> table with the columns ``id`` and ``frames``
    frames : False for rows of different frame rates, whose numbers of frames are not compared

    Raises
    ------
    DataError
        A table differs from the first one; the message names both.
    """
    expected, first = None, ""
    for name, table in tables.items():
        counts = table["frames"] if frames else [0] * len(table)
        found = [(one, int(count)) for one, count in zip(table["id"], counts, strict=True)]
        if expected is None:
            expected, first = found, name
        elif found != expected:
            odd = sorted({one for one, _ in set(found) ^ set(expected)})[:3]
            raise DataError(
                f"`{name}` and `{first}` were evaluated on different utterances{' or frames' if frames else ''} "
                f"({len(found)} and {len(expected)} utterances; for example {', '.join(odd)}). Delete the folders of "
                "these models and run again."
            )


@dataclass(frozen=True)
class MeasuredRows:
    """Rows of a result table, all measured on the same utterances.

    Parameters
    ----------
    rows : in the order of the table
    tables : name of a row -> statistics of its utterances (:func:`visualspeech.evaluation.metrics.score_table`), in the
        same order
    repetitions : name of a pooled row -> the tables of its repetitions

    Raises
    ------
    DataError
        The rows were evaluated on different utterances or frames, or there is no row.
    """

    rows: tuple[ModelRow, ...]
    tables: Mapping[str, object]
    repetitions: Mapping[str, tuple] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.rows:
            raise DataError("there is no model to compare. Add one under `models:` in the settings of the system.")
        check_same_utterances(self.tables)

    @classmethod
    def of(cls, rows: Sequence[Mapping], tables: Sequence) -> "MeasuredRows":
        """Rows given as plain data (:meth:`ModelRow.plain`), with their tables in the same order."""
        made = tuple(map(ModelRow.of, rows))
        return cls(made, {row.name: table for row, table in zip(made, tables, strict=True)})

    def repeated(self, name: str) -> tuple:
        """The tables of all repetitions of a row; that of the row itself where it is none of a pooled cell."""
        return self.repetitions.get(name, (self.tables[name],))

    def metrics(self, names: Sequence[str], protocol: str = "") -> list[Metric]:
        """Those of some measures whose statistics the rows hold, in their order; of one protocol if one is given.

        A measure of the centred protocol that the rows lack is left in, because their tables are then damaged; that of
        a region of the face is not, as a face need not have all of them.

        Raises
        ------
        SettingError
            A measure is unknown.
        """
        table = next(iter(self.tables.values()))
        chosen = [one for one in map(metric_named, names) if not protocol or one.protocol == protocol]
        return [one for one in chosen if (one.protocol == CENTRED and not one.region) or is_measured(table, one)]

    @property
    def base(self) -> ModelRow:
        """The training mean.

        Raises
        ------
        DataError
            There is none.
        """
        found = [row for row in self.rows if row.family == BASE_FAMILY]
        if not found:
            raise DataError(
                "the row `training_mean` is missing, and errors are shown as ratios to it. Add a model of the family "
                f"`{BASE_FAMILY}` under `models:` in the settings of the system."
            )
        return found[0]

    @property
    def utterances(self) -> int:
        """Number of test utterances."""
        return len(next(iter(self.tables.values())))

    @property
    def frames(self) -> int:
        """Number of test frames."""
        return int(next(iter(self.tables.values()))["frames"].sum())

    @property
    def rates(self) -> tuple[float, ...]:
        """Frame rates of the utterances in Hz, each once, the lowest first."""
        return tuple(sorted({float(rate) for rate in next(iter(self.tables.values()))["rate"]}))

    @property
    def seeds(self) -> tuple[int, ...]:
        """Seeds of the models, each once."""
        return tuple(sorted({row.seed for row in self.rows if row.role == "model"}))

    @property
    def titles(self) -> dict[str, str]:
        """Name of a row -> its title."""
        return {row.name: row.title for row in self.rows}

    def title(self, row: ModelRow) -> str:
        """Title of a row in a table in which pooled rows stand beside others."""
        count = len(self.repeated(row.name))
        return f"{row.title} ({count} seeds)" if count > 1 else row.title

    def where(self, wanted: Callable[[ModelRow], bool]) -> "MeasuredRows":
        """The rows for which a condition holds."""
        kept = tuple(row for row in self.rows if wanted(row))
        repetitions = {row.name: self.repetitions[row.name] for row in kept if row.name in self.repetitions}
        return MeasuredRows(kept, {row.name: self.tables[row.name] for row in kept}, repetitions)

    def on(self, utterances: Collection[str]) -> "MeasuredRows":
        """The rows on some of their utterances; not for pooled rows."""
        kept = {name: table[table["id"].isin(utterances)].reset_index(drop=True) for name, table in self.tables.items()}
        return MeasuredRows(self.rows, kept)

    def cells(self) -> dict[str, tuple[ModelRow, ...]]:
        """Rows by the cell that they are repetitions of, both in order."""
        return cells_of(self.rows)

    def pooled(self) -> "MeasuredRows":
        """The repetitions of each cell averaged to one row, which has the name of the cell.

        The statistics are means over the repetitions. The figure of a quotient is then the mean of the repetitions'
        figures; the concordance correlation is that of the frames of all repetitions together.
        """
        if self.repetitions:
            return self
        cells = self.cells()
        rows = tuple(replace(of_cell[0], name=cell) for cell, of_cell in cells.items())
        repetitions = {cell: tuple(self.tables[row.name] for row in of_cell) for cell, of_cell in cells.items()}
        return MeasuredRows(rows, {cell: _mean(tables) for cell, tables in repetitions.items()}, repetitions)

    def single(self) -> "MeasuredRows | None":
        """The rows of the cells that have several, each with its seed in name and title; None if there are none.

        The first row of a cell has the cell's name, which is that of the pooled row as well.
        """
        found = [
            (replace(row, name=f"{cell}-s{row.seed}", title=f"{row.title}, seed {row.seed}"), self.tables[row.name])
            for cell, of_cell in self.cells().items()
            for row in of_cell
            if len(of_cell) > 1
        ]
        return (
            MeasuredRows(tuple(row for row, _ in found), {row.name: table for row, table in found}) if found else None
        )

    def mean_and_deviation(self, rows: Sequence[ModelRow], metric: str) -> tuple[float, float]:
        """Mean of a corpus figure over repetitions and its sample standard deviation, NaN for a single repetition."""
        figures = [corpus_figure(self.tables[row.name], metric) for row in rows]
        return float(np.mean(figures)), float(np.std(figures, ddof=1)) if len(figures) > 1 else float("nan")


def cells_of(rows: Sequence[ModelRow]) -> dict[str, tuple[ModelRow, ...]]:
    """Rows by the cell that they are repetitions of; a row without a cell is a cell of its own."""
    found: dict[str, tuple[ModelRow, ...]] = {}
    for row in rows:
        cell = row.cell or row.name
        found[cell] = (*found.get(cell, ()), row)
    return found


def _mean(tables: Sequence):
    first, *others = tables
    if not others:
        return first
    numbers = [name for name in first.columns if name != "id"]
    mean = np.mean([table[numbers].to_numpy(float) for table in tables], axis=0)
    return first.assign(**dict(zip(numbers, mean.T, strict=True)))
