"""The figure of all systems: positions of its dots, intervals and axis, as the template of the report draws it.

Positions are shares of the width of the plot in percent, so that its text keeps its size at any width.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.evaluation.layout import interval, shown
from visualspeech.evaluation.overview import Band

DIGITS = 2
TICKS = 5


@dataclass(frozen=True)
class Track:
    """One line as it is drawn: positions in percent, and the figure as text.

    Parameters
    ----------
    dots : positions
    ends : positions of the ends of the interval; empty for none
    """

    title: str
    role: str
    note: str
    dots: tuple[str, ...]
    ends: tuple[str, ...]
    value: str
    interval: str


@dataclass(frozen=True)
class DrawnBand:
    """The lines of a system, and the positions of its training mean and floor; empty for none."""

    title: str
    tracks: tuple[Track, ...]
    baseline: str
    floor: str


@dataclass(frozen=True)
class OverviewFigure:
    """The whole figure; ``ticks`` are (position, number) of the axis, which begins at 0."""

    bands: tuple[DrawnBand, ...]
    ticks: tuple[tuple[str, str], ...]


def overview_figure(bands: Sequence[Band]) -> OverviewFigure:
    """The figure of some bands. Its scale ends above the largest figure; intervals beyond it are cut off there."""
    values = np.array([dot.value for band in bands for line in band.lines for dot in line.dots] or [1.0])
    highs = [dot.high for band in bands for line in band.lines if len(line.dots) == 1 for dot in line.dots]
    most = float(np.nanmax([*values, *np.minimum(highs, 1.25 * values.max())]))
    step = tick_step(most)
    end = step * np.ceil(most / step * (1 - 1e-9))
    end = float(end if np.isfinite(end) and end > 0 else 1.0)

    def position(value: float) -> str:
        return f"{min(100.0, max(0.0, 100 * value / end)):.2f}%" if np.isfinite(value) else ""

    drawn = []
    for band in bands:
        tracks = []
        for line in band.lines:
            one = line.dots[0] if len(line.dots) == 1 else None
            low, high = (shown(value, DIGITS) for value in (one.low, one.high)) if one else ("", "")
            ends = (position(one.low), position(one.high)) if one else ()
            tracks.append(
                Track(
                    line.title,
                    line.role,
                    line.note,
                    tuple(position(dot.value) for dot in line.dots),
                    ends if all(ends) else (),
                    shown(one.value, DIGITS) if one else _range([dot.value for dot in line.dots]),
                    interval(low, high),
                )
            )
        drawn.append(DrawnBand(band.title, tuple(tracks), position(band.baseline), position(band.floor)))
    digits = max(0, int(np.ceil(-np.log10(step))))
    count = round(end / step)
    return OverviewFigure(tuple(drawn), tuple((position(i * step), f"{i * step:.{digits}f}") for i in range(count + 1)))


def _range(values: Sequence[float]) -> str:
    return f"{shown(min(values), DIGITS)}–{shown(max(values), DIGITS)}"


def tick_step(most: float, count: int = TICKS) -> float:
    """A step of 1, 2 or 5 times a power of ten that takes about ``count`` steps to a positive number."""
    if not np.isfinite(most) or most <= 0:
        return 1.0
    power = 10.0 ** np.floor(np.log10(most / count))
    return float(next(factor * power for factor in (1, 2, 5, 10) if most / (factor * power) <= count * 1.2))
