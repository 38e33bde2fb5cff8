"""The face at rest beside predictions: by hand, and where it helps by construction."""

import numpy as np
import pytest

from tests.unit.evaluation.examples import measured, stack
from visualspeech.evaluation.forms import all_forms
from visualspeech.evaluation.resting import COLUMNS, resting_frame, resting_rows, resting_tables, training_rest
from visualspeech.evaluation.scoring import score_table
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.models.rest import pause_weights
from visualspeech.speech.spoken import timed
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

BOOTSTRAP = BootstrapSettings(200, 0.95, 1)
SPOKEN = timed([("sil", 0.0, 1.0), ("aa", 1.0, 1.4), ("sil", 1.4, 2.4)])
FRAMES, RATE = 60, 25.0
REST = np.array([2.0, -1.0, 0.5])


@pytest.fixture
def files(tmp_path):
    """Recorded and predicted parameters of three utterances: the prediction trembles in pauses."""
    generator = np.random.default_rng(3)
    weight = pause_weights(SPOKEN, FRAMES, RATE, 0.12)[:, None]
    with ArrayWriter(tmp_path / "true.h5") as true, ArrayWriter(tmp_path / "predicted.h5") as predicted:
        for name in "abc":
            speech = generator.normal(size=(FRAMES, 3))
            recorded = weight * REST + (1 - weight) * speech
            true.add(name, {"appearance": recorded.astype(np.float32)}, RATE)
            noise = weight * generator.normal(size=(FRAMES, 3))
            predicted.add(name, {"appearance": (recorded + noise).astype(np.float32)}, RATE)
    with ArrayReader(tmp_path / "true.h5") as true, ArrayReader(tmp_path / "predicted.h5") as predicted:
        yield predicted, true


def test_statistics_by_a_slow_version(files):
    predicted, true = files
    rest = np.array([1.0, 0.0, 3.0])
    for row in resting_rows([(name, SPOKEN) for name in "ab"], predicted, true, rest):
        weight = pause_weights(SPOKEN, FRAMES, RATE, 0.12)
        y, x = (one.array(row["id"], "appearance").astype(float) for one in (true, predicted))
        blended = np.array([(1 - w) * frame + w * rest for w, frame in zip(weight, x, strict=True)])
        for form, values in (("predicted", x), ("rest", blended)):
            error = (values - values.mean(axis=0)) - (y - y.mean(axis=0))
            each = [np.sqrt(sum(frame**2) / 3) for frame in error]
            assert row[f"all_{form}_sum"] == pytest.approx(sum(each))
            inside = sum(e for e, w in zip(each, weight, strict=True) if w > 0)
            assert row[f"pauses_{form}_sum"] == pytest.approx(inside)
        assert (row["frames"], row["pause_frames"]) == (60, (weight > 0).sum()) and 0 < row["pause_frames"] < 60


def test_the_face_at_rest_takes_the_tremble_away(files):
    predicted, true = files
    rest = training_rest(lambda: [("a", SPOKEN), ("b", SPOKEN)], true)
    np.testing.assert_allclose(rest, REST, atol=1e-6)
    table = score_table(resting_rows([(name, SPOKEN) for name in "abc"], predicted, true, rest))
    found = measured((stack("FBB-8", "FBB", 8), table))
    frame = resting_frame(found, BOOTSTRAP)
    assert tuple(frame.columns) == COLUMNS
    lines = frame.set_index("part")
    assert lines.loc["pauses", "rest"] < 0.1 < 0.5 < lines.loc["pauses", "predicted"]
    assert lines.loc["pauses", "difference_high"] < 0 and lines.loc["all", "difference"] < 0
    assert lines.loc["all", "difference"] == pytest.approx(lines.loc["all", "rest"] - lines.loc["all", "predicted"])
    tables = resting_tables(frame, found, (("corpus", "demo"),), BOOTSTRAP)
    assert tables[0].groups == (("all frames", 3), ("frames in pauses", 3)) and len(tables[0].rows[0].cells) == 6
    assert all("FBB-8" in text for text in all_forms(frame, tables, "Face at rest"))
