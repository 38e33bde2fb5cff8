"""Training and prediction on arrays: what is learned, what is kept, and mistakes."""

import numpy as np
import pytest

from tests.unit.speech.alignments import spoken
from visualspeech import DataError, SettingError, load_model, predict, score, train
from visualspeech.api.learning import Arrays
from visualspeech.errors import StorageError
from visualspeech.features.blocks.base import load_block, save_block
from visualspeech.models.entries import family_settings
from visualspeech.models.families import FAMILIES
from visualspeech.models.training_settings import training_fields
from visualspeech.schema import settings_class


def pairs(count, seed=0, frames=50):
    rng = np.random.default_rng(seed)
    given = [rng.normal(size=(frames + number, 4)) for number in range(count)]
    return [(inputs, inputs @ np.array([[1.0, 0], [0, 2], [0, 0], [1, 1]])) for inputs in given]


def classes(count, seed=0):
    rng = np.random.default_rng(seed)
    given = [rng.integers(0, 3, size=(60, 2)) for _ in range(count)]
    return [(inputs, np.eye(3)[inputs[:, 0]] * (1 + inputs[:, 1:])) for inputs in given]


@pytest.mark.parametrize(
    ("family", "settings"),
    [("stack", {"letters": "F", "nodes": 16}), ("dnn", {"layers": 1, "nodes": 16, "reads": [{"inputs": 0.04}]})],
)
@pytest.mark.parametrize("make", [pairs, classes])
def test_a_network_learns_arrays_and_is_kept(tmp_path, family, settings, make):
    own = {"max_epochs": 150, "learning_rate": 0.01, "dropout": 0.0, "ema_decay": 0.0, **settings}
    fitted = train(make(6), make(2, seed=1), family, **own)
    (inputs, true), *_ = make(1, seed=2)
    predicted = predict(fitted.model, inputs)
    assert predicted.dtype == np.float32 and score(predicted, true)["corr"] > 0.9
    fitted.model.save(tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    assert again.rate == 25.0 and np.array_equal(predict(again, inputs), predicted)
    assert list(fitted.curve.columns)[:2] == ["epoch", "train"]


def test_the_same_seed_gives_the_same_model():
    one, same, other = (
        predict(train(pairs(3), pairs(1, seed=1), letters="FB", nodes=4, max_epochs=2, seed=seed).model, pairs(1)[0][0])
        for seed in (3, 3, 4)
    )
    assert np.array_equal(one, same) and not np.array_equal(one, other)


def test_the_mean_reads_nothing():
    given = pairs(3)
    model = train(given, given[:1], "mean").model
    frames = np.concatenate([targets for _, targets in given])
    assert model.mean == pytest.approx(frames.mean(axis=0), abs=1e-5)
    assert predict(model, given[0][0]).shape == (50, 2)


def test_no_setting_of_a_family_is_one_of_training():
    """So that a keyword of train() has one meaning."""
    for name, family in FAMILIES.items():
        if family.settings and family.trained:
            entry = {"letters": "F"} if name == "stack" else {}
            own = family_settings(family, entry, "models", {}) if name != "joint" else {}
            assert not set(own) & set(training_fields()), name
            assert settings_class(family.settings)


GIVEN = pairs(2)
INPUTS, TARGETS = GIVEN[0]


@pytest.mark.parametrize(
    ("training", "settings", "said"),
    [
        ([], {}, "no training utterance"),
        ([INPUTS], {}, "training utterance 0: give a pair of arrays"),
        ([(INPUTS, TARGETS[:-1])], {}, "50 frames of inputs and 49 frames of targets"),
        ([(INPUTS, TARGETS[:, 0])], {}, r"targets are finite numbers of shape \(T, N\), not float64 \(50,\)"),
        ([(INPUTS * np.nan, TARGETS)], {}, "an input is no finite number"),
        ([(INPUTS, TARGETS * np.inf)], {}, "targets are finite numbers"),
        ([(np.full((50, 1), -1), TARGETS)], {}, "whole numbers are classes, from 0 on"),
        ([(np.array([["a"]]), TARGETS[:1])], {}, "inputs are numbers of shape"),
        ([GIVEN[0], (INPUTS[:, :2], TARGETS)], {}, "2 columns of real-valued inputs and 2 of targets, utterance 0 4"),
        ([(INPUTS[:, :2], TARGETS)], {}, "validation has 4 columns"),
        (GIVEN, {"rate": 0}, "rate=0: give the frame rate"),
        (GIVEN, {"letters": "FXB"}, "models.model.letters: FXB"),
        (GIVEN, {"letters": ["F", "B"], "nodes": 4}, "asks for several models"),
        (GIVEN, {"lettres": "F"}, "lettres"),
        (GIVEN, {"letters": "F", "max_epochs": 0}, "max_epochs: 0` must be at least 1"),
        (GIVEN, {"letters": "F", "nodes": 4, "closure_weight": 1.0}, "need the alignment and the lips of a run"),
        (GIVEN, {"letters": "F", "like": "x"}, "`like` is no setting of a model that is trained by itself"),
        (GIVEN, {"family": "forest"}, "forest"),
        (GIVEN, {"family": "ensemble"}, "made of others"),
        (GIVEN, {"family": "reconstruction"}, "made of others"),
        (GIVEN, {"family": "hmm"}, "reads segments"),
        (GIVEN, {"family": "hmm", "variant": "tied"}, "is made from another; train it in a run"),
        (GIVEN, {"family": "mean", "max_epochs": 3}, "`max_epochs` is for networks"),
        (GIVEN, {"letters": "F", "nodes": 4, "reads": ["sound"]}, "sound"),
        (GIVEN, {"letters": "F", "nodes": 4, "seed": "a"}, "seed"),
    ],
)
def test_mistakes_are_reported(training, settings, said):
    with np.errstate(all="ignore"), pytest.raises((DataError, SettingError), match=said):
        train(training, GIVEN[:1], **{"letters": "F", "nodes": 4, **settings} if not settings else settings)


def test_what_a_model_does_not_read_is_refused():
    model = train(GIVEN, GIVEN[:1], letters="F", nodes=4, max_epochs=1).model
    with pytest.raises(DataError, match="4 real-valued columns"):
        predict(model, INPUTS[:, :3])
    with pytest.raises(DataError, match="4 real-valued columns"):
        predict(model, np.zeros((5, 4), int))
    with pytest.raises(DataError, match="computed from no recording"):
        predict(model, spoken(("b", 0.1), ("ah", 0.2)))
    with pytest.raises(DataError, match="the model reads nothing; give an alignment"):
        predict(model, "video.mp4")
    seen = train(classes(2), classes(1), letters="F", nodes=4, max_epochs=1).model
    with pytest.raises(DataError, match=r"2 of classes \(3, 3\)"):
        predict(seen, np.array([[0, 3]]))


def test_the_block_of_arrays_is_stored_and_no_system_can_have_it(tmp_path):
    save_block(tmp_path / "block.safetensors", Arrays(3, (2, 5)))
    assert load_block(tmp_path / "block.safetensors") == Arrays(3, (2, 5))
    assert Arrays(3, (2, 5)).layout.width == 10
    save_block(tmp_path / "bad.safetensors", Arrays(-1))
    with pytest.raises(StorageError, match="dimension"):
        load_block(tmp_path / "bad.safetensors")
    assert "Name another kind" in Arrays.unavailable()
    with pytest.raises(DataError, match="computed from no recording"):
        Arrays.fit({}, (), ())
