"""Figures of viewing tests, as the bytes of PNG files (:mod:`visualspeech.evaluation.plot_style`)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.evaluation.plot_style import COLOURS, TRUTH, new_figure, png_bytes, style

#: Colour of the answers for neither condition, and of ties.
NEUTRAL = "#c9ccd1"
#: Width of a letter below a bar, as a share of the bar's whole length.
LETTER = 0.0088
#: Written across figures of simulated answers, and before their titles.
SIMULATED = "simulated answers"


@dataclass(frozen=True)
class Bar:
    """One bar of shares.

    Parameters
    ----------
    title : beside the bar
    labels : names of the shares, shown below it; empty for none
    shares : shape (k,), NaN for an unknown one
    texts : written into the segments
    published : whether the shares are those of a paper, drawn hatched
    """

    title: str
    labels: tuple[str, ...]
    shares: tuple[float, ...]
    texts: tuple[str, ...]
    published: bool = False


def share_bars(bars: Sequence[Bar], colours: Sequence[str], title: str, simulated: bool = False) -> bytes:
    """Horizontal bars that are divided into shares (Fan et al. 2015, Fig. 4).

    Parameters
    ----------
    colours : of the shares, in their order

    Returns
    -------
    bytes
        a PNG
    """
    labelled = any(bar.labels for bar in bars)
    step = 1.15 if labelled else 0.42
    with style():
        figure = new_figure(8.5, 0.9 + step * len(bars))
        axes = figure.subplots()
        for number, bar in enumerate(bars):
            left, ends = 0.0, [-1.0, -1.0]
            for place, (value, text) in enumerate(zip(bar.shares, bar.texts, strict=True)):
                known = 0.0 if np.isnan(value) else value
                axes.barh(
                    number, known, 0.5 if labelled else 0.8, left=left, color=colours[place], edgecolor="white",
                    hatch="///" if bar.published else None, alpha=0.6 if bar.published else 1.0, linewidth=0.8,
                )  # fmt: skip
                middle = left + known / 2
                if text and known > 0:
                    box = {"facecolor": "white", "edgecolor": "none", "pad": 1.5, "alpha": 0.85}
                    axes.text(middle, number, text, ha="center", va="center", color=TRUTH, fontsize=9, bbox=box)
                if bar.labels and known > 0:
                    # Neighbouring names of narrow shares would overlap in one line.
                    label = shortened(bar.labels[place])
                    half = LETTER * len(label) / 2
                    line = 0 if middle - half > ends[0] else 1
                    ends[line] = middle + half
                    lower = (0.34, 0.5)[line]
                    axes.text(middle, number + lower, label, ha="center", va="center", fontsize=8.5)
                left += known
        axes.set_yticks(range(len(bars)), [shortened(bar.title) for bar in bars])
        axes.set(xlim=(0, 1), ylim=(len(bars) - 0.35, -0.5))
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0 %", "25 %", "50 %", "75 %", "100 %"])
        axes.axvline(0.5, color=TRUTH, linewidth=0.7, linestyle=":", zorder=3)
        axes.grid(False)
        axes.tick_params(axis="y", length=0)
        axes.spines["left"].set_visible(False)
        _titled(figure, title, simulated)
        return png_bytes(figure)


@dataclass(frozen=True)
class Rating:
    """One bar of a figure of ratings.

    Parameters
    ----------
    value, low, high : mean and its interval; NaN where there is none
    above : numbers of the conditions that this one is rated significantly higher than
    firm : those of them for which a second test agrees
    """

    value: float
    low: float
    high: float
    above: tuple[int, ...] = ()
    firm: tuple[int, ...] = ()


def rating_bars(
    questions: Sequence[str],
    conditions: Sequence[str],
    ratings: Sequence[Sequence[Rating]],
    scale: tuple[int, int],
    title: str,
    simulated: bool = False,
) -> bytes:
    """Mean ratings with stars over the bars (Sadoughi and Busso 2017, Fig. 6).

    A star over a bar has the colour of the condition that the bar is significantly higher than. It is filled where both
    tests say so, and hollow where only the first one does.

    Parameters
    ----------
    ratings : of each question, one :class:`Rating` per condition
    scale : lowest and highest rating

    Returns
    -------
    bytes
        a PNG
    """
    width = 0.8 / len(conditions)
    with style():
        figure = new_figure(max(7.0, 1.8 + len(questions) * (0.6 + 0.42 * len(conditions))), 4.2)
        axes = figure.subplots()
        span = scale[1] - scale[0]
        top = float(scale[1])
        for group, row in enumerate(ratings):
            for number, one in enumerate(row):
                place = group + (number - (len(conditions) - 1) / 2) * width
                colour = COLOURS[number % len(COLOURS)]
                label = shortened(conditions[number]) if group == 0 else None
                axes.bar(
                    place, one.value - scale[0], 0.88 * width, bottom=scale[0], color=colour, label=label, zorder=2
                )
                height = one.value
                if np.isfinite([one.low, one.high]).all():
                    ends = [[max(0.0, one.value - one.low)], [max(0.0, one.high - one.value)]]
                    axes.errorbar(place, one.value, ends, fmt="none", ecolor=TRUTH, elinewidth=1, capsize=2, zorder=3)
                    height = max(height, one.high)
                for step, other in enumerate(one.above):
                    at, sign = height + span * (0.045 + 0.042 * step), COLOURS[other % len(COLOURS)]
                    axes.plot(
                        place, at, marker=(5, 1, 0), markersize=7.5, markeredgecolor=sign, markeredgewidth=1,
                        markerfacecolor=sign if other in one.firm else "white", linestyle="none", zorder=4,
                    )  # fmt: skip
                    top = max(top, at + span * 0.04)
        axes.set_xticks(range(len(questions)), questions)
        axes.set_ylim(scale[0], top)
        axes.set_yticks(_ticks(scale))
        axes.set_ylabel("mean rating")
        axes.tick_params(axis="x", length=0)
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=min(5, len(labels)))
        _titled(figure, title, simulated)
        return png_bytes(figure)


def _ticks(scale: tuple[int, int]) -> list[int]:
    step = max(1, round((scale[1] - scale[0]) / 9))
    return list(range(scale[0], scale[1] + 1, step))


def shortened(name: str, most: int = 40) -> str:
    """A name that leaves room for the figure."""
    return name if len(name) <= most else f"{name[: most - 1]}…"


def _titled(figure, title: str, simulated: bool) -> None:
    """Write the title; across a figure of simulated answers, what they are."""
    name = shortened(title, 110)
    figure.suptitle(f"{SIMULATED.capitalize()}: {name}" if simulated else name, x=0.01, ha="left")
    if simulated:
        figure.text(
            0.5, 0.5, SIMULATED.upper(), ha="center", va="center", rotation=14, fontsize=30, color="#b00020",
            alpha=0.22, weight="bold", zorder=10,
        )  # fmt: skip
