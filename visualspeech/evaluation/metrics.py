"""Objective measures of a predicted face sequence: Eq. 16-19 of Fan et al. (2015), two of Thangthai et al. (2016),
three others, and those of Sadoughi and Busso (2017) by region of the face.

An utterance is represented by *sufficient statistics*: numbers whose sums over utterances determine the figure of a
corpus. Eq. 16-19, the lip distance and the global-variance ratio are quotients of two sums; the concordance correlation
is a function of the moments of prediction and truth (:func:`concordance`). A new measure is an entry of
:data:`METRICS`; if it needs further statistics, :func:`visualspeech.evaluation.scoring.score` computes them, or for the
regions of a face :func:`visualspeech.evaluation.regions.region_statistics`.

Every measure belongs to a *protocol*:

``centred``
    prediction and truth are taken less their own means over the utterance. The offset of an utterance is the position
    and light of its recording, which neither text nor sound tells. So no model is asked for it, and none gains from
    knowing something about it.
``absolute``
    the prediction as it is, against the truth with its offset. Where drift was removed before the visual coding, only
    points have a truth with offset.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count, takewhile

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.face.markers import REGIONS

CENTRED, ABSOLUTE = "centred", "absolute"
PROTOCOLS = {
    CENTRED: "centred: prediction and truth each less its own mean over the utterance",
    ABSOLUTE: "absolute: prediction as it is, truth with the offset of its recording",
}


def quotient(sums: np.ndarray) -> np.ndarray:
    """Numerator over denominator, (..., 2) -> (...); NaN where the denominator is 0."""
    numerator, denominator = sums[..., 0], sums[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(denominator != 0, np.divide(numerator, denominator), np.nan)


def concordance(sums: np.ndarray) -> np.ndarray:
    """Mean over N dimensions of Lin's concordance correlation coefficient, (..., 1 + 5 N) -> (...).

    ``2 cov(x, y) / (var(x) + var(y) + (mean(x) - mean(y))^2)`` of prediction x and truth y over all frames (Lin 1989;
    Sadoughi & Busso 2017). A dimension in which both are one and the same constant has no coefficient and is left out;
    NaN where no dimension has one.

    Parameters
    ----------
    sums : number of frames, then N sums each of x, y, x^2, y^2 and x y
    """
    frames = sums[..., :1]
    parts = sums[..., 1:].reshape(*sums.shape[:-1], 5, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y, xx, yy, xy = (parts[..., index, :] / frames for index in range(5))
        spread = np.maximum(xx - x**2, 0) + np.maximum(yy - y**2, 0) + (x - y) ** 2
        each = np.where(spread > 0, 2 * (xy - x * y) / spread, np.nan)
        defined = np.isfinite(each)
        return np.where(defined, each, 0.0).sum(axis=-1) / defined.sum(axis=-1)


def region_concordance(sums: np.ndarray) -> np.ndarray:
    """As :func:`concordance`, from fewer sums: (..., 1 + 4 N) -> (...).

    Parameters
    ----------
    sums : number of frames, then N sums each of x, y, x^2 + y^2 and x y
    """
    parts = sums[..., 1:].reshape(*sums.shape[:-1], 4, -1)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y, squares, products = (parts[..., index, :] / sums[..., :1] for index in range(4))
    # The variances and the squared difference of the means add up to this.
    return _mean_agreement(products - x * y, squares - 2 * x * y, squares)


def centred_concordance(sums: np.ndarray) -> np.ndarray:
    """As :func:`concordance`, of x and y whose sums are 0: N sums each of x^2 + y^2 and x y, (..., 2 N) -> (...)."""
    squares, products = np.moveaxis(sums.reshape(*sums.shape[:-1], 2, -1), -2, 0)
    return _mean_agreement(products, squares, squares)


def _mean_agreement(covariance: np.ndarray, spread: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Mean over dimensions of twice the covariance over the spread, where that is more than rounding of ``size``."""
    defined = spread > 1e-12 * size
    each = np.where(defined, 2 * covariance / np.where(defined, spread, 1.0), 0.0)
    with np.errstate(invalid="ignore"):
        return each.sum(axis=-1) / defined.sum(axis=-1)


@dataclass(frozen=True)
class Metric:
    """A measure: its computation from the statistics of utterances, and its description in tables.

    Parameters
    ----------
    name : in settings and in files of figures
    title : heading in tables
    definition : one sentence, with the number of the equation if the paper has one
    best : best figures are ``low``, ``high``, or near ``one`` or ``zero``
    columns : statistics that it needs, columns of the table of :func:`score_table`; a name without a column stands for
        the vector of the columns ``name.0``, ``name.1``, ...
    value : sums of these statistics over utterances (..., k) -> figure (...)
    unit : unit of the figure, empty for none
    protocol : of :data:`PROTOCOLS`
    region : of the face that it is of, for codings with regions; empty for the whole vector
    """

    name: str
    title: str
    definition: str
    best: str
    columns: tuple[str, ...]
    value: Callable[[np.ndarray], np.ndarray] = quotient
    unit: str = ""
    protocol: str = CENTRED
    region: str = ""

    def cost(self, figure):
        """A monotonic function of the figure of which lower values are better."""
        return {"low": figure, "high": -figure, "one": abs(figure - 1), "zero": abs(figure)}[self.best]

    @property
    def is_error(self) -> bool:
        """Whether 0 is a perfect figure, so that ratios of figures are meaningful."""
        return self.best == "low"

    @property
    def is_additive(self) -> bool:
        """Whether the difference of two rows is a sum over utterances divided by a denominator that all rows share."""
        return self.value is quotient and self.best in ("low", "high")

    @property
    def heading(self) -> str:
        """Title with the unit and an arrow in the direction of better figures."""
        arrow = {"low": "↓", "high": "↑", "one": "→\u00a01", "zero": "→\u00a00"}[self.best]
        return f"{self.title}{f' [{self.unit}]' if self.unit else ''}\u00a0{arrow}"


_CENTRED = (
    Metric(
        "rmse_shape",
        "RMSE(shape)",
        "Eq. 16: mean over frames of the root mean square error of the shape parameters a",
        "low",
        ("rmse_shape_sum", "frames"),
    ),
    Metric(
        "rmse_texture",
        "RMSE(texture)",
        "Eq. 17: mean over frames of the root mean square error of the texture parameters b",
        "low",
        ("rmse_texture_sum", "frames"),
    ),
    Metric(
        "rmse_appearance",
        "RMSE(appearance)",
        "Eq. 18: mean over frames of the root mean square error of the appearance parameters v",
        "low",
        ("rmse_appearance_sum", "frames"),
    ),
    Metric(
        "corr",
        "CORR",
        "Eq. 19: mean over frames of the correlation, over the dimensions of v, of prediction and truth "
        "(a frame with an undefined correlation counts as 0)",
        "high",
        ("corr_sum", "frames"),
    ),
    Metric(
        "lip_distance_px",
        "Lip distance",
        "mean over frames and lip points of the Euclidean distance between the point decoded from v and the "
        "tracked point, in pixels of the normalised face",
        "low",
        ("lip_distance_px_sum", "frames"),
        unit="px",
    ),
    Metric(
        "gv_ratio",
        "Global-variance ratio",
        "variance of v over time within utterances, summed over its dimensions: predicted divided by true "
        "(below 1: over-smoothed)",
        "one",
        ("gv_ratio_sum", "true_scatter"),
    ),
    Metric(
        "ccc",
        "CCC",
        "mean over the dimensions of v of the concordance correlation coefficient of prediction and truth over all "
        "frames (Sadoughi & Busso 2017)",
        "high",
        ("frames", "predicted", "true", "predicted_squared", "true_squared", "predicted_true"),
        value=concordance,
    ),
    Metric(
        "corr_first5",
        "Correlation (v1-v5)",
        "correlation over time of prediction and truth within an utterance, averaged over the first five dimensions of "
        "v and then over utterances (Thangthai et al. 2016; a dimension with an undefined correlation counts as 0)",
        "high",
        ("corr_first5_sum", "utterances"),
    ),
    Metric(
        "rmse_first5",
        "RMSE (v1-v5)",
        "root mean square error over time within an utterance, averaged over the first five dimensions of v and then "
        "over utterances (Thangthai et al. 2016)",
        "low",
        ("rmse_first5_sum", "utterances"),
    ),
)


def absolute(metric: Metric) -> Metric:
    """The measure of the same formula in the absolute protocol, with statistics of its own."""
    name = f"{metric.name}_absolute"
    if metric.value is quotient:
        columns = (f"{name}_sum", *metric.columns[1:])
    else:
        columns = tuple(one if one == "frames" else f"{one}_absolute" for one in metric.columns)
    return replace(metric, name=name, columns=columns, protocol=ABSOLUTE)


#: In the absolute protocol. The global-variance ratio and the correlation over time are the same in both.
_ABSOLUTE = tuple(absolute(metric) for metric in _CENTRED if metric.name not in ("gv_ratio", "corr_first5"))


def of_region(region: str) -> tuple[Metric, ...]:
    """The measures of a region of the face, whose parameters are D of the coding's, in both protocols.

    The concordance correlation and the mean squared error of Sadoughi and Busso (2017), Table 1, are those over all
    test frames in the absolute protocol.
    """
    face, agreement = f"{region} face", "concordance correlation coefficient of prediction and truth of each parameter"
    error, parameters = "squared error of the parameters of the region", "averaged over the parameters of the region"
    ccc = Metric(
        f"ccc_{region}",
        f"CCC, {face}",
        f"{agreement} over all test frames, as one sequence, {parameters} (Sadoughi & Busso 2017, Eq. 1)",
        "high",
        (f"squares_{region}", f"products_{region}"),
        value=centred_concordance,
        region=region,
    )
    mse = Metric(
        f"mse_{region}",
        f"MSE, {face}",
        f"{error}, averaged over them and over all test frames",
        "low",
        (f"mse_{region}_sum", "frames"),
        region=region,
    )
    ccc_turn = Metric(
        f"ccc_{region}_turn",
        f"CCC per turn, {face}",
        f"{agreement} within an utterance (turn), {parameters} and then over utterances (an utterance in which none is "
        "defined counts as 0)",
        "high",
        (f"ccc_{region}_turn_sum", "utterances"),
        region=region,
    )
    mse_turn = Metric(
        f"mse_{region}_turn",
        f"MSE per turn, {face}",
        f"{error}, averaged over them and the frames of an utterance (turn) and then over utterances",
        "low",
        (f"mse_{region}_turn_sum", "utterances"),
        region=region,
    )
    variance = Metric(
        f"gv_ratio_{region}",
        f"Global-variance ratio, {face}",
        "variance of the parameters of the region over time within utterances, summed over them: predicted divided by "
        "true (below 1: over-smoothed)",
        "one",
        (f"predicted_scatter_{region}", f"true_scatter_{region}"),
        region=region,
    )
    moments = ("frames", *(f"{name}_{region}_absolute" for name in ("predicted", "true", "squares", "products")))
    whole = replace(ccc, name=f"ccc_{region}_absolute", columns=moments, value=region_concordance, protocol=ABSOLUTE)
    return (ccc, mse, ccc_turn, mse_turn, variance, whole, *map(absolute, (mse, ccc_turn, mse_turn)))


#: Measures of codings with regions, by name.
REGIONAL: dict[str, Metric] = {metric.name: metric for region in REGIONS for metric in of_region(region)}
METRICS: dict[str, Metric] = {metric.name: metric for metric in (*_CENTRED, *_ABSOLUTE)} | REGIONAL


def metric_named(name: str) -> Metric:
    """The measure with that name.

    Raises
    ------
    SettingError
        There is none; the message lists the known ones.
    """
    if name not in METRICS:
        raise SettingError(f"unknown metric `{name}` in the settings of the tables. Known: {', '.join(METRICS)}.")
    return METRICS[name]


def statistics_of(table, metric: Metric) -> np.ndarray:
    """What a measure needs of each utterance, (utterances, k): its figure follows from sums over any utterances.

    Raises
    ------
    DataError
        The table lacks a column of the measure.
    """
    found = [_columns(table, name) for name in metric.columns]
    if not all(found):
        name = metric.columns[found.index([])]
        raise DataError(
            f"a table of statistics lacks the column `{name}`, which `{metric.name}` needs. Delete the table and run "
            "again."
        )
    # Contiguous columns, so that the bits of a sum do not depend on the other columns.
    return np.array([table[column].to_numpy(dtype=np.float64) for columns in found for column in columns]).T


def is_measured(table, metric: Metric) -> bool:
    """Whether a table holds all statistics of a measure."""
    return all(_columns(table, name) for name in metric.columns)


def _columns(table, name: str) -> list[str]:
    """The column of that name, or those of a vector; empty where there is neither."""
    if name in table:
        return [name]
    return [f"{name}.{i}" for i in takewhile(lambda i: f"{name}.{i}" in table, count())]


def total(statistics: np.ndarray) -> np.ndarray:
    """Sums over utterances, (..., utterances, k) -> (..., k)."""
    return np.stack([statistics[..., index].sum(axis=-1) for index in range(statistics.shape[-1])], axis=-1)


def over_utterances(table, metric: Metric) -> tuple[float, float]:
    """Mean over utterances of the figure of each, and its sample standard deviation (NaN of a single utterance).

    Utterances whose figure is undefined are left out.
    """
    each = metric.value(statistics_of(table, metric))
    each = each[np.isfinite(each)]
    if not len(each):
        return float("nan"), float("nan")
    return float(each.mean()), float(each.std(ddof=1)) if len(each) > 1 else float("nan")


def corpus_figure(table, name: str) -> float:
    """Eq. 16-19 (or another of :data:`METRICS`) over all utterances of a table of statistics; NaN where undefined."""
    metric = metric_named(name)
    return float(metric.value(total(statistics_of(table, metric))))
