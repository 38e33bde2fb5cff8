"""Statistics of predicted and recorded faces, from which :mod:`visualspeech.evaluation.metrics` takes its measures."""

from collections.abc import Iterable
from dataclasses import dataclass, fields

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.metrics import METRICS

#: Number of dimensions over which the measures of Thangthai et al. (2016) are averaged.
FIRST = 5


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

    def centred(self) -> "FaceSequence":
        """The sequence less its own mean over time."""
        return FaceSequence(*(centred(getattr(self, one.name)) for one in fields(self)))


def centred(values: np.ndarray) -> np.ndarray:
    """Values (T, ...) less their mean over time, in double precision; exactly 0 where they are constant."""
    moved = np.asarray(values, np.float64)
    # Less the first frame first: the mean of equal numbers is rounded, and a remainder would correlate with anything.
    moved = moved - moved[:1]
    return moved - moved.mean(axis=0, keepdims=True)


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


def correlation_over_time(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Pearson correlation over the frames of each dimension: (T, N), (T, N) -> (N,); NaN where one is constant."""
    predicted, true = _pair(predicted, true)
    return frame_correlation(predicted.T, true.T)


def rmse_over_time(predicted: np.ndarray, true: np.ndarray) -> np.ndarray:
    """Root mean square error over the frames of each dimension: (T, N), (T, N) -> (N,)."""
    predicted, true = _pair(predicted, true)
    return np.sqrt(np.mean((predicted - true) ** 2, axis=0))


def scatter_over_time(values: np.ndarray) -> float:
    """Sum over frames and dimensions of the squared deviation from the utterance's mean: (T, N) -> number."""
    values = np.asarray(values, dtype=np.float64)
    return float(np.sum((values - values.mean(axis=0)) ** 2))


def score(
    utterance_id: str,
    predicted: FaceSequence,
    true: FaceSequence,
    rate: float,
    lip_offset: np.ndarray | float = 0.0,
    drift_kept: bool = False,
) -> dict:
    """Statistics of one utterance: one row of the table of :func:`score_table`.

    Columns: ``id``, ``rate`` (Hz), ``frames``; for each quotient of :data:`METRICS` its value in the utterance times
    its weight (``rmse_shape_sum``, ...; the weight is the number of frames, of ``gv_ratio_sum`` the true scatter);
    ``corr_undefined``, the number of frames whose correlation is undefined (each adds 0 to the sum of Eq. 19 and 1 to
    its count of frames, so that every row of a table is divided by the same number); ``true_scatter``; and for each
    dimension of the appearance parameters the sums of :func:`visualspeech.evaluation.metrics.concordance`;
    ``utterances``, which is 1, and the measures of the first dimensions over time. In the absolute protocol,
    ``lip_distance_px_absolute_sum``, and the errors of parameters where drift was kept.

    Parameters
    ----------
    predicted, true : as predicted, and as recorded without drift
    lip_offset : (20, 2) offset of the recorded lip points, which drift removal has taken from ``true``
    drift_kept : whether nothing was removed, so that the recorded parameters have their offset

    Raises
    ------
    DataError
        Lengths or dimensions differ, there are no frames, or a value is not finite.
    """
    for name in ("appearance", "shape", "texture", "lips"):
        check_pair(utterance_id, name, getattr(predicted, name), getattr(true, name), len(true.appearance))
    frames, (x, y) = len(true.appearance), (predicted.centred(), true.centred())
    correlation = frame_correlation(x.appearance, y.appearance)
    lips = np.asarray(true.lips, np.float64) + lip_offset
    means = _means(x, y)
    moments = _moments(x.appearance, y.appearance)
    if drift_kept:
        means |= {f"{name}_absolute": mean for name, mean in _means(predicted, true).items()}
        moments |= _moments(predicted.appearance, true.appearance, "_absolute")
        moments["rmse_first5_absolute_sum"] = float(rmse_over_time(*_first(predicted, true)).mean())
    means["lip_distance_px_absolute"] = float(frame_point_distance(predicted.lips, lips).mean())
    scatter = scatter_over_time(true.appearance)
    kept = scatter_over_time(predicted.appearance) / scatter if scatter > 0 else 0.0
    return {
        "id": utterance_id,
        "rate": float(rate),
        "frames": frames,
        **{f"{name}_sum": mean * frames for name, mean in means.items()},
        "corr_undefined": int(np.isnan(correlation).sum()),
        "gv_ratio_sum": kept * scatter,
        "true_scatter": scatter,
        "utterances": 1,
        "corr_first5_sum": float(np.nan_to_num(correlation_over_time(*_first(x, y))).mean()),
        "rmse_first5_sum": float(rmse_over_time(*_first(x, y)).mean()),
        **moments,
    }


def _means(predicted: FaceSequence, true: FaceSequence) -> dict[str, float]:
    """Means over frames of Eq. 16-19 and of the lip distance."""
    correlation = frame_correlation(predicted.appearance, true.appearance)
    return {
        "rmse_shape": float(frame_rmse(predicted.shape, true.shape).mean()),
        "rmse_texture": float(frame_rmse(predicted.texture, true.texture).mean()),
        "rmse_appearance": float(frame_rmse(predicted.appearance, true.appearance).mean()),
        "corr": float(np.where(np.isnan(correlation), 0.0, correlation).mean()),
        "lip_distance_px": float(frame_point_distance(predicted.lips, true.lips).mean()),
    }


def _first(predicted: FaceSequence, true: FaceSequence) -> tuple[np.ndarray, np.ndarray]:
    """The first dimensions of the appearance parameters."""
    return predicted.appearance[:, :FIRST], true.appearance[:, :FIRST]


def _moments(predicted, true, ending: str = "") -> dict[str, float]:
    x, y = _pair(predicted, true)
    names = METRICS["ccc"].columns[1:]
    sums = zip(names, (x, y, x * x, y * y, x * y), strict=True)
    return {f"{name}{ending}.{i}": float(total) for name, values in sums for i, total in enumerate(values.sum(axis=0))}


def score_table(rows: Iterable[dict]):
    """The table of statistics (:class:`pandas.DataFrame`) of rows from :func:`score`, sorted by id."""
    import pandas

    rows = list(rows)
    table = pandas.DataFrame(rows, columns=None if rows else ["id", "rate", "frames"])
    return table.sort_values("id", ignore_index=True)


def _pair(predicted, true) -> tuple[np.ndarray, np.ndarray]:
    predicted, true = np.asarray(predicted, dtype=np.float64), np.asarray(true, dtype=np.float64)
    if predicted.shape != true.shape:
        raise DataError(f"prediction {predicted.shape} and truth {true.shape} differ in shape.")
    return predicted, true


def check_pair(utterance_id: str, name: str, predicted, true, frames: int) -> None:
    """Check that prediction and truth have one shape, ``frames`` frames, one at least, and finite values.

    Raises
    ------
    DataError
        They have not; the message names the utterance and, as ``name``, what is compared.
    """
    predicted, true = np.asarray(predicted), np.asarray(true)
    if predicted.shape != true.shape:
        raise DataError(f"{utterance_id}: predicted {name} {predicted.shape}, but true {name} {true.shape}.")
    if len(true) != frames or not frames:
        raise DataError(f"{utterance_id}: {name} has {len(true)} frames, appearance {frames}.")
    for which, values in (("predicted", predicted), ("true", true)):
        if not np.isfinite(values).all():
            frame = int(np.argwhere(~np.isfinite(values))[0][0])
            raise DataError(f"{utterance_id}: the {which} {name} of frame {frame} is not a finite number.")
