"""Statistics by region of the face, for visual codings with regions (Sadoughi and Busso 2017, sections 3.4 and 5)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from visualspeech.evaluation.metrics import centred_concordance, region_concordance
from visualspeech.evaluation.scoring import centred, check_pair, scatter_over_time


def region_statistics(
    utterance_id: str,
    predicted: np.ndarray,
    true: np.ndarray,
    rate: float,
    regions: Mapping[str, Sequence[int]],
    drift_kept: bool = True,
) -> dict:
    """Statistics of one utterance for :func:`visualspeech.evaluation.metrics.of_region`: one row of a table.

    Columns: ``id``, ``rate`` (Hz), ``frames``, ``utterances`` (1); ``gv_ratio_sum`` and ``true_scatter`` of the whole
    vector; and for each region the scatter over time of both, the mean squared error times the number of frames, the
    sums of :func:`~visualspeech.evaluation.metrics.centred_concordance` for each of its D parameters (2 D columns), and
    the error and the concordance correlation of the utterance by itself. The same in the absolute protocol with
    ``_absolute`` in their names and the sums of :func:`~visualspeech.evaluation.metrics.region_concordance` (4 D
    columns), where the truth has its offset.

    Parameters
    ----------
    predicted, true : parameters of the visual coding (T, N)
    rate : frame rate in Hz
    regions : name -> columns of its parameters
    drift_kept : whether the coding has removed no drift, so that the truth has its offset

    Raises
    ------
    DataError
        Shapes differ, there are no frames, or a value is not finite.
    """
    check_pair(utterance_id, "appearance", predicted, true, len(true))
    x, y = np.asarray(predicted, np.float64), np.asarray(true, np.float64)
    row = {
        "id": utterance_id,
        "rate": float(rate),
        "frames": len(y),
        "utterances": 1,
        "gv_ratio_sum": scatter_over_time(x),
        "true_scatter": scatter_over_time(y),
    }
    pairs = [("", centred(x), centred(y)), *([("_absolute", x, y)] if drift_kept else [])]
    for region, columns in regions.items():
        own = np.asarray(columns, int)
        row[f"predicted_scatter_{region}"] = scatter_over_time(x[:, own])
        row[f"true_scatter_{region}"] = scatter_over_time(y[:, own])
        for ending, first, second in pairs:
            row |= _of_region(region, ending, first[:, own], second[:, own])
    return row


def _of_region(region: str, ending: str, x: np.ndarray, y: np.ndarray) -> dict[str, float]:
    """Statistics of a region in one protocol, of parameters (T, D)."""
    frames, error = len(y), float(np.mean((x - y) ** 2))
    vectors = {"squares": (x * x + y * y).sum(axis=0), "products": (x * y).sum(axis=0)}
    if ending:
        vectors = {"predicted": x.sum(axis=0), "true": y.sum(axis=0)} | vectors
        agreement = region_concordance(np.concatenate([[frames], *vectors.values()]))
    else:
        agreement = centred_concordance(np.concatenate([*vectors.values()]))
    return {
        f"mse_{region}{ending}_sum": error * frames,
        f"mse_{region}_turn{ending}_sum": error,
        f"ccc_{region}_turn{ending}_sum": float(np.nan_to_num(agreement)),
    } | {f"{name}_{region}{ending}.{i}": float(v) for name, values in vectors.items() for i, v in enumerate(values)}


def region_scores(
    ids: Iterable[str], predictions, targets, regions: Mapping[str, Sequence[int]], drift_kept: bool = True
) -> Iterator[dict]:
    """The statistics of utterances: :func:`region_statistics` of each.

    Parameters
    ----------
    ids : of the utterances
    predictions, targets : opened files with the array ``appearance``, of one frame rate
    regions, drift_kept : as for :func:`region_statistics`
    """
    for one in ids:
        true = targets.array(one, "appearance")
        yield region_statistics(one, predictions.array(one, "appearance"), true, targets.rate(one), regions, drift_kept)
