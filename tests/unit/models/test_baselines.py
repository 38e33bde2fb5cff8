from collections import defaultdict

import numpy as np
import pytest

from tests.unit.models.examples import PHONES, utterances
from visualspeech.errors import DataError, SettingError
from visualspeech.models.baselines import Baseline, BaselineSettings, fit


def slow_prediction(label, training, min_count):
    """The back-off as its documentation tells it, by going through all training frames."""
    groups = defaultdict(list)
    for labels, values in training:
        for (a, b, c, s), value in zip(labels.tolist(), values.astype(float), strict=True):
            for key in (("all", a, b, c, s), ("left", a, b, s), ("right", b, c, s), ("phone", b, s), ("mean",)):
                groups[key].append(value)
    a, b, c, s = label
    left, right = ("left", a, b, s), ("right", b, c, s)
    left_first = s == 0 or (s == 1 and len(groups[left]) >= len(groups[right]))
    pair = [left, right] if left_first else [right, left]
    for key in [("all", a, b, c, s), *pair, ("phone", b, s)]:
        if len(groups[key]) >= min_count:
            return np.mean(groups[key], axis=0)
    return np.mean(groups[("mean",)], axis=0)


@pytest.mark.parametrize("min_count", [1, 3, 8])
def test_triphone_state_mean_against_the_documented_rule(min_count):
    training = utterances(12)
    baseline = fit("triphone_state_mean", training, len(PHONES), BaselineSettings(min_count))
    labels = np.concatenate([utterances(1, seed=7)[0][0], utterances(1, seed=8)[0][0]])
    expected = np.array([slow_prediction(label, training, min_count) for label in labels.tolist()])
    assert np.allclose(baseline.predict(labels), expected, rtol=1e-5, atol=1e-5)


def test_phone_state_mean_and_training_mean():
    training = utterances(6)
    labels = np.concatenate([labels for labels, _ in training])
    values = np.concatenate([values for _, values in training])
    mean = fit("training_mean", training, len(PHONES))
    assert np.allclose(mean.predict(labels), values.mean(axis=0), atol=1e-5)
    phone = fit("phone_state_mean", training, len(PHONES), BaselineSettings(1))
    same = (labels[:, 1] == 2) & (labels[:, 3] == 1)
    assert np.allclose(phone.predict(labels)[same], values[same].mean(axis=0), atol=1e-4)


def test_a_phone_that_training_never_saw_gets_the_mean():
    labels, values = utterances(1)[0]
    baseline = fit("triphone_state_mean", [(labels, values)], len(PHONES) + 1)
    unseen = np.array([[6, 6, 6, 0]])
    assert np.allclose(baseline.predict(unseen), values.mean(axis=0), atol=1e-5)


@pytest.mark.parametrize("kind", ["training_mean", "phone_state_mean", "triphone_state_mean"])
def test_the_file_gives_the_same_predictions(tmp_path, kind):
    baseline = fit(kind, utterances(4), len(PHONES))
    baseline.save(tmp_path / "baseline.safetensors")
    labels = utterances(1, seed=3)[0][0]
    assert np.array_equal(Baseline.load(tmp_path / "baseline.safetensors").predict(labels), baseline.predict(labels))


def test_wrong_settings_and_nothing_to_learn_from():
    with pytest.raises(SettingError, match="mode"):
        fit("mode", utterances(1), len(PHONES))
    with pytest.raises(SettingError, match="min_count"):
        BaselineSettings(0)
    with pytest.raises(DataError, match="no training utterance"):
        fit("training_mean", [], len(PHONES))
