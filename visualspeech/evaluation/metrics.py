"""Objective measures of a predicted face sequence: Eq. 16-19 of Fan et al. (2015), and three others.

An utterance is represented by *sufficient statistics*: numbers whose sums over utterances determine the figure of a
corpus. Eq. 16-19, the lip distance and the global-variance ratio are quotients of two sums; the concordance correlation
is a function of the moments of prediction and truth (:func:`concordance`). A new measure is an entry of
:data:`METRICS`; if it needs further statistics, :func:`score` computes them.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import count, takewhile

import numpy as np

from visualspeech.errors import DataError, SettingError


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
    """

    name: str
    title: str
    definition: str
    best: str
    columns: tuple[str, ...]
    value: Callable[[np.ndarray], np.ndarray] = quotient
    unit: str = ""

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


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
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
    )
}


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


@dataclass(frozen=True)
class FaceSequence:
    """One utterance's lower face, as predicted or as recorded; T frames at one rate.

    Predicted: ``shape``, ``texture`` and ``lips`` are decoded from the predicted ``appearance`` (Eq. 6-7). Recorded:
    ``shape`` and ``texture`` are the parameters of the recorded face before the joint PCA, ``lips`` its tracked
    points in the frontal frame. Where slow drift is removed, it is removed from all four of them.

    Parameters
    ----------
    appearance : v, shape (T, N_appearance)
    shape : a, shape (T, N_shape)
    texture : b, shape (T, N_texture)
    lips : the lip points in pixels of the normalised face, shape (T, 20, 2)
    """

    appearance: np.ndarray
    shape: np.ndarray
    texture: np.ndarray
    lips: np.ndarray


def lip_points(shape: np.ndarray, indices: Iterable[int]) -> np.ndarray:
    """The lip points (T, 20, 2) of shapes (T, 2N) in the order of Eq. 1 (all x, then all y)."""
    shape = np.asarray(shape)
    points = np.stack(np.split(shape, 2, axis=1), axis=2)
    return points[:, np.asarray(indices)]


def frame_rmse(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """``sqrt(||predicted_t - true_t||^2 / N)`` of each frame: (T, N), (T, N) -> (T,). The summand of Eq. 16-18."""
    predicted, true = _pair(predicted, true)
    return np.sqrt(np.mean((predicted - true) ** 2, axis=1))


def frame_correlation(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Pearson correlation over the dimensions of each frame: (T, N), (T, N) -> (T,). The summand of Eq. 19.

    NaN where it is undefined: one of the two vectors is constant over its dimensions (so always where N is 1).
    """
    predicted, true = _pair(predicted, true)
    x = predicted - predicted.mean(axis=1, keepdims=True)
    y = true - true.mean(axis=1, keepdims=True)
    # Rounding errors make the deviations of a constant vector about 1e-16 of its size, not 0.
    constant = np.zeros(len(x), dtype=bool)
    for centred, values in ((x, predicted), (y, true)):
        constant |= np.abs(centred).max(axis=1) <= 1e-14 * np.abs(values).max(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        x = x / np.linalg.norm(x, axis=1, keepdims=True)
        y = y / np.linalg.norm(y, axis=1, keepdims=True)
    return np.where(constant, np.nan, np.clip(np.sum(x * y, axis=1), -1.0, 1.0))


def frame_point_distance(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Mean Euclidean distance of the points of each frame: (T, P, 2), (T, P, 2) -> (T,), in the unit of the points."""
    predicted, true = _pair(predicted, true)
    return np.linalg.norm(predicted - true, axis=2).mean(axis=1)


def scatter_over_time(values: np.ndarray) -> float:
    """Sum over frames and dimensions of the squared deviation from the utterance's mean: (T, N) -> number."""
    values = np.asarray(values, dtype=np.float64)
    return float(np.sum((values - values.mean(axis=0)) ** 2))


def score(utterance_id: str, predicted: FaceSequence, true: FaceSequence, rate: float) -> dict:
    """Statistics of one utterance: one row of the table of :func:`score_table`.

    Columns: ``id``, ``rate`` (Hz), ``frames``; for each quotient of :data:`METRICS` its value in the utterance times
    its weight (``rmse_shape_sum``, ...; the weight is the number of frames, of ``gv_ratio_sum`` the true scatter);
    ``corr_undefined``, the number of frames whose correlation is undefined (each adds 0 to the sum of Eq. 19 and 1 to
    its count of frames, so that every row of a table is divided by the same number); ``true_scatter``; and for each
    dimension of the appearance parameters the sums of :func:`concordance`.

    Raises
    ------
    DataError
        Lengths or dimensions differ, there are no frames, or a value is not finite.
    """
    for name in ("appearance", "shape", "texture", "lips"):
        _check_pair(utterance_id, name, getattr(predicted, name), getattr(true, name), len(true.appearance))
    correlation = frame_correlation(predicted.appearance, true.appearance)
    undefined = np.isnan(correlation)
    scatter = scatter_over_time(true.appearance)
    means = {
        "rmse_shape": float(frame_rmse(predicted.shape, true.shape).mean()),
        "rmse_texture": float(frame_rmse(predicted.texture, true.texture).mean()),
        "rmse_appearance": float(frame_rmse(predicted.appearance, true.appearance).mean()),
        "corr": float(np.where(undefined, 0.0, correlation).mean()),
        "lip_distance_px": float(frame_point_distance(predicted.lips, true.lips).mean()),
    }
    kept = scatter_over_time(predicted.appearance) / scatter if scatter > 0 else 0.0
    return {
        "id": utterance_id,
        "rate": float(rate),
        "frames": len(true.appearance),
        **{f"{name}_sum": mean * len(true.appearance) for name, mean in means.items()},
        "corr_undefined": int(undefined.sum()),
        "gv_ratio_sum": kept * scatter,
        "true_scatter": scatter,
        **_moments(predicted.appearance, true.appearance),
    }


def _moments(predicted, true) -> dict[str, float]:
    x, y = _pair(predicted, true)
    names = METRICS["ccc"].columns[1:]
    sums = zip(names, (x, y, x * x, y * y, x * y), strict=True)
    return {f"{name}.{i}": float(total) for name, values in sums for i, total in enumerate(values.sum(axis=0))}


def score_table(rows: Iterable[dict]):
    """The table of statistics (:class:`pandas.DataFrame`) of rows from :func:`score`, sorted by id."""
    import pandas

    rows = list(rows)
    table = pandas.DataFrame(rows, columns=None if rows else ["id", "rate", "frames"])
    return table.sort_values("id", ignore_index=True)


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


def corpus_figure(table, name: str) -> float:
    """Eq. 16-19 (or another of :data:`METRICS`) over all utterances of a table of statistics; NaN where undefined."""
    metric = metric_named(name)
    return float(metric.value(total(statistics_of(table, metric))))


def _pair(predicted, true) -> tuple[np.ndarray, np.ndarray]:
    predicted, true = np.asarray(predicted, dtype=np.float64), np.asarray(true, dtype=np.float64)
    if predicted.shape != true.shape:
        raise DataError(f"prediction {predicted.shape} and truth {true.shape} differ in shape.")
    return predicted, true


def _check_pair(utterance_id: str, name: str, predicted, true, frames: int) -> None:
    predicted, true = np.asarray(predicted), np.asarray(true)
    if predicted.shape != true.shape:
        raise DataError(f"{utterance_id}: predicted {name} {predicted.shape}, but true {name} {true.shape}.")
    if len(true) != frames or not frames:
        raise DataError(f"{utterance_id}: {name} has {len(true)} frames, appearance {frames}.")
    for which, values in (("predicted", predicted), ("true", true)):
        if not np.isfinite(values).all():
            frame = int(np.argwhere(~np.isfinite(values))[0][0])
            raise DataError(f"{utterance_id}: the {which} {name} of frame {frame} is not a finite number.")
