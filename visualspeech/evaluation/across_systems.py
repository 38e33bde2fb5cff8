"""All systems of one corpus in one table: what a user chooses by.

The first table measures decoded lips against the tracked ones at the frames of the camera, in units that all systems
share (:mod:`visualspeech.evaluation.lip_metrics`). The second one measures the parameters of each visual coding against
those of the recorded face, on the same frames.
"""

from collections.abc import Collection, Mapping, Sequence
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
from visualspeech.evaluation.lip_metrics import ACROSS, COSTS, DIGITS
from visualspeech.evaluation.lip_statistics import recorded_closures
from visualspeech.evaluation.measured import MeasuredRows, check_same_utterances
from visualspeech.evaluation.metrics import ABSOLUTE, CENTRED, METRICS, PROTOCOLS, Metric, is_measured
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

#: Measures of the second table, and whether they are shown as figures or as ratios to the training mean of the row's
#: own system. Errors of parameters are in units of the system's coding, so only their ratios can be compared.
COLUMNS = (
    ("lip_distance_px", "value"),
    ("lip_distance_px_absolute", "value"),
    ("rmse_appearance", "ratio"),
    ("corr", "value"),
    ("gv_ratio", "value"),
)
LIPS = "lips"  # in place of value or ratio: measures of the first table
#: Columns of the first table below one heading each.
GROUPS = {
    "Lip points": ("lip_distance", "jerk"),
    "Opening of the mouth": ("opening_corr", "opening_ccc", "lag"),
    "Width of the mouth": ("width_corr", "width_ccc"),
    "Lips closed": ("closure", "silence"),
    "Model": COSTS,
}
LIP_COLUMNS = tuple(name for names in GROUPS.values() for name in names)
FRAME_COLUMNS = ("system", "row", "metric", "part", "value", "low", "high")
RECORDED = "recorded"


@dataclass(frozen=True)
class SystemRows:
    """The rows of one system.

    Parameters
    ----------
    title : of the system
    facts : what its figures were computed on
    measured : its rows, with its training mean: parameters at the camera's frames
    lips : the same rows: lips at the camera's frames (:func:`visualspeech.evaluation.lip_rows.lip_table`)
    """

    title: str
    facts: TableFacts
    measured: MeasuredRows
    lips: MeasuredRows


def systems_frame(systems: Sequence[SystemRows], bootstrap: BootstrapSettings):
    """Figures of all systems as a data frame: ``system row metric part value low high``, one line per row and column.

    ``part`` is ``lips`` for the measures of the first table, ``value`` or ``ratio`` for those of the second one; two
    lines without a system are of the recorded faces. Repetitions of a model are one row. A measure whose statistics a
    system lacks is NaN.

    Raises
    ------
    DataError
        The systems were evaluated on different utterances, two have the same name, or a training mean is missing.
    """
    import pandas

    _check(systems)
    lines = [("", RECORDED, name, LIPS, value, np.nan, np.nan) for name, value in _recorded(systems).items()]
    for system in systems:
        lines += [(system.facts.system, *line) for line in (*_lip_lines(system.lips, bootstrap),
                                                            *_parameter_lines(system.measured, bootstrap))]  # fmt: skip
    return pandas.DataFrame(lines, columns=list(FRAME_COLUMNS))


def _recorded(systems: Sequence[SystemRows]) -> Mapping[str, float]:
    """Figures of the recorded faces, of the first system that has some."""
    tables = (next(iter(system.lips.tables.values())) for system in systems)
    return next(filter(None, map(recorded_closures, tables)), {})


def _lip_lines(lips: MeasuredRows, bootstrap: BootstrapSettings):
    lips = lips.pooled()
    drawn = draws(lips.utterances, bootstrap)
    for row in lips.tables:
        for name in LIP_COLUMNS:
            found = _figure(lips, row, None, ACROSS[name], drawn, bootstrap)
            yield row, name, LIPS, found.value, found.low, found.high


def _parameter_lines(measured: MeasuredRows, bootstrap: BootstrapSettings):
    measured = measured.pooled()
    base, drawn = measured.tables[measured.base.name], draws(measured.utterances, bootstrap)
    for row in measured.tables:
        for name, part in COLUMNS:
            found = _figure(measured, row, base if part == "ratio" else None, METRICS[name], drawn, bootstrap)
            yield row, name, part, found.value, found.low, found.high


def _check(systems: Sequence[SystemRows]) -> None:
    names = [system.facts.system for system in systems]
    if len(set(names)) != len(names):
        raise DataError(f"two systems of a table have one name: {', '.join(names)}. Rename one of them.")
    tables = {name: next(iter(system.measured.tables.values())) for name, system in zip(names, systems, strict=True)}
    check_same_utterances(tables, frames=False)
    lips = {name: next(iter(system.lips.tables.values())) for name, system in zip(names, systems, strict=True)}
    check_same_utterances(lips)
    check_same_utterances({names[0]: tables[names[0]], f"lips of {names[0]}": lips[names[0]]}, frames=False)


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
) -> tuple[Table, ...]:
    """Both tables of all systems, with a heading above the rows of each; the second one where a system has figures.

    Parameters
    ----------
    frame, systems, bootstrap : as made by and given to :func:`systems_frame`
    lost : test utterances of some systems that are left out, because other systems lack them
    """
    text = {}
    for line in frame.itertuples():
        own = DIGITS.get(line.metric, digits) if line.part == LIPS else digits
        values = (line.value, line.low, line.high)
        text[line.system, line.row, line.part, line.metric] = tuple(shown(value, own) for value in values)
    coded = [one for one in systems if any(_is_coded(one, name) for name, _ in COLUMNS)]
    parameters = (_parameter_table(text, coded),) if coded else ()
    return (_lip_table(text, systems, bootstrap, lost), *parameters)


def _is_coded(system: SystemRows, name: str) -> bool:
    return is_measured(next(iter(system.measured.tables.values())), METRICS[name])


def _facts(systems: Sequence[SystemRows], bootstrap: BootstrapSettings) -> tuple[tuple[str, str], ...]:
    first = systems[0].facts
    return (
        ("corpus", first.corpus),
        ("split", first.split_hash),
        ("systems", ", ".join(system.title for system in systems)),
        ("test utterances", str(systems[0].lips.utterances)),
        ("test frames", f"{systems[0].lips.frames} of the camera"),
        ("protocol", PROTOCOLS[CENTRED]),
        ("intervals", bootstrap.text(systems[0].lips.pooled())),
        ("visualspeech", first.version),
    )


def _lip_table(text, systems: Sequence[SystemRows], bootstrap: BootstrapSettings, lost: Collection[str]) -> Table:
    columns = tuple((ACROSS[name], LIPS) for name in LIP_COLUMNS)
    measured = [(system, system.lips.pooled()) for system in systems]
    recorded = tuple(Cell(text.get(("", RECORDED, LIPS, name), ("",))[0]) for name in LIP_COLUMNS)
    notes = (
        "The best value in each column is bold, of models alone: floors and baselines are left out.",
        "Predictions are decoded to lip points and compared with the recorded lips at the frames of the camera. The "
        "floor of a system is the recorded face through its visual coding and frame rate. A rate of closure above that "
        "of the recorded faces means that the lips close more often than the speaker's.",
        *oracle_note([row for _, pooled in measured for row in pooled.rows]),
        "Frames per second are measured, so they alone differ from run to run.",
    )
    if lost:
        notes += (f"Left out, because a visual coding rejected them: {', '.join(sorted(lost))}.",)
    return Table(
        "Systems on one corpus",
        tuple(metric.heading for metric, _ in columns),
        (Row("Recorded faces", recorded, "floor"), *_rows(text, measured, columns)),
        groups=tuple((name, len(names)) for name, names in GROUPS.items()),
        facts=_facts(systems, bootstrap),
        notes=notes,
        definitions=tuple(
            (f"{group}: {metric.title}", f"{metric.definition}.")
            for group, names in GROUPS.items()
            for metric in map(ACROSS.get, names)
        ),
    )


def _parameter_table(text, systems: Sequence[SystemRows]) -> Table:
    columns = tuple((METRICS[name], part) for name, part in COLUMNS)
    measured = [(system, system.measured.pooled()) for system in systems]
    return Table(
        "Systems on one corpus: parameters of the visual codings",
        tuple(
            f"{metric.title} / training mean ↓" if part == "ratio" else _with_protocol(metric)
            for metric, part in columns
        ),
        _rows(text, measured, columns),
        facts=(("protocol", "; ".join(PROTOCOLS.values())),),
        notes=(
            "The best value in each column is bold; floors are left out.",
            "Predictions of every system are brought to the frames of the camera, as a video shows them, and compared "
            "with the recorded face there, in the system's own visual coding. Headings say the rate of a system's "
            "models.",
        ),
        definitions=definitions_of([metric for metric, _ in columns]),
    )


def _rows(text, measured: Sequence[tuple[SystemRows, MeasuredRows]], columns) -> tuple[Row, ...]:
    """The rows of all systems, each system below its heading."""
    best, rows = _best(text, measured, columns), []
    for system, pooled in measured:
        rows.append(Row(_heading(system)))
        for row in pooled.rows:
            keys = [(system.facts.system, row.name, part, metric.name) for metric, part in columns]
            rows.append(Row(row.title, tuple(_cell(text[key], key in best) for key in keys), row.role))
    return tuple(rows)


def _cell(figures: tuple[str, str, str], best: bool) -> Cell:
    value, low, high = figures
    return Cell(value, interval(low, high) if (low, high) != (value, value) else "", best=best)


def _with_protocol(metric: Metric) -> str:
    title = f"{metric.title}, absolute" if metric.protocol == ABSOLUTE else metric.title
    return replace(metric, title=title).heading


def _best(text, measured, columns) -> set[tuple[str, str, str, str]]:
    """Keys of the best cells over all systems. Among lips only models compete: a trivial baseline that has the best
    figure of one column is no model to choose."""
    rows = [(system.facts.system, row) for system, pooled in measured for row in pooled.rows if competes(row)]
    found = set()
    for metric, part in columns:
        keys = [(system, row.name, part, metric.name) for system, row in rows if part != LIPS or row.role == "model"]
        found |= best_of(metric, {key: text[key][0] for key in keys})
    return found


def _heading(system: SystemRows) -> str:
    facts = system.facts
    seeds = f"{'seeds' if len(facts.seeds) > 1 else 'seed'} {', '.join(map(str, facts.seeds))}"
    parts = (facts.rate_text, facts.coding_text, f"drift removal {facts.drift}" if facts.drift else "", seeds)
    return f"{system.title}: {'; '.join(part for part in parts if part)}"
