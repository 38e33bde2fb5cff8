import numpy as np
import pytest

from tests.unit.models.examples import RATE, task, utterances
from visualspeech.errors import DataError
from visualspeech.models import mean
from visualspeech.models.registry import load_model


def test_the_mean_of_all_frames_in_every_frame():
    training = utterances(6)
    fitted = mean.fit(task("mean", training=training, blocks=None))
    expected = np.concatenate([one.target for one in training]).mean(axis=0)
    found = fitted.model.predict(training[0].streams, 7, RATE)
    assert found.shape == (7, 4) and found.dtype == np.float32
    assert np.allclose(found, expected, atol=1e-5)
    assert fitted.curve["value"].tolist() == [sum(len(one.target) for one in training)]


def test_it_needs_no_input_block(tmp_path):
    training = [one._replace(streams=()) for one in utterances(3)]
    model = mean.fit(task("mean", training=training, blocks={}, coding="abc")).model
    model.save(tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert np.array_equal(again.predict((), 5, RATE), model.predict((), 5, RATE))
    assert (again.rate, again.coding, again.blocks, again.outputs) == (RATE, "abc", {}, 4)


def test_nothing_to_learn_from():
    with pytest.raises(DataError, match="no training utterance"):
        mean.fit(task("mean"))
    with pytest.raises(DataError, match="not finite numbers"):
        mean.fit(task("mean", training=[utterances(1)[0]._replace(target=np.full((3, 2), np.nan))]))
