"""Rows with their statistics: one check of what they were measured on, and repetitions as one row."""

import numpy as np
import pytest

from tests.unit.evaluation.examples import BASELINES, measured, stack, statistics
from visualspeech.errors import DataError
from visualspeech.evaluation.measured import MeasuredRows, check_same_utterances
from visualspeech.evaluation.metrics import corpus_figure

ERRORS = np.linspace(1, 2, 5)


def rows():
    return measured(
        (stack("FBB-128", "FBB", 128), statistics(ERRORS)),
        ("training_mean", statistics(3 * ERRORS)),
        (stack("FBB-128-s2", "FBB", 128, seed=2), statistics(2 * ERRORS, corr=0.7)),
    )


@pytest.mark.parametrize(
    "other",
    [
        statistics(ERRORS[:-1]),
        statistics(ERRORS, frames=[20, 21, 22, 23, 25]),
        statistics(ERRORS, ids=["u0", "u1", "u2", "u4", "u3"]),
        statistics(ERRORS, ids=["u0", "u1", "u2", "u3", "other"]),
    ],
)
def test_rows_on_different_utterances_or_frames_are_refused(other):
    with pytest.raises(DataError, match="`floor` and `training_mean` were evaluated on different utterances"):
        measured(("training_mean", statistics(ERRORS)), ("floor", other))


def test_frames_may_differ_where_rates_do():
    tables = {"a": statistics(ERRORS), "b": statistics(ERRORS, frames=np.arange(5) + 80)}
    check_same_utterances(tables, frames=False)
    with pytest.raises(DataError, match="or frames"):
        check_same_utterances(tables)


def test_plain_rows_and_tables_in_one_order():
    plain = [BASELINES["training_mean"].plain(), stack("FBB-128", "FBB", 128).plain()]
    made = MeasuredRows.of(plain, [statistics(ERRORS), statistics(2 * ERRORS)])
    assert list(made.tables) == ["training_mean", "FBB-128"] and made.base.title == "Training mean"
    assert (made.utterances, made.frames, made.rates, made.seeds) == (5, 110, (25.0,), (1,))
    assert made.where(lambda row: row.family == "stack").titles == {"FBB-128": "FBB-128"}
    with pytest.raises(DataError, match="no model"):
        MeasuredRows.of([], [])


def test_pooled_rows_are_means_over_seeds():
    pooled = rows().pooled()
    assert list(pooled.tables) == ["FBB-128", "training_mean"]
    single = [corpus_figure(rows().tables[name], "rmse_shape") for name in ("FBB-128", "FBB-128-s2")]
    assert corpus_figure(pooled.tables["FBB-128"], "rmse_shape") == pytest.approx(np.mean(single))
    assert corpus_figure(pooled.tables["FBB-128"], "corr") == pytest.approx(0.6)
    assert rows().mean_and_deviation(rows().cells()["FBB-128"], "rmse_shape") == pytest.approx(
        (np.mean(single), np.std(single, ddof=1))
    )
    assert pooled.tables["training_mean"].equals(rows().tables["training_mean"])
    assert list(pooled.pooled().tables) == list(pooled.tables)


def test_the_training_mean_is_asked_for():
    with pytest.raises(DataError, match="training_mean"):
        rows().where(lambda row: row.family == "stack").base  # noqa: B018
