"""The number of dynamic visemes: measures by hand, reconstruction of planted faces, and the table."""

import numpy as np
import pytest

from tests.unit.features.visemes.speakers import corpus
from visualspeech.errors import DataError
from visualspeech.evaluation.viseme_numbers import COLUMNS, first_coefficients, numbers_table, reconstruction_frame
from visualspeech.features.blocks.dynamic_visemes import DynamicVisemes, DynamicVisemesSettings
from visualspeech.fields import with_defaults

SETTINGS = with_defaults(DynamicVisemesSettings, {})
TRAINING, HELD_OUT = corpus(12, seed=1), corpus(4, seed=2)


def frame(classes, held_out=HELD_OUT):
    return reconstruction_frame({**SETTINGS, "classes": classes}, TRAINING, held_out)


def test_measures_are_of_the_first_five_parameters():
    random = np.random.default_rng(1)
    true, other = random.normal(size=(50, 7)), random.normal(size=(50, 7))
    rmse = np.mean([np.sqrt(np.mean((true[:, n] - other[:, n]) ** 2)) for n in range(5)])
    corr = np.mean([np.corrcoef(true[:, n], other[:, n])[0, 1] for n in range(5)])
    assert first_coefficients(true, other) == pytest.approx((rmse, corr))
    true[:, 2] = 4.0  # a parameter that does not vary has no correlation
    kept = np.mean([np.corrcoef(true[:, n], other[:, n])[0, 1] for n in (0, 1, 3, 4)])
    assert first_coefficients(true, other)[1] == pytest.approx(kept)
    assert np.isnan(first_coefficients(np.ones((5, 2)), np.ones((5, 2)))[1])


def test_more_classes_reconstruct_better():
    few, many = frame(4), frame(60)
    assert list(few.columns) == list(COLUMNS) and few["id"].tolist() == [one.id for one in HELD_OUT]
    for form in ("hmm", "mean"):
        assert many[f"rmse_{form}"].mean() < 0.8 * few[f"rmse_{form}"].mean()
        assert many[f"corr_{form}"].mean() > few[f"corr_{form}"].mean() > 0.3
    block = DynamicVisemes.fit({**SETTINGS, "classes": 4, "source": "oracle"}, (), TRAINING)
    gestures, classes = block.visemes(HELD_OUT[0])
    made = block.classes.reconstruct(classes, gestures)
    assert few["rmse_mean"][0] == pytest.approx(first_coefficients(HELD_OUT[0].parameters, made)[0])
    assert few["gestures"][0] == len(classes)


def test_held_out_utterances_teach_nothing():
    assert frame(4, HELD_OUT[:1]).equals(frame(4).iloc[:1])


def test_more_classes_than_gestures():
    with pytest.raises(DataError, match="`classes: 9000` asks for more classes of dynamic visemes"):
        frame(9000)


def test_the_table():
    import pandas

    table = numbers_table(pandas.concat([frame(8), frame(4)]), {"corpus": "x"})
    assert [row.title for row in table.rows] == ["4", "8"] and table.corner == "classes"
    assert ("validation utterances", "4") in table.facts and ("corpus", "x") in table.facts
    assert sum(span for _, span in table.groups) == len(table.columns) == len(table.rows[0].cells)
    mean, deviation = frame(4)["rmse_hmm"].mean(), frame(4)["rmse_hmm"].std()
    assert (table.rows[0].cells[0].text, table.rows[0].cells[0].small) == (f"{mean:.3f}", f"±{deviation:.3f}")
