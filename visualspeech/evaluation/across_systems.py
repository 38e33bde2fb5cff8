"""Comparison of the systems of one corpus in the measures that are comparable between them."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.facts import TableFacts
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
from visualspeech.evaluation.measured import MeasuredRows, check_same_utterances
from visualspeech.evaluation.metrics import ABSOLUTE, METRICS, PROTOCOLS, Metric, is_measured
from visualspeech.evaluation.statistics import (
    NO_FIGURE,
    BootstrapSettings,
    Figure,
    draws,
    figure,
    relative_figure,
    sample,
    sample_row,
)

#: Measures, and whether they are shown as figures or as ratios to the training mean of the row's own system. Errors of
#: parameters are in units of the system's coding, so only their ratios can be compared.
COLUMNS = (
    ("lip_distance_px", "value"),
    ("lip_distance_px_absolute", "value"),
    ("rmse_appearance", "ratio"),
    ("corr", "value"),
    ("gv_ratio", "value"),
)
FRAME_COLUMNS = ("system", "row", "metric", "part", "value", "low", "high")


@dataclass(frozen=True)
class SystemRows:
    """The rows of one system.

    Parameters
    ----------
    title : of the system
    facts : what its figures were computed on
    measured : its rows, with its training mean
    """

    title: str
    facts: TableFacts
    measured: MeasuredRows


def systems_frame(systems: Sequence[SystemRows], bootstrap: BootstrapSettings):
    """Figures of all systems as a data frame: ``system row metric part value low high``, one line per row and column.

    Predictions are compared with the recorded face in the system's own coding. Repetitions of a model are one row. A
    measure whose statistics a system lacks is NaN.

    Raises
    ------
    DataError
        The systems were evaluated on different utterances, two have the same name, or a training mean is missing.
    """
    import pandas

    _check(systems)
    lines = []
    for system in systems:
        measured = system.measured.pooled()
        base, drawn = measured.tables[measured.base.name], draws(measured.utterances, bootstrap)
        for row in measured.tables:
            for name, part in COLUMNS:
                found = _figure(measured, row, base if part == "ratio" else None, METRICS[name], drawn, bootstrap)
                lines.append((system.facts.system, row, name, part, found.value, found.low, found.high))
    return pandas.DataFrame(lines, columns=list(FRAME_COLUMNS))


def _check(systems: Sequence[SystemRows]) -> None:
    names = [system.facts.system for system in systems]
    if len(set(names)) != len(names):
        raise DataError(f"two systems of a table have one name: {', '.join(names)}. Rename one of them.")
    tables = {name: next(iter(system.measured.tables.values())) for name, system in zip(names, systems, strict=True)}
    check_same_utterances(tables, frames=False)


def _figure(
    measured: MeasuredRows, row: str, base, metric: Metric, drawn: np.ndarray, bootstrap: BootstrapSettings
) -> Figure:
    if not is_measured(measured.tables[row], metric):
        return NO_FIGURE
    own = sample_row(measured, row, metric, drawn, bootstrap)
    if base is None:
        return figure(own, bootstrap.level)
    return relative_figure(own, sample(base, metric, drawn), bootstrap.level)


def systems_tables(
    frame, systems: Sequence[SystemRows], bootstrap: BootstrapSettings, digits: int = 3, lost: Collection[str] = ()
) -> tuple[Table]:
    """The table of all systems, with a heading above the rows of each.

    Parameters
    ----------
    frame, systems, bootstrap : as made by and given to :func:`systems_frame`
    lost : test utterances of some systems that are left out, because other systems lack them
    """
    text = {
        (line.system, line.row, line.metric): tuple(shown(v, digits) for v in (line.value, line.low, line.high))
        for line in frame.itertuples()
    }
    measured = [(system, system.measured.pooled()) for system in systems]
    best = _best(text, measured)
    rows = []
    for system, pooled in measured:
        rows.append(Row(_heading(system)))
        for row in pooled.rows:
            keys = [(system.facts.system, row.name, name) for name, _ in COLUMNS]
            cells = (Cell(text[key][0], interval(*text[key][1:]), best=key in best) for key in keys)
            rows.append(Row(row.title, tuple(cells), row.role))
    first = systems[0].facts
    facts = (
        ("corpus", first.corpus),
        ("split", first.split_hash),
        ("systems", ", ".join(system.title for system in systems)),
        ("test utterances", str(systems[0].measured.utterances)),
        ("protocol", "; ".join(PROTOCOLS.values())),
        ("intervals", bootstrap.text(measured[0][1])),
        ("visualspeech", first.version),
    )
    metrics = [METRICS[name] for name, _ in COLUMNS]
    headings = (
        f"{metric.title} / training mean ↓" if part == "ratio" else _with_protocol(metric)
        for metric, (_, part) in zip(metrics, COLUMNS, strict=True)
    )
    notes = (
        "The best value in each column is bold; floors are left out.",
        *oracle_note([row for _, pooled in measured for row in pooled.rows]),
        "Predictions of every system are brought to the frames of the camera, as a video shows them, and compared with "
        "the recorded face there, in the system's own visual coding. Headings say the rate of a system's models.",
    )
    if lost:
        notes += (f"Left out, because a visual coding rejected them: {', '.join(sorted(lost))}.",)
    title = "Systems on one corpus"
    return (Table(title, tuple(headings), tuple(rows), facts=facts, notes=notes, definitions=definitions_of(metrics)),)


def _with_protocol(metric: Metric) -> str:
    title = f"{metric.title}, absolute" if metric.protocol == ABSOLUTE else metric.title
    return replace(metric, title=title).heading


def _best(text, measured) -> set[tuple[str, str, str]]:
    """Keys of the best cells over all systems."""
    rows = [(system.facts.system, row.name) for system, pooled in measured for row in pooled.rows if competes(row)]
    return {
        key
        for name, _ in COLUMNS
        for key in best_of(METRICS[name], {(*row, name): text[(*row, name)][0] for row in rows})
    }


def _heading(system: SystemRows) -> str:
    facts = system.facts
    seeds = f"{'seeds' if len(facts.seeds) > 1 else 'seed'} {', '.join(map(str, facts.seeds))}"
    parts = (facts.rate_text, facts.coding_text, f"drift removal {facts.drift}" if facts.drift else "", seeds)
    return f"{system.title}: {'; '.join(part for part in parts if part)}"
