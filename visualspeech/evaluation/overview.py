"""All systems of a corpus at a glance: the lines of one figure, and a short table of what a person chooses by.

Both show figures of the table across systems (:mod:`visualspeech.evaluation.across_systems`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from visualspeech.evaluation.conclusions import MEASURE, Conclusion
from visualspeech.evaluation.layout import Cell, Row, Table, best_of, interval, shown
from visualspeech.evaluation.lip_metrics import ACROSS, COSTS, DIGITS
from visualspeech.models.rows import ORACLE, ModelRow

#: Models of a system that have a line of their own in the figure; further ones share a line.
MAX_MODELS = 5
#: Trivial baselines beside the training mean that have a line of their own.
MAX_BASELINES = 2
#: Lines of the short table, and its columns.
SHORT_ROWS = 6
SHORT_COLUMNS = ("lip_distance", "opening_corr", "width_corr", "closure", "frames_per_second", "parameters")
SHORT_HEADINGS = {
    "lip_distance": "Lip distance",
    "opening_corr": "Opening, CORR",
    "width_corr": "Width, CORR",
    "closure": "Lips closed on /p b m/",
    "frames_per_second": "Speed",
    "parameters": "Parameters",
}


class Shown(NamedTuple):
    """A figure of the table across systems; NaN where there is none."""

    value: float
    low: float
    high: float


NOTHING = Shown(np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class SystemOverview:
    """What the overview knows of a system.

    Parameters
    ----------
    name, title : of the system
    rows : name of a pooled row -> row, in the order of the tables
    conclusion : about it
    spoken : name of the pooled row that its videos show; empty for none
    """

    name: str
    title: str
    rows: Mapping[str, ModelRow]
    conclusion: Conclusion
    spoken: str = ""


@dataclass(frozen=True)
class Line:
    """One line of the figure: the dots of one or several rows.

    Parameters
    ----------
    title : of the row, or of the rows together
    role : ``best``, ``model``, ``baseline``, ``floor``, or ``others`` for several models
    dots : figures; only a single one is shown with its interval
    note : why the row is shown, in a few words
    """

    title: str
    role: str
    dots: tuple[Shown, ...]
    note: str = ""


@dataclass(frozen=True)
class Band:
    """The lines of one system; ``baseline`` and ``floor`` are the figures of its training mean and round trip."""

    title: str
    lines: tuple[Line, ...]
    baseline: float = np.nan
    floor: float = np.nan


def figures_of(frame) -> dict[tuple[str, str, str], Shown]:
    """(system, row, measure) -> lip figure, of a data frame of ``systems_frame``."""
    lips = frame[frame["part"] == "lips"]
    return {(one.system, one.row, one.metric): Shown(one.value, one.low, one.high) for one in lips.itertuples()}


def bands(systems: Sequence[SystemOverview], figures: Mapping) -> tuple[Band, ...]:
    """The lines of the figure of all systems; rows without a figure and oracle rows are left out.

    Parameters
    ----------
    figures : from :func:`figures_of`
    """
    return tuple(band for system in systems for band in (_band(system, figures),) if band.lines)


def _band(system: SystemOverview, figures: Mapping) -> Band:
    dots = {name: figures.get((system.name, name, MEASURE), NOTHING) for name in system.rows}
    dots = {name: dot for name, dot in dots.items() if np.isfinite(dot.value)}
    choice = system.conclusion.choice
    ranked = [name for name in (choice.ranked if choice else ()) if name in dots]
    models = ranked + [name for name in dots if system.rows[name].role == "model" and name not in ranked]
    first = _first(system, models)
    own = (
        models if len(models) <= MAX_MODELS + 1 else (first + [one for one in models if one not in first])[:MAX_MODELS]
    )
    lines = [
        Line(system.rows[name].title, "best" if _is_best(system, name) else "model", (dots[name],), _note(system, name))
        for name in sorted(own, key=models.index)
    ]
    others = [name for name in models if name not in own]
    if others:
        lines.append(Line(f"{len(others)} further models", "others", tuple(dots[name] for name in others)))
    mean = choice.baseline if choice else ""
    trivial = [name for name in dots if system.rows[name].role == "baseline"]
    kept = [name for name in trivial if name != mean][-MAX_BASELINES:]
    lines += [Line(system.rows[one].title, "baseline", (dots[one],)) for one in trivial if one in kept or one == mean]
    floors = [name for name in dots if system.rows[name].role == "floor"]
    lines += [Line(system.rows[name].title, "floor", (dots[name],)) for name in floors]
    floor = dots[floors[0]].value if floors else np.nan
    return Band(system.title, tuple(lines), dots.get(mean, NOTHING).value, floor)


def _first(system: SystemOverview, models: Sequence[str]) -> list[str]:
    """The models that are named first: the best one, the reference, and the one of the videos."""
    choice = system.conclusion.choice
    wanted = [choice.best, choice.reference] if choice else []
    return [name for name in dict.fromkeys((*wanted, system.spoken)) if name in models]


def _is_best(system: SystemOverview, name: str) -> bool:
    return system.conclusion.choice is not None and name == system.conclusion.choice.best


def _note(system: SystemOverview, name: str) -> str:
    notes = ("best on validation" if _is_best(system, name) else "", "in the videos" if name == system.spoken else "")
    return ", ".join(filter(None, notes))


def short_table(systems: Sequence[SystemOverview], figures: Mapping, digits: int = 3) -> Table | None:
    """A table of about six rows: of each system the best model, the reference, the trivial baselines, the floor.

    The systems take turns, so that each has at least one row. None where there is nothing to show.
    """
    turns = [_wanted(system, figures) for system in systems]
    turn_by_turn = [one for turn in zip_longest(*turns) for one in turn if one is not None]
    chosen = turn_by_turn[: max(SHORT_ROWS, sum(map(bool, turns)))]
    if not chosen:
        return None
    cells = {(system.name, name): _cells(system.name, name, figures, digits) for system, name in chosen}
    models = [(system.name, name) for system, name in chosen if system.rows[name].role == "model"]
    best = {
        metric: best_of(ACROSS[metric], {key: cells[key][number].text for key in models})
        for number, metric in enumerate(SHORT_COLUMNS)
    }
    rows = []
    for system in systems:
        own = sorted((name for one, name in chosen if one is system), key=partial(_place, system))
        rows += [Row(system.title)] if own and len(systems) > 1 else []
        for name in own:
            key = (system.name, name)
            marked = (
                Cell(cell.text, cell.small, key in best[metric])
                for cell, metric in zip(cells[key], SHORT_COLUMNS, strict=True)
            )
            note = _note(system, name)
            title = f"{system.rows[name].title} ({note})" if note else system.rows[name].title
            rows.append(Row(title, tuple(marked), system.rows[name].role))
    headings = tuple(_heading(name) for name in SHORT_COLUMNS)
    notes = (
        "The best value of the models shown is bold. Lip distance is in % of the distance between the outer eye "
        "corners; speed is in frames of the camera per second of one processor core.",
    )
    return Table("The table in short", headings, tuple(rows), notes=notes)


def _wanted(system: SystemOverview, figures: Mapping) -> list[tuple[SystemOverview, str]]:
    """The rows of a system in the order in which they are worth showing."""
    choice = system.conclusion.choice
    ranked = list(choice.ranked) if choice else []
    baselines = [choice.baseline] if choice and choice.baseline else []
    floors = [name for name, row in system.rows.items() if row.role == "floor"]
    others = [name for name, row in system.rows.items() if row.role != ORACLE]
    names = dict.fromkeys((*_first(system, ranked)[:2], *baselines, *_first(system, ranked), *floors, *ranked, *others))
    return [(system, name) for name in names if np.isfinite(figures.get((system.name, name, MEASURE), NOTHING).value)]


def _place(system: SystemOverview, name: str) -> int:
    """Models stand above baselines, and these above the floor."""
    return ("model", "baseline", "floor").index(system.rows[name].role)


def _cells(system: str, name: str, figures: Mapping, digits: int) -> list[Cell]:
    cells = []
    for metric in SHORT_COLUMNS:
        found, own = figures.get((system, name, metric), NOTHING), DIGITS.get(metric, min(digits, 2))
        value, low, high = (shown(one, own) for one in found)
        plain = metric in COSTS or (low, high) == (value, value)
        cells.append(Cell(value, "" if plain else interval(low, high)))
    return cells


def _heading(name: str) -> str:
    return ACROSS[name].heading.replace(ACROSS[name].title, SHORT_HEADINGS[name], 1)
