"""The table of articulation: closures of the lips, open vowels and the opening over time, for every row of a system."""

from collections.abc import Mapping, Sequence

from visualspeech.evaluation.articulation import (
    ARTICULATION,
    OF_RECORDINGS,
    PERCENTILE,
    TARGETS,
    Target,
    recorded_figures,
)
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
from visualspeech.evaluation.metrics import is_measured
from visualspeech.evaluation.statistics import NO_FIGURE, BootstrapSettings, Figure, draws, figure, sample_row
from visualspeech.speech.closures import MARGIN

#: Columns of the TSV file for each measure; ``value`` is the measure's own name.
PARTS = ("value", "low", "high")
RECORDED = "recorded"
LAG_DIGITS = 1  # of milliseconds


def articulation_tables(
    measured: MeasuredRows,
    targets: Sequence[Target],
    facts: Sequence[tuple[str, str]],
    digits: int = 3,
    bootstrap: BootstrapSettings | None = None,
):
    """The table as a data frame and for readers; cells are empty for a visual coding that holds no inner lips.

    Parameters
    ----------
    measured : rows whose tables may hold :func:`visualspeech.evaluation.articulation.articulation`
    targets : thresholds of the speaker
    facts : what the figures were computed on (:meth:`visualspeech.evaluation.facts.TableFacts.lines`)

    Returns
    -------
    tuple
        a data frame with a line per row, repetitions pooled, the last one of the recorded faces, and for each measure
        the columns ``metric``, ``metric_low``, ``metric_high`` as text; and one :class:`Table`
    """
    bootstrap, measured = bootstrap or BootstrapSettings(), measured.pooled()
    drawn = draws(measured.utterances, bootstrap)
    figures = {
        (row, name): figure(sample_row(measured, row, metric, drawn, bootstrap), bootstrap.level)
        if is_measured(table, metric)
        else NO_FIGURE
        for row, table in measured.tables.items()
        for name, metric in ARTICULATION.items()
    }
    first = next(iter(measured.tables.values()))
    known = recorded_figures(first) if is_measured(first, ARTICULATION["opening_corr"]) else {}
    figures |= {(RECORDED, name): NO_FIGURE for name in ARTICULATION}
    figures |= {(RECORDED, name): Figure(value, *[float("nan")] * 2) for name, value in known.items()}
    cells = {key: _text(value, LAG_DIGITS if key[1] == "opening_lag" else digits) for key, value in figures.items()}
    kinds = [(row.name, measured.title(row), row.role) for row in measured.rows] + [
        (RECORDED, "Recorded faces", "floor")
    ]
    compared = [row.name for row in measured.rows if competes(row)]
    best = {
        (row, name)
        for name, metric in ARTICULATION.items()
        for row in best_of(metric, {row: cells[row, name]["value"] for row in compared})
    }
    rows = tuple(
        Row(
            title,
            tuple(
                Cell(cell["value"], interval(cell["low"], cell["high"]), best=(row, name) in best)
                for name in ARTICULATION
                for cell in (cells[row, name],)
            ),
            role,
        )
        for row, title, role in kinds
    )
    table = Table(
        "Articulation",
        tuple(metric.heading for metric in ARTICULATION.values()),
        rows,
        facts=(*facts, *_occurrences(first, known), ("intervals", bootstrap.text(measured))),
        notes=(
            "The best value in each column is bold.",
            *oracle_note(measured.rows),
            "From decoded points of the lips; means of utterances are not removed. "
            f"An occurrence lasts from {1000 * MARGIN:g} ms before a phone to {1000 * MARGIN:g} ms after it.",
            *_thresholds(targets),
        ),
        definitions=definitions_of(tuple(ARTICULATION.values())),
    )
    return _frame([row for row, _, _ in kinds], cells), (table,)


def _text(given: Figure, digits: int) -> dict[str, str]:
    return {part: shown(getattr(given, part), digits) for part in PARTS}


def _occurrences(table, known: Mapping) -> tuple[tuple[str, str], ...]:
    if not known:
        return ()
    counts = ", ".join(
        f"{int(table[f'{name}_occurrences'].sum())} of {TARGETS[name]}" for name in map(OF_RECORDINGS.get, known)
    )
    return (("test occurrences", counts),)


def _thresholds(targets: Sequence[Target]) -> tuple[str, ...]:
    known = [one for one in targets if one.occurrences]
    if not known:
        return ("The visual coding has no inner lips, or no such phone occurs in the training utterances.",)
    limits = ", ".join(
        f"{one.threshold:.2f} px ({TARGETS[one.name]}; {one.occurrences} training occurrences)" for one in known
    )
    shares = f"{PERCENTILE}th percentiles of the recorded training occurrences (of open vowels {100 - PERCENTILE}th)"
    return (f"Thresholds, the {shares}: {limits}.",)


def _frame(rows: Sequence[str], cells: Mapping):
    import pandas

    columns = {"row": list(rows)}
    for name in ARTICULATION:
        for part in PARTS:
            columns[name if part == "value" else f"{name}_{part}"] = [cells[row, name][part] for row in rows]
    return pandas.DataFrame(columns)
