"""Networks with static, delta and delta-delta outputs: their targets, variances and trajectories, through files."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.models.examples import BLOCKS, task, utterances
from visualspeech.errors import SettingError, StorageError
from visualspeech.models import stack
from visualspeech.models.batches import Scaling
from visualspeech.models.registry import load_model
from visualspeech.models.trajectory.generation import step_of
from visualspeech.models.trajectory.mlpg import Mlpg, Observed, error_variance
from visualspeech.models.trajectory.windows import observations, stacked, window_matrix
from visualspeech.storage.models import read_model, write_model

SETTINGS = {"letters": "CC", "nodes": 16, "trajectory": "mlpg", "delta_step": 0.08}
OPTIONS = {"max_epochs": 60, "patience": 60, "dropout": 0.0, "ema_decay": 0.5, "learning_rate": 0.01}


def dense(means, variance, step):
    """The most likely trajectory by weighted least squares, one dimension after the other."""
    matrix, mean = window_matrix(len(means), step).toarray(), stacked(means.astype(np.float64))
    weight = 1 / np.sqrt(stacked(np.tile(variance.astype(np.float64), (len(means), 1))))
    columns = [
        np.linalg.lstsq(weight[:, n, None] * matrix, weight[:, n] * mean[:, n], rcond=None)[0]
        for n in range(mean.shape[1])
    ]
    return np.stack(columns, axis=1)


@pytest.mark.parametrize(("frames", "delta_step"), [(1, 0.04), (9, 0.0001), (20, 0.08), (31, 0.2)])
def test_a_trajectory_is_weighted_least_squares(frames, delta_step):
    random = np.random.default_rng(frames)
    means, variance = random.normal(size=(frames, 6)), np.exp(random.normal(size=6)).astype(np.float32)
    found = Mlpg(variance, delta_step).trajectory(means, 25.0)
    np.testing.assert_allclose(found, dense(means, variance, max(round(25 * delta_step), 1)), atol=1e-9)


def test_the_step_is_a_time_and_at_least_a_frame():
    assert [step_of(0.04, rate) for rate in (10, 25, 50, 100, 120)] == [1, 1, 2, 4, 5]
    assert step_of(0.0001, 25) == 1


def test_targets_of_recorded_utterances_give_them_back():
    example = utterances(1)[0]
    seen = Observed([example], 0.08)[0]
    assert seen.target.dtype == np.float32 and seen.streams is example.streams
    np.testing.assert_allclose(seen.target, observations(example.target, 2), rtol=1e-5, atol=1e-5)
    variance = np.exp(np.random.default_rng(1).normal(size=12))
    np.testing.assert_allclose(Mlpg(variance, 0.08).trajectory(seen.target, 25.0), example.target, atol=1e-4)


def test_the_variance_of_errors_is_their_mean_square_and_never_zero():
    errors = [np.array([[1.0, 0.0, 2.0], [3.0, 0.0, 0.0]]), np.array([[2.0, 0.0, 1.0]])]
    np.testing.assert_allclose(error_variance(errors), [14 / 3, 1e-6 * 14 / 3, 5 / 3], rtol=1e-6)
    np.testing.assert_array_equal(error_variance([np.zeros((2, 3))]), np.ones(3, np.float32))


@pytest.fixture(scope="module", params=["global", "dimension"])
def fitted(request):
    options = {**OPTIONS, "scaling": request.param}
    return stack.fit(task("stack", SETTINGS, utterances(12), utterances(4, 5), options=options, coding="abc"))


def test_a_network_is_trained_on_all_three_streams_and_predicts_one(fitted):
    model, test = fitted.model, utterances(6, 9)
    assert model.outputs == 4 and len(model.scaling.mean) == 12
    training = utterances(12)
    expected = np.concatenate([model.observed(one.streams) - observations(one.target, 2) for one in training])
    np.testing.assert_allclose(model.mlpg.variance, np.square(expected, dtype=np.float64).mean(axis=0), rtol=1e-4)
    for one in test:
        found = model.predict(one.streams)
        assert found.dtype == np.float32 and found.shape == one.target.shape
        np.testing.assert_allclose(found, dense(model.observed(one.streams), model.mlpg.variance, 2), atol=1e-3)
    # All three streams are learned: what is left of each is less than half of its variance.
    seen = np.concatenate([observations(one.target, 2) for one in training])
    errors = np.concatenate([model.observed(one.streams) for one in training]) - seen
    left = np.square(errors).mean(axis=0).reshape(3, 4).sum(axis=1) / seen.var(axis=0).reshape(3, 4).sum(axis=1)
    assert (left < 0.5).all()


def test_the_file_gives_the_same_network(fitted, tmp_path):
    path = tmp_path / "model.safetensors"
    fitted.model.save(path)
    again, streams = load_model(path), utterances(1)[0].streams
    np.testing.assert_array_equal(again.predict(streams), fitted.model.predict(streams))
    assert (again.outputs, again.blocks, again.mlpg.delta_step) == (4, BLOCKS, 0.08)
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def changed(arrays, settings, **own):
    return arrays, {**settings, "settings": {**settings["settings"], **own}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a, s: changed(a, s, trajectory="none"), "the variances of a trajectory do not fit"),
        (lambda a, s: ({k: v for k, v in a.items() if k != "trajectory.variance"}, s), "the variances of a trajectory"),
        (lambda a, s: ({**a, "trajectory.more": a["trajectory.variance"]}, s), "the variances of a trajectory"),
        (lambda a, s: ({**a, "trajectory.variance": a["trajectory.variance"][:3]}, s), "has the shape"),
        (lambda a, s: ({**a, "trajectory.variance": 0 * a["mean"]}, s), "has a value that is no number from 1e-15"),
        (lambda a, s: ({**a, "trajectory.variance": np.logspace(-14, 11, 12)}, s), "too different to generate"),
        (lambda a, s: changed(a, {**s, "rate": 10000.0}, delta_step=1.0), "its windows reach over 10000 frames"),
        (lambda a, s: changed(a, s, trajectory="spline"), "`models.trajectory: spline` must be one of"),
    ],
)  # fmt: skip
def test_files_from_which_nothing_can_be_generated(fitted, tmp_path, change, said):
    path = tmp_path / "model.safetensors"
    fitted.model.save(path)
    arrays, settings = change(*read_model(path))
    write_model(path, arrays, settings)
    with pytest.raises(StorageError, match=said):
        load_model(path)


def test_outputs_that_are_not_three_streams(fitted, tmp_path):
    path = tmp_path / "model.safetensors"
    model = replace(fitted.model, scaling=Scaling(np.zeros(10), np.ones(10)), mlpg=Mlpg(np.ones(10), 0.08))
    model.module.output.weight.data = model.module.output.weight.data[:10]
    model.module.output.bias.data = model.module.output.bias.data[:10]
    model.save(path)
    with pytest.raises(StorageError, match="its 10 outputs are no static, delta and delta-delta parameters"):
        load_model(path)


def test_windows_that_are_too_wide_are_a_sentence():
    fast = [one._replace(rate=1000.0) for one in utterances(2)]
    given = task("stack", {**SETTINGS, "delta_step": 0.5}, fast, fast, options=OPTIONS)
    with pytest.raises(SettingError, match="`models.model.delta_step: 0.5` must be at most 0.2 at 1000 Hz: 200 frames"):
        stack.fit(given)
