"""Rows and statistics of made-up models, as the tests of tables need them."""

import numpy as np
import pandas

from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.models.rows import ModelRow

#: Measures that are means over frames.
MEANS = ("rmse_shape", "rmse_texture", "rmse_appearance", "corr", "lip_distance_px")

BASELINES = {
    "training_mean": ModelRow("training_mean", "Training mean", "mean", role="baseline"),
    "phone_state_mean": ModelRow("phone_state_mean", "Phone-state mean", "phone_state_mean", role="baseline"),
    "floor": ModelRow("floor", "Reconstruction (floor)", "reconstruction", role="floor"),
}


def statistics(errors, corr=0.5, gv=0.5, frames=None, rate=25.0, undefined=0, ids=None):
    """Statistics of utterances whose errors (utterances,) are the same in every measure of an error."""
    errors = np.asarray(errors, float)
    frames = np.arange(len(errors)) + 20 if frames is None else np.asarray(frames)
    means = dict.fromkeys(MEANS, errors) | {"corr": np.broadcast_to(corr, errors.shape)}
    columns = {"id": ids or [f"u{i}" for i in range(len(errors))], "rate": rate, "frames": frames}
    columns |= {f"{name}_sum": values * frames for name, values in means.items()}
    columns |= {"utterances": 1, "rmse_first5_sum": errors, "corr_first5_sum": np.broadcast_to(corr, errors.shape)}
    columns |= {"gv_ratio_sum": 2.0 * np.broadcast_to(gv, errors.shape), "true_scatter": 2.0}
    # Two dimensions, of which the second is predicted a little less well.
    moments = {"predicted": 0.0, "true": 0.0, "predicted_squared": 1.0, "true_squared": 1.0, "predicted_true": corr}
    for name, value in moments.items():
        columns |= {f"{name}.{i}": np.asarray(value) * frames * (0.9**i) for i in range(2)}
    return pandas.DataFrame(columns).assign(corr_undefined=undefined)


def stack(name: str, letters: str, nodes: int, seed: int = 1, **changes) -> ModelRow:
    """The row of a network, named without its seed where that is 1."""
    settings = {"letters": letters, "nodes": nodes, "b_nodes": "direction"}
    given = {"group": "nets", "reads": ("tri",), "cell": f"{letters}-{nodes}"} | changes
    return ModelRow(name, name, "stack", settings, seed=seed, **given)


def hmm(name: str, title: str) -> ModelRow:
    """The row of an HMM."""
    return ModelRow(name, title, "hmm", cell=name, group=name)


def measured(*pairs) -> MeasuredRows:
    """Measured rows from (row, table) pairs; a text stands for one of :data:`BASELINES`."""
    rows = [(BASELINES[row] if isinstance(row, str) else row, table) for row, table in pairs]
    return MeasuredRows(tuple(row for row, _ in rows), {row.name: table for row, table in rows})
