"""How sure a corpus figure is: percentile bootstrap over utterances (Efron 1979), and quotients of paired rows.

Utterances, not frames, are drawn: frames of one utterance depend on each other. All rows of a table share the same
draws, so that a quotient of two rows is drawn as a pair.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.metrics import metric_named, sums
from visualspeech.fields import MAX_SEED, Settings, setting

BASE_ROW = "training_mean"


@dataclass(frozen=True)
class BootstrapSettings(Settings):
    """Bootstrap confidence intervals over utterances."""

    section = "tables.bootstrap"
    samples: int = setting(2000, "Number of bootstrap samples.", minimum=1, maximum=1_000_000)
    level: float = setting(0.95, "Confidence level of the intervals, for example 0.95.", above=0, below=1)
    seed: int = setting(0, "Seed of the bootstrap samples.", minimum=0, maximum=MAX_SEED)


@dataclass(frozen=True)
class Figure:
    """A corpus figure with its interval; NaN where undefined."""

    value: float
    low: float
    high: float


NO_FIGURE = Figure(np.nan, np.nan, np.nan)


def draws(utterances: int, settings: BootstrapSettings) -> np.ndarray:
    """Indices of the drawn utterances, shape (samples, utterances), with replacement.

    Raises
    ------
    DataError
        There is no utterance to draw from.
    """
    if utterances < 1:
        raise DataError("there is no test utterance to evaluate.")
    generator = np.random.default_rng(settings.seed)
    kind = np.int32 if utterances < 2**31 else np.int64
    return generator.integers(utterances, size=(settings.samples, utterances), dtype=kind)


@dataclass(frozen=True)
class Sampled:
    """A corpus figure, and what it is in each bootstrap sample, shape (samples,)."""

    value: float
    samples: np.ndarray


def sample(numerator: np.ndarray, denominator: np.ndarray, drawn: np.ndarray) -> Sampled:
    """``sum(numerator) / sum(denominator)`` over utterances, and over those of each sample.

    Parameters
    ----------
    numerator, denominator : shape (utterances,)
    drawn : from :func:`draws`
    """
    # In blocks, so that memory does not grow with samples times utterances; plain sums, so that the bits do not
    # depend on a linear-algebra library's threads.
    rows = max(1, 2_000_000 // drawn.shape[1])
    samples = [
        _quotient(numerator[block].sum(axis=1), denominator[block].sum(axis=1))
        for block in (drawn[start : start + rows] for start in range(0, len(drawn), rows))
    ]
    return Sampled(float(_quotient(numerator.sum(), denominator.sum())), np.concatenate(samples))


def figure(sampled: Sampled, level: float) -> Figure:
    """A corpus figure with its percentile interval of the given confidence, for example 0.95."""
    defined = sampled.samples[np.isfinite(sampled.samples)]
    if not len(defined) or not np.isfinite(sampled.value):
        return Figure(sampled.value, np.nan, np.nan)
    low, high = np.quantile(defined, [(1 - level) / 2, (1 + level) / 2])
    return Figure(sampled.value, float(low), float(high))


def relative_figure(row: Sampled, base: Sampled, level: float) -> Figure:
    """A row's figure divided by the base row's, both from the same draws.

    Undefined (NaN) where the base row's own interval holds 0: a quotient by what may be nothing says nothing.
    """
    below = figure(base, level)
    if not (below.low > 0 or below.high < 0):
        return NO_FIGURE
    return figure(Sampled(row.value / base.value, _quotient(row.samples, base.samples)), level)


def summarise(tables: Mapping[str, object], metrics: Sequence[str], settings: BootstrapSettings, base: str = BASE_ROW):
    """The summary of all rows: one line a row and measure.

    Parameters
    ----------
    tables : row name (a network or a baseline) -> per-utterance table of :mod:`visualspeech.evaluation.metrics`
    metrics : names of measures
    settings : of the bootstrap
    base : the row that every row is divided by, in the measures of an error. What a prediction gets right (correlation,
        variance kept) is 0 for the training mean but for chance, and no ratio to that says anything

    Returns
    -------
    DataFrame
        columns ``row metric value low high ratio ratio_low ratio_high``, in the order of ``tables`` and ``metrics``

    Raises
    ------
    SettingError
        A metric is unknown.
    DataError
        The base row is missing, or rows were evaluated on different utterances.
    """
    import pandas

    chosen = [metric_named(name) for name in metrics]
    _check_rows(tables, base)
    drawn = draws(len(tables[base]), settings)
    below = {metric.name: sample(*sums(tables[base], metric), drawn) for metric in chosen}
    lines = []
    for row, table in tables.items():
        for metric in chosen:
            sampled = sample(*sums(table, metric), drawn)
            own = figure(sampled, settings.level)
            ratio = NO_FIGURE
            if metric.best == "low":
                ratio = relative_figure(sampled, below[metric.name], settings.level)
            lines.append((row, metric.name, own.value, own.low, own.high, ratio.value, ratio.low, ratio.high))
    return pandas.DataFrame(
        lines, columns=["row", "metric", "value", "low", "high", "ratio", "ratio_low", "ratio_high"]
    )


def _check_rows(tables: Mapping[str, object], base: str) -> None:
    if base not in tables:
        raise DataError(f"the row `{base}` is missing; every row is shown as a ratio to it.")
    expected = [(name, int(frames)) for name, frames in zip(tables[base]["id"], tables[base]["frames"], strict=True)]
    for row, table in tables.items():
        found = [(name, int(frames)) for name, frames in zip(table["id"], table["frames"], strict=True)]
        if found != expected:
            odd = sorted(set(found) ^ set(expected))[:3]
            raise DataError(
                f"`{row}` and `{base}` were evaluated on different utterances or frames ({len(found)} and "
                f"{len(expected)} utterances; for example {odd}). Delete the models folder and run again."
            )


def _quotient(numerator, denominator):
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.asarray(denominator) != 0, np.divide(numerator, denominator), np.nan)
