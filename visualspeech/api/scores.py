"""Objective measures of predicted parameters, as the result tables have them."""

from collections.abc import Mapping

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.articulation import ARTICULATION
from visualspeech.evaluation.metrics import METRICS, Metric, is_measured, statistics_of, total
from visualspeech.evaluation.scoring import FaceSequence, check_pair, score_table
from visualspeech.evaluation.scoring import score as score_utterance

#: Measures that need nothing but parameters; all of the centred protocol.
MEASURES = ("rmse_appearance", "corr", "gv_ratio", "ccc", "rmse_first5", "corr_first5")


def score(predicted: Mapping[str, np.ndarray], true: Mapping[str, np.ndarray], *, by_utterance: bool = False):
    """Measures of predictions in the centred protocol: prediction and truth each less its mean over the utterance.

    Figures of several utterances are those of a result table: sums over all frames, not means over utterances
    (``docs/scoring.md``).

    Parameters
    ----------
    predicted, true : parameters (T, N) by utterance; truth of further utterances is ignored. Two arrays (T, N) are
        those of one utterance
    by_utterance : whether each utterance is measured by itself

    Returns
    -------
    measure -> figure, for each of :data:`MEASURES`: ``rmse_appearance`` (Eq. 18 of Fan 2015, in the unit of the
    parameters), ``corr`` (Eq. 19), ``gv_ratio`` (global-variance ratio), ``ccc`` (concordance correlation), and two of
    the first five parameters; with ``by_utterance`` a data frame of them, indexed by utterance

    Raises
    ------
    DataError
        There is no utterance, its truth is missing, or the two differ in shape or hold a value that is not finite.
    """
    if not isinstance(predicted, Mapping):
        predicted, true = {"utterance": predicted}, {"utterance": true}
    if not predicted:
        raise DataError("there is no prediction to score.")
    missing = sorted(set(predicted) - set(true))
    if missing:
        raise DataError(f"there is no truth of the utterance {missing[0]} ({len(missing)} in all).")
    table = score_table(_row(name, np.asarray(values), np.asarray(true[name])) for name, values in predicted.items())
    if not by_utterance:
        return {name: _figure(table, METRICS[name]) for name in MEASURES}
    import pandas

    figures = {name: METRICS[name].value(statistics_of(table, METRICS[name])) for name in MEASURES}
    return pandas.DataFrame(figures, index=pandas.Index(table["id"], name="utterance"))


def _row(name: str, predicted: np.ndarray, true: np.ndarray) -> dict:
    for values in (predicted, true):
        if values.ndim != 2 or values.dtype.kind not in "fiu":
            raise DataError(f"{name}: parameters are numbers of shape (T, N), not {values.dtype} {values.shape}.")
    check_pair(name, "appearance", predicted, true, len(true))
    # Measures of shape, texture and lips need the visual coding and are left out; anything stands for these.
    given, recorded = (
        FaceSequence(values, values, values, np.zeros((len(true), 1, 2))) for values in (predicted, true)
    )
    return score_utterance(name, given, recorded, rate=1.0)


def _figure(table, metric: Metric) -> float:
    return float(metric.value(total(statistics_of(table, metric))))


def measured(table) -> dict[str, float]:
    """Figure of every measure whose statistics a table of a run holds (``statistics.tsv``)."""
    return {name: _figure(table, one) for name, one in (METRICS | ARTICULATION).items() if is_measured(table, one)}
