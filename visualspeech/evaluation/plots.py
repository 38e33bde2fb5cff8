"""Plots of learning curves, trajectories, bars and appearance modes, as the bytes of PNG files.

The same input gives the same bytes: the style does not depend on the user's matplotlib settings, and the files contain
no date or version.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.plot_style import COLOURS, TRUTH
from visualspeech.evaluation.plot_style import new_figure as _figure
from visualspeech.evaluation.plot_style import png_bytes as _png
from visualspeech.evaluation.plot_style import style as _style
from visualspeech.speech.phones import SILENCE


def learning_curves(panels: Mapping[str, Mapping[str, object]]) -> bytes:
    """Training (dashed) and validation error of each network over the epochs, the best epoch marked.

    Parameters
    ----------
    panels : title of a panel -> name of a network -> table with columns ``epoch``, ``train``, ``validation``

    Returns
    -------
    bytes
        a PNG
    """
    from matplotlib.ticker import LogLocator, NullFormatter

    groups = panels or {"": {}}
    curves = [curve for panel in groups.values() for curve in panel.values()]
    across = min(4, len(groups))
    down = -(-len(groups) // across)
    with _style():
        figure = _figure(9.5 if across == 1 else 11, 3.6 if down == 1 else 0.6 + 2.1 * down)
        grid = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        for axes in grid.flat[len(groups) :]:
            axes.set_visible(False)
        for axes in grid.flat[max(0, len(groups) - across) : len(groups)]:
            axes.tick_params(labelbottom=True)
        for (title, panel), axes in zip(groups.items(), grid.flat, strict=False):
            for number, (name, curve) in enumerate(panel.items()):
                _curve(axes, curve, COLOURS[number % len(COLOURS)], str(name))
            axes.set_title(title)
            axes.xaxis.get_major_locator().set_params(integer=True)
            if across > 1:
                axes.legend(loc="upper right", fontsize=7, handlelength=1.2)
        errors = [np.asarray(curve[part], float) for curve in curves for part in ("train", "validation")]
        finite = np.concatenate([np.zeros(0), *errors])
        finite = finite[np.isfinite(finite)]
        if len(finite) and 0 < finite.min() < finite.max() / 20:
            grid[0, 0].set_yscale("log")
            for axes in grid.flat:
                # Numbers as they are: powers would be formulae, which are switched off.
                axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                axes.yaxis.set_major_formatter("{x:g}")
                axes.yaxis.set_minor_formatter(NullFormatter())
        figure.supxlabel("epoch", fontsize=10)
        figure.supylabel("error", fontsize=10)
        figure.suptitle("Validation error (solid), training error (dashed), best epoch (dot)", x=0.01, ha="left")
        if across == 1 and curves:
            figure.legend(loc="outside right upper")
        return _png(figure)


def _curve(axes, curve, colour: str, name: str) -> None:
    epochs = np.asarray(curve["epoch"])
    train, validation = np.asarray(curve["train"], float), np.asarray(curve["validation"], float)
    axes.plot(epochs, train, color=colour, linestyle="--", linewidth=1.1, alpha=0.75)
    axes.plot(epochs, validation, color=colour, label=name)
    if np.isfinite(validation).any():
        best = int(np.nanargmin(validation))
        axes.plot(epochs[best], validation[best], "o", color=colour, markersize=5)


def trajectories(
    true: np.ndarray,
    predicted: Mapping[str, np.ndarray],
    rate: float,
    phones: Sequence[tuple[str, float, float]] = (),
    count: int = 3,
    name: str = "v",
    title: str = "",
) -> bytes:
    """Predicted and true parameters of one utterance over time, the phones along the time axis.

    Parameters
    ----------
    true : shape (T, N); the first ``count`` columns are drawn, one panel each
    predicted : name of a model -> shape (T, N)
    rate : frames per second
    phones : (label, start, end) in seconds
    count : number of parameters
    name : letter of the parameters in the panels' titles (v: Eq. 6 of Fan et al. 2015)
    title : above the first panel

    Returns
    -------
    bytes
        a PNG

    Raises
    ------
    DataError
        A prediction's shape is not that of the truth.
    """
    from visualspeech.timing import frame_times

    true = np.asarray(true)
    _check_shapes(true, predicted)
    count = min(count, true.shape[1])
    times = frame_times(len(true), rate)
    end = len(true) / rate
    with _style():
        figure = _figure(10.5, 1.55 * count + 1.0)
        panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        for column, axes in enumerate(panels):
            # Phone borders take the place of grid lines.
            axes.grid(False)
            for number, (label, start, stop) in enumerate(phones):
                shade = "#f4f4f2" if label == SILENCE else ("#e6edf5", "#f6f9fc")[number % 2]
                axes.axvspan(start, stop, color=shade, linewidth=0, zorder=0)
            axes.plot(times, true[:, column], color=TRUTH, linewidth=1.9, label="recorded", zorder=2)
            for number, (model, values) in enumerate(predicted.items(), start=1):
                colour = COLOURS[number % len(COLOURS)]
                axes.plot(times, np.asarray(values)[:, column], color=colour, label=str(model), zorder=3)
            axes.set_ylabel(f"{name}{column + 1}", rotation=0, ha="right", va="center")
            axes.margins(y=0.08)
        panels[0].set_title(title if len(title) <= 100 else title[:99] + "…")
        panels[0].set_xlim(0, end)
        panels[-1].set_xlabel("seconds")
        _phone_labels(panels[-1], phones, end)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=min(5, len(labels)))
        return _png(figure)


def parameter(
    true: np.ndarray,
    predicted: Mapping[str, np.ndarray],
    rate: float,
    phones: Sequence[tuple[str, float, float]],
    number: int,
    name: str = "v",
    title: str = "",
) -> bytes:
    """One parameter of an utterance, recorded and predicted, each less its mean; vertical lines where phones begin.

    Fig. 1 of Thangthai et al. (2016).

    Parameters
    ----------
    true : shape (T, N)
    predicted : title of a model -> shape (T, N)
    rate, phones, name, title : as for :func:`trajectories`
    number : of the parameter, from 1

    Returns
    -------
    bytes
        a PNG

    Raises
    ------
    DataError
        There is no such parameter, or a prediction's shape is not that of the truth.
    """
    from visualspeech.timing import frame_times

    true = np.asarray(true)
    if not 1 <= number <= true.shape[1]:
        raise DataError(f"there is no parameter {number}; the visual coding has {true.shape[1]}.")
    _check_shapes(true, predicted)
    times, end = frame_times(len(true), rate), len(true) / rate
    with _style():
        figure = _figure(10.5, 3.4)
        axes = figure.subplots()
        axes.grid(False)
        for _, start, _ in phones:
            axes.axvline(start, color="#c8c8c8", linewidth=0.8, zorder=0)
        curves = {"recorded": true, **predicted}
        for index, (label, values) in enumerate(curves.items()):
            curve = np.asarray(values, np.float64)[:, number - 1]
            colour, width = (TRUTH, 1.9) if index == 0 else (COLOURS[index % len(COLOURS)], 1.6)
            axes.plot(times, curve - curve.mean(), color=colour, linewidth=width, label=str(label))
        axes.set(xlim=(0, end), xlabel="seconds", ylabel=f"{name}{number} less its mean")
        axes.set_title(title if len(title) <= 100 else title[:99] + "…")
        _phone_labels(axes, phones, end)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside upper right", ncols=min(3, len(curves)))
        return _png(figure)


def _check_shapes(true: np.ndarray, predicted: Mapping[str, np.ndarray]) -> None:
    for model, values in predicted.items():
        if np.shape(values) != true.shape:
            raise DataError(f"{model} predicts an array of shape {np.shape(values)}, the truth has {true.shape}.")


def _phone_labels(axes, phones: Sequence[tuple[str, float, float]], end: float) -> None:
    """Write the phones below the last panel, alternating between two rows so that short ones do not overlap."""
    if not phones:
        return
    axes.tick_params(axis="x", pad=26)
    size = float(np.clip(9 - 0.04 * len(phones), 5, 8.5))
    for number, (label, start, stop) in enumerate(phones):
        if start < end:
            axes.annotate(
                str(label),
                ((start + min(stop, end)) / 2, 0),
                xycoords=("data", "axes fraction"),
                xytext=(0, -5 - 11 * (number % 2)),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize=size,
                color="#444444",
                annotation_clip=False,
            )


def grouped_bars(panels: Mapping[str, Mapping[str, Mapping[str, tuple[float, float, float]]]], across: int) -> bytes:
    """Bars with intervals in panels, a bar for each series in each group.

    Parameters
    ----------
    panels : title of a panel -> name of a series -> name of a group -> (figure, lower end, upper end of its interval);
        NaN where there is none
    across : panels side by side; those of one row share their scale

    Returns
    -------
    bytes
        a PNG
    """
    across, series = max(1, across), list(dict.fromkeys(name for panel in panels.values() for name in panel))
    groups = list(dict.fromkeys(name for panel in panels.values() for own in panel.values() for name in own))
    down, width = max(1, -(-len(panels) // across)), 0.8 / max(1, len(series))
    with _style():
        figure = _figure(1.2 + across * max(2.6, 0.5 + 0.75 * len(groups)), 0.6 + 2.3 * down)
        grid = figure.subplots(down, across, sharex=True, sharey="row", squeeze=False)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
        for (title, panel), axes in zip(panels.items(), grid.flat, strict=False):
            for number, name in enumerate(series):
                own = np.array([panel.get(name, {}).get(group, (np.nan,) * 3) for group in groups], float).reshape(
                    -1, 3
                )
                places = np.arange(len(groups)) + (number - (len(series) - 1) / 2) * width
                # A percentile interval need not hold the figure.
                ends = np.maximum([own[:, 0] - own[:, 1], own[:, 2] - own[:, 0]], 0)
                colour = COLOURS[number % len(COLOURS)]
                axes.bar(places, own[:, 0], 0.9 * width, color=colour, label=name, zorder=2)
                known = np.isfinite(ends).all(axis=0)
                axes.errorbar(
                    places[known], own[known, 0], ends[:, known], fmt="none", ecolor=TRUTH, elinewidth=0.9, zorder=3
                )
            axes.axhline(0, color="#888888", linewidth=0.8)
            axes.set_title(title)
            axes.set_xticks(range(len(groups)), groups, rotation=25 if len(groups) > 3 else 0)
        if not groups:
            figure.suptitle("Too few utterances", x=0.01, ha="left")
        if series:
            handles = grid[0, 0].get_legend_handles_labels()
            figure.legend(*handles, loc="outside upper right", ncols=min(4, len(series)))
        return _png(figure)


def mode_pictures(
    pictures: np.ndarray, rows: Sequence[str] | None = None, columns: Sequence[str] | None = None
) -> bytes:
    """Rendered faces in a grid, with one row per mode and one column per step along it.

    Parameters
    ----------
    pictures : (modes, steps, H, W, 3) uint8 RGB
    rows, columns : captions; by default ``v1``, ``v2``, ... and the steps from -3 to 3 standard deviations

    Returns
    -------
    bytes
        a PNG

    Raises
    ------
    DataError
        The array has another shape or type.
    """
    pictures = np.asarray(pictures)
    if pictures.ndim != 5 or pictures.shape[-1] != 3 or pictures.dtype != np.uint8 or not pictures.size:
        raise DataError(
            f"pictures of modes must be (modes, steps, H, W, 3) uint8, not {pictures.shape} {pictures.dtype}."
        )
    modes, steps, height, width = pictures.shape[:4]
    rows = rows if rows is not None else [f"v{mode + 1}" for mode in range(modes)]
    columns = columns if columns is not None else [_deviations(step) for step in np.linspace(-3, 3, steps)]
    each = 1.5
    with _style():
        figure = _figure(each * steps + 0.5, each * height / width * modes + 0.4)
        panels = figure.subplots(modes, steps, squeeze=False)
        for (mode, step), axes in np.ndenumerate(panels):
            axes.imshow(pictures[mode, step], interpolation="lanczos")
            axes.set(xticks=[], yticks=[])
            axes.grid(False)
            axes.spines[:].set_visible(False)
            if mode == 0:
                axes.set_title(columns[step], loc="center")
            if step == 0:
                axes.set_ylabel(rows[mode], rotation=0, ha="right", va="center")
        return _png(figure)


def _deviations(step: float) -> str:
    return "mean" if abs(step) < 1e-9 else f"{step:+.3g} σ".replace("-", "−")
