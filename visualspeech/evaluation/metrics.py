"""Objective measures of a predicted face sequence: Eq. 16-19 of Fan et al. (2015), and two that they lack.

Every measure of a corpus is a quotient of two sums over its utterances. An utterance's row therefore holds a value and
the weight that value has in the corpus: the frames for Eq. 16-19 and the lip distance, the true scatter for the share
of the variance. The corpus figure ``sum(value * weight) / sum(weight)`` is then exactly the equation's.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError, SettingError


@dataclass(frozen=True)
class Metric:
    """What a table needs to know of one measure.

    Parameters
    ----------
    name : column of the per-utterance table, and the name used in settings
    title : heading for people
    definition : one sentence, with the equation's number where the paper has one
    best : ``low``, ``high`` or ``one`` (the nearer to 1 the better)
    weight : column with the weight of an utterance's value in the corpus figure
    unit : unit of the figure, empty for none
    """

    name: str
    title: str
    definition: str
    best: str
    weight: str = "frames"
    unit: str = ""


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric(
            "rmse_shape",
            "RMSE(shape)",
            "Eq. 16: mean over frames of the root mean square error of the shape parameters a",
            "low",
        ),
        Metric(
            "rmse_texture",
            "RMSE(texture)",
            "Eq. 17: mean over frames of the root mean square error of the texture parameters b",
            "low",
        ),
        Metric(
            "rmse_appearance",
            "RMSE(appearance)",
            "Eq. 18: mean over frames of the root mean square error of the appearance parameters v",
            "low",
        ),
        Metric(
            "corr",
            "CORR",
            "Eq. 19: mean over frames of the correlation, over the dimensions of v, of prediction and truth "
            "(a frame with an undefined correlation counts as 0)",
            "high",
        ),
        Metric(
            "lip_distance_px",
            "Lip distance",
            "mean over frames and the 20 lip points of the Euclidean distance between the point decoded from v and the "
            "tracked point, in pixels of the normalised face",
            "low",
            unit="px",
        ),
        Metric(
            "variance_kept",
            "Variance kept",
            "variance of v over time within utterances, summed over its dimensions: predicted divided by true "
            "(below 1: over-smoothed)",
            "one",
            weight="true_scatter",
        ),
    )
}


def metric_named(name: str) -> Metric:
    """The measure of that name.

    Raises
    ------
    SettingError
        There is none; the message names the known ones.
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
    # Rounding leaves a constant vector with a residue of some 1e-16 of its size.
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


def score(utterance_id: str, predicted: FaceSequence, true: FaceSequence) -> dict:
    """One row of the per-utterance table.

    Columns: ``id``, ``frames``, the measures of :data:`METRICS` (means over the utterance's frames;
    ``variance_kept`` the quotient of the scatters, NaN where the true one is 0), ``corr_undefined`` (number of frames
    whose correlation is undefined; each of them adds 0 to the sum of Eq. 19 and 1 to its count of frames, so that
    every row of a table is divided by the same number of frames), and ``true_scatter``.

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
    return {
        "id": utterance_id,
        "frames": len(true.appearance),
        "rmse_shape": float(frame_rmse(predicted.shape, true.shape).mean()),
        "rmse_texture": float(frame_rmse(predicted.texture, true.texture).mean()),
        "rmse_appearance": float(frame_rmse(predicted.appearance, true.appearance).mean()),
        "corr": float(np.where(undefined, 0.0, correlation).mean()),
        "lip_distance_px": float(frame_point_distance(predicted.lips, true.lips).mean()),
        "variance_kept": scatter_over_time(predicted.appearance) / scatter if scatter > 0 else float("nan"),
        "corr_undefined": int(undefined.sum()),
        "true_scatter": scatter,
    }


def score_table(rows: Iterable[dict]):
    """The per-utterance table (:class:`pandas.DataFrame`) of rows from :func:`score`, sorted by id."""
    import pandas

    columns = ["id", "frames", *METRICS, "corr_undefined", "true_scatter"]
    return pandas.DataFrame(list(rows), columns=columns).sort_values("id", ignore_index=True)


def sums(table, metric: Metric) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator of a measure, each (utterances,): the corpus figure is the quotient of their sums.

    Raises
    ------
    DataError
        The table lacks a column of the measure.
    """
    for column in (metric.name, metric.weight):
        if column not in table:
            raise DataError(f"a per-utterance table lacks the column `{column}`; delete it and run again.")
    weight = table[metric.weight].to_numpy(dtype=np.float64)
    value = table[metric.name].to_numpy(dtype=np.float64)
    # An utterance of weight 0 has no value (0/0) and takes no part.
    return np.where(weight > 0, np.nan_to_num(value) * weight, 0.0), weight


def corpus_figure(table, name: str) -> float:
    """Eq. 16-19 (or another of :data:`METRICS`) over all utterances of a per-utterance table; NaN where 0/0."""
    numerator, denominator = sums(table, metric_named(name))
    total = denominator.sum()
    return float(numerator.sum() / total) if total > 0 else float("nan")


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
