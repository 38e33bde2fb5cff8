from collections import defaultdict

import numpy as np
import pytest

from tests.unit.models.examples import BLOCKS, PHONES, RATE, Values, task, utterances
from visualspeech.errors import DataError, SettingError
from visualspeech.features.blocks.triphone_state import TriphoneState
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models import lookup
from visualspeech.models.lookup_settings import LookupSettings
from visualspeech.models.registry import load_model


def fit(training, context="triphone", min_count=3, blocks=None):
    return lookup.fit(task("lookup", {"context": context, "min_count": min_count}, training, blocks=blocks)).model


def predict(model, labels):
    return model.predict([Stream(index=np.asarray(labels, np.int16))])


def slow_prediction(label, training, min_count):
    """The back-off as its documentation tells it, by going through all training frames."""
    groups = defaultdict(list)
    for streams, values, _ in training:
        for (a, b, c, s), value in zip(streams[0].index.tolist(), values.astype(float), strict=True):
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
    labels = np.concatenate([utterances(1, seed=seed)[0].streams[0].index for seed in (7, 8)])
    expected = np.array([slow_prediction(label, training, min_count) for label in labels.tolist()])
    assert np.allclose(predict(fit(training, min_count=min_count), labels), expected, rtol=1e-5, atol=1e-5)


def test_phone_state_mean():
    training = utterances(6)
    labels = np.concatenate([one.streams[0].index for one in training])
    values = np.concatenate([one.target for one in training])
    phone = fit(training, "phone", 1)
    same = (labels[:, 1] == 2) & (labels[:, 3] == 1)
    assert np.allclose(predict(phone, labels)[same], values[same].mean(axis=0), atol=1e-4)
    assert set(phone.means) == {"phone"}


def test_a_phone_that_training_never_saw_gets_the_mean():
    training = utterances(1)
    model = fit(training, blocks={"tri": TriphoneState((*PHONES, "f"))})
    assert np.allclose(predict(model, [[6, 6, 6, 0]]), training[0].target.mean(axis=0), atol=1e-5)


@pytest.mark.parametrize("context", ["phone", "triphone"])
def test_the_file_gives_the_same_predictions(tmp_path, context):
    model = fit(utterances(4), context)
    model.save(tmp_path / "model.safetensors")
    streams = utterances(1, seed=3)[0].streams
    again = load_model(tmp_path / "model.safetensors")
    assert np.array_equal(again.predict(streams), model.predict(streams))
    assert (again.settings, again.blocks, again.rate, again.outputs) == (model.settings, BLOCKS, RATE, 4)
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == (tmp_path / "model.safetensors").read_bytes()


def test_how_many_means_there_are_is_reported():
    curve = lookup.fit(task("lookup", {"context": "phone"}, utterances(4))).curve
    seen = {(b, s) for one in utterances(4) for _, b, _, s in one.streams[0].index.tolist()}
    assert curve.to_dict("list") == {"figure": ["phone"], "value": [len(seen)]}


def test_wrong_settings_and_nothing_to_learn_from():
    with pytest.raises(SettingError, match="models.context: mode"):
        LookupSettings("mode")
    with pytest.raises(SettingError, match="models.min_count"):
        LookupSettings(min_count=0)
    with pytest.raises(DataError, match="no training utterance"):
        fit([])
    two = {**BLOCKS, "more": Values(2)}
    with pytest.raises(DataError, match="`models.model.reads` must name one block of kind triphone_state"):
        fit(utterances(2), blocks=two)
    with pytest.raises(DataError, match="of kind triphone_state"):
        fit([Example((Stream(values=np.zeros((3, 2), np.float32)),), np.zeros((3, 4)), RATE)], blocks={"v": Values(2)})
    with pytest.raises(DataError, match="`tri`: a class is outside its inventory"):
        predict(fit(utterances(2)), [[6, 0, 0, 0]])
