"""Confidence intervals of corpus figures: percentile bootstrap over utterances (Efron 1979), and paired quotients.

Utterances are drawn, not frames, because the frames of one utterance depend on each other. All rows of a table share
the same draws, so that a quotient of two rows is a paired statistic. Where a row has repetitions (seeds), these are
drawn too, for each row apart: two networks of one seed have nothing in common.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import Metric, metric_named, quotient, statistics_of, total
from visualspeech.fields import MAX_SEED, Settings, setting

#: Statistics of a measure up to which they are summed column by column.
WIDE = 16


@dataclass(frozen=True)
class BootstrapSettings(Settings):
    """Bootstrap confidence intervals over utterances, and over seeds where there are several."""

    section = "tables.bootstrap"
    samples: int = setting(2000, "Number of bootstrap samples.", minimum=1, maximum=100_000)
    level: float = setting(0.95, "Confidence level of the intervals, for example 0.95.", above=0, below=1)
    seed: int = setting(0, "Seed of the bootstrap samples.", minimum=0, maximum=MAX_SEED)

    def text(self, measured: MeasuredRows) -> str:
        """Description of the intervals of rows, for the header of a table."""
        over = "utterances and seeds" if any(len(one) > 1 for one in measured.repetitions.values()) else "utterances"
        return f"{self.level * 100:g} % percentile bootstrap over {over}, {self.samples} samples, seed {self.seed}"


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
    dtype = np.int32 if utterances < 2**31 else np.int64
    return generator.integers(utterances, size=(settings.samples, utterances), dtype=dtype)


@dataclass(frozen=True)
class Sampled:
    """A corpus figure and its values in the bootstrap samples, shape (samples,)."""

    value: float
    samples: np.ndarray


def sample(table, metric: Metric, drawn: np.ndarray) -> Sampled:
    """A measure over all utterances and over those of each bootstrap sample.

    Parameters
    ----------
    table : statistics of the utterances (:func:`visualspeech.evaluation.scoring.score_table`)
    drawn : from :func:`draws`
    """
    statistics = statistics_of(table, metric)
    return Sampled(float(metric.value(total(statistics))), metric.value(_sums(statistics, drawn)))


def sample_row(
    measured: MeasuredRows, name: str, metric: Metric, drawn: np.ndarray, settings: BootstrapSettings
) -> Sampled:
    """As :func:`sample`, of one row; of a pooled one, its repetitions are drawn with replacement in each sample."""
    tables = measured.repeated(name)
    if len(tables) == 1:
        return sample(tables[0], metric, drawn)
    generator, count = np.random.default_rng([settings.seed, *name.encode()]), len(tables)
    shares = generator.multinomial(count, np.full(count, 1 / count), size=len(drawn)) / count
    every = [statistics_of(table, metric) for table in tables]
    sums = sum(share[:, None] * _sums(one, drawn) for share, one in zip(shares.T, every, strict=True))
    whole = np.mean([total(one) for one in every], axis=0)
    return Sampled(float(metric.value(whole)), metric.value(sums))


def _sums(statistics: np.ndarray, drawn: np.ndarray) -> np.ndarray:
    """Sums of statistics (utterances, k) over the utterances of each sample, (samples, k)."""
    # Blocks limit the memory.
    rows = max(1, 2_000_000 // drawn.shape[1])
    return np.concatenate([selected(statistics, drawn[start : start + rows]) for start in range(0, len(drawn), rows)])


def selected(statistics: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Sums of statistics (utterances, k) over chosen utterances, indices (..., n) -> (..., k).

    Plain sums, which, unlike matrix products, do not depend on the threads of a library.
    """
    if statistics.shape[1] <= WIDE:
        return np.stack([column[chosen].sum(axis=-1) for column in statistics.T], axis=-1)
    from scipy.sparse import csr_array

    # Hundreds of columns: each row of the statistics is read once, not once per column.
    size, rows = chosen.size, chosen.size // chosen.shape[-1]
    ends = np.arange(0, size + 1, chosen.shape[-1])
    counts = csr_array((np.ones(size), chosen.reshape(-1), ends), shape=(rows, len(statistics)))
    return (counts @ np.ascontiguousarray(statistics)).reshape(*chosen.shape[:-1], -1)


def figure(sampled: Sampled, level: float) -> Figure:
    """A corpus figure with its percentile interval of the given confidence, for example 0.95."""
    defined = sampled.samples[np.isfinite(sampled.samples)]
    if not len(defined) or not np.isfinite(sampled.value):
        return Figure(sampled.value, np.nan, np.nan)
    low, high = np.quantile(defined, [(1 - level) / 2, (1 + level) / 2])
    return Figure(sampled.value, float(low), float(high))


def relative_figure(row: Sampled, base: Sampled, level: float) -> Figure:
    """A row's figure divided by that of the base row, both from the same draws; NaN if the base's interval holds 0."""
    below = figure(base, level)
    if not (below.low > 0 or below.high < 0):
        return NO_FIGURE
    quotients = quotient(np.stack([row.samples, base.samples], axis=-1))
    return figure(Sampled(row.value / base.value, quotients), level)


def summarise(measured: MeasuredRows, metrics: Sequence[str], settings: BootstrapSettings):
    """The summary of all rows: one line per row and measure.

    Errors are also given as ratios to the training mean, other measures are not: the correlation and variance of the
    training mean are 0 except for chance.

    Parameters
    ----------
    measured : with a row of the training mean
    metrics : names of measures
    settings : of the bootstrap

    Returns
    -------
    DataFrame
        columns ``row metric value low high ratio ratio_low ratio_high``, in the order of the rows and of ``metrics``

    Raises
    ------
    SettingError
        A metric is unknown.
    DataError
        The training mean is missing, or there is no test utterance.
    """
    import pandas

    chosen = [metric_named(name) for name in metrics]
    drawn = draws(measured.utterances, settings)
    below = {metric.name: sample_row(measured, measured.base.name, metric, drawn, settings) for metric in chosen}
    lines = []
    for row in measured.tables:
        for metric in chosen:
            sampled = sample_row(measured, row, metric, drawn, settings)
            own = figure(sampled, settings.level)
            ratio = NO_FIGURE
            if metric.is_error:
                ratio = relative_figure(sampled, below[metric.name], settings.level)
            lines.append((row, metric.name, own.value, own.low, own.high, ratio.value, ratio.low, ratio.high))
    return pandas.DataFrame(
        lines, columns=["row", "metric", "value", "low", "high", "ratio", "ratio_low", "ratio_high"]
    )
