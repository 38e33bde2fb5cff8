"""Feed-forward networks on windows: their outputs, training on single frames, trajectories and files."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, PHONES, RATE, Values, task, utterances, with_stream
from tests.unit.models.test_gathered import inputs
from tests.unit.models.test_training import Killed, bytes_of, kill_after, without_seconds
from visualspeech.errors import SettingError, StorageError
from visualspeech.features.blocks.phone_track import PhoneTrack
from visualspeech.features.streams import Layout, Stream
from visualspeech.models import dnn, gv_compensation, stack
from visualspeech.models import training as module
from visualspeech.models.batches import Scaling, batch
from visualspeech.models.dnn import Dnn, weight_shapes
from visualspeech.models.dnn_settings import ACTIVATIONS, DnnSettings
from visualspeech.models.gv_compensation import within_deviation
from visualspeech.models.objectives import objective_of
from visualspeech.models.registry import load_model
from visualspeech.models.training import train
from visualspeech.models.training_settings import training_settings
from visualspeech.models.trajectory.windows import observations
from visualspeech.storage.models import read_model, write_model

LAYOUTS = [replace(BLOCKS["tri"].layout, window=3), Layout(dimension=2)]
TRAINING, VALIDATION = utterances(20), utterances(5, seed=1)
FRAMES = {"batcher": "shuffled_frames", "batch_frames": 32, "objective": "mse", "scaling": "dimension"}
FAST = {**FRAMES, "max_epochs": 6, "learning_rate": 0.01}
WINDOWS = {"tri": 0.12}


def with_values(examples, seed=0):
    generator = np.random.default_rng(seed)
    streams = [Stream(values=generator.normal(size=(len(one.target), 2)).astype(np.float32)) for one in examples]
    return with_stream(examples, streams)


def padded(examples):
    order = np.argsort([-len(one.target) for one in examples], kind="stable")
    return [examples[n] for n in order], batch(examples, order, Scaling(np.zeros(4), np.ones(4)))


def given(settings=None, options=None, windows=WINDOWS, training=TRAINING, family="dnn", **more):
    made = task(family, settings or {"layers": 2, "nodes": 24}, training, VALIDATION, options=options or FAST, **more)
    return replace(made, row=replace(made.row, windows=windows))


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("layers", [1, 3])
def test_outputs_of_padded_utterances_against_plain_numpy(layers, activation):
    network = Dnn(DnnSettings(layers, 6, activation), LAYOUTS, 3).double().eval()
    examples, whole = padded(with_values(utterances(4)))
    function = {"tanh": np.tanh, "sigmoid": lambda x: 1 / (1 + np.exp(-x)), "relu": lambda x: np.maximum(x, 0)}
    weights = {name: values.numpy() for name, values in network.state_dict().items()}
    outputs = network(replace(whole, values=whole.values.double())).detach().numpy()
    for row, one in enumerate(examples):
        x = inputs(LAYOUTS, one.streams[0].index.astype(np.int64), one.streams[1].values)
        first = np.concatenate([weights["layers.0.classes"].T, weights["layers.0.values"]], axis=1)
        hidden = function[activation](x @ first.T + weights["layers.0.bias"])
        for layer in range(1, layers):
            product = hidden @ weights[f"layers.{layer}.weight"].T + weights[f"layers.{layer}.bias"]
            hidden = function[activation](product)
        expected = hidden @ weights["output.weight"].T + weights["output.bias"]
        np.testing.assert_allclose(outputs[row, : len(x)], expected, rtol=1e-6, atol=1e-6)
        assert not outputs[row, len(x) :].any()


def test_an_update_of_all_frames_is_an_update_of_all_utterances():
    options = {"objective": "mse", "optimiser": "paper", "learning_rate": 0.1, "max_epochs": 3, "momentum": 0.5}
    count = sum(len(one.target) for one in TRAINING)
    whole = dnn.fit(given(options={**options, "batcher": "utterances", "batch_size": len(TRAINING)}))
    single = dnn.fit(given(options={**options, "batcher": "shuffled_frames", "batch_frames": count}))
    assert without_seconds_of(single) == pytest.approx(without_seconds_of(whole), rel=1e-4)
    before = Dnn(DnnSettings(2, 24), [replace(BLOCKS["tri"].layout, window=3)], 4).state_dict()
    for name, values in single.model.module.state_dict().items():
        torch.testing.assert_close(values, whole.model.module.state_dict()[name], rtol=1e-3, atol=1e-4)
        assert values.shape == before[name].shape


def without_seconds_of(fitted):
    return fitted.curve[["train", "validation"]].to_numpy()


@pytest.mark.parametrize("objective", ["mse", "sse", "ccc"])
def test_training_on_single_frames_learns_and_its_curve_is_the_error_of_the_network(objective):
    options = {**FAST, "objective": objective, "max_epochs": 25, "dropout": 0.0, "scaling": "none", "ema_decay": 0.5}
    fitted = dnn.fit(given(options=options))
    predicted, true = (
        torch.tensor(np.concatenate(side)).double()[None]
        for side in zip(*((fitted.model.predict(one.streams), one.target) for one in VALIDATION), strict=True)
    )
    own, frames = objective_of(training_settings(objective=objective)), torch.tensor([true.shape[1]])
    error = own.loss(predicted, true, frames).item() / (frames.item() if own.additive else 1)
    assert error == pytest.approx(fitted.curve.validation.min(), rel=1e-4)
    mean = torch.tensor(np.concatenate([one.target for one in TRAINING]).mean(axis=0)).expand_as(true).double()
    trivial = own.loss(mean, true, frames).item() / (frames.item() if own.additive else 1)
    assert error < 0.4 * trivial


def test_a_window_tells_the_neighbours_that_the_frame_does_not():
    # Of the labels, the current phone alone; what is to be predicted depends on the phones before and after it, too.
    def current(examples):
        return [one._replace(streams=(Stream(index=one.streams[0].index[:, 1:2]),)) for one in examples]

    errors = []
    for windows in ({}, {"phone": 0.28}):
        blocks, options = {"phone": Values(0, (len(PHONES),))}, {**FAST, "max_epochs": 20, "dropout": 0.0}
        own = task("dnn", {"layers": 1, "nodes": 32}, current(TRAINING), current(VALIDATION), blocks, options)
        errors.append(dnn.fit(replace(own, row=replace(own.row, windows=windows))).curve.validation.min())
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_training_on_single_frames_is_the_same_interrupted_or_not(tmp_path, monkeypatch, optimiser):
    settings = training_settings({**FAST, "optimiser": optimiser, "lr_patience": 1})

    def run(checkpoint=None):
        own = given(checkpoint=checkpoint)
        layouts = [replace(BLOCKS["tri"].layout, window=3)]
        build = lambda outputs: Dnn(DnnSettings(2, 8), layouts, outputs, settings.dropout)  # noqa: E731
        return train(build, own, settings, (), 0.0)

    whole = run()
    assert bytes_of(run()) == bytes_of(whole)
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(3, patch)
        run(tmp_path / "checkpoint.safetensors")
    resumed = run(tmp_path / "checkpoint.safetensors")
    assert bytes_of(resumed) == bytes_of(whole) and without_seconds(resumed) == without_seconds(whole)


def test_a_checkpoint_of_another_window_is_not_used(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.safetensors"
    dnn.fit(given({"layers": 1, "nodes": 4}, checkpoint=path))
    with monkeypatch.context() as patch:
        patch.setattr(module, "_epoch", lambda *_: pytest.fail("trained again"))
        dnn.fit(given({"layers": 1, "nodes": 4}, checkpoint=path))
    other = given({"layers": 1, "nodes": 4}, windows={"tri": 0.16}, checkpoint=path)
    assert np.array_equal(dnn.fit(other).curve.validation, dnn.fit(replace(other, checkpoint=None)).curve.validation)


def test_windows_longer_than_every_utterance():
    examples = [
        one._replace(streams=(Stream(index=one.streams[0].index[:5]),), target=one.target[:5]) for one in TRAINING
    ]
    fitted = dnn.fit(replace(given(windows={"tri": 1.0}, training=examples), validation=examples))
    assert fitted.model.predict(examples[0].streams).shape == (5, 4)
    assert fitted.model.module.layers[0].classes.shape[0] == 51 * (3 * len(PHONES) + 3)


@pytest.fixture(scope="module")
def generated():
    return dnn.fit(
        given({"layers": 2, "nodes": 24, "trajectory": "mlpg", "delta_step": 0.04}, {**FAST, "max_epochs": 30})
    )


def test_a_network_of_static_and_dynamic_outputs_through_its_file(generated, tmp_path):
    path = tmp_path / "model.safetensors"
    generated.model.save(path)
    again = load_model(path)
    assert (again.outputs, again.windows, again.rate) == (4, WINDOWS, RATE) and len(again.scaling.mean) == 12
    streams = VALIDATION[0].streams
    np.testing.assert_array_equal(again.predict(streams), generated.model.predict(streams))
    again.save(tmp_path / "again.safetensors")
    assert (tmp_path / "again.safetensors").read_bytes() == path.read_bytes()


def test_a_network_without_windows_has_the_file_of_any_network(tmp_path):
    fitted = dnn.fit(given({"layers": 1, "nodes": 4}, {**FAST, "max_epochs": 1}, windows={}))
    fitted.model.save(tmp_path / "model.safetensors")
    assert "windows" not in read_model(tmp_path / "model.safetensors")[1]
    assert load_model(tmp_path / "model.safetensors").windows == {}


def test_the_variances_of_a_trajectory_are_those_of_the_errors_or_of_the_targets(generated):
    seen = [observations(one.target, 1) for one in TRAINING]
    errors = np.concatenate([generated.model.observed(one.streams) for one in TRAINING]) - np.concatenate(seen)
    np.testing.assert_allclose(generated.model.mlpg.variance, np.square(errors).mean(axis=0), rtol=1e-4)
    settings = {"layers": 1, "nodes": 8, "trajectory": "mlpg", "trajectory_variance": "targets", "delta_step": 0.04}
    other = dnn.fit(given(settings, {**FAST, "max_epochs": 1})).model
    np.testing.assert_allclose(other.mlpg.variance, np.concatenate(seen).var(axis=0, dtype=np.float64), rtol=1e-4)


def test_global_variance_compensation_of_a_network(generated, tmp_path):
    generated.model.save(tmp_path / "net.safetensors")
    own = task("gv_compensation", {"strength": 1.0}, TRAINING, VALIDATION, parents=[tmp_path / "net.safetensors"])
    model = gv_compensation.fit(own).model
    model.save(tmp_path / "model.safetensors")
    again = load_model(tmp_path / "model.safetensors")
    predicted = [again.predict(one.streams, len(one.target), RATE) for one in TRAINING]
    recorded = within_deviation(one.target for one in TRAINING)
    np.testing.assert_allclose(within_deviation(predicted), recorded, rtol=1e-4)
    plain = within_deviation(generated.model.predict(one.streams) for one in TRAINING)
    assert np.abs(plain / recorded - 1).max() > 0.02


@pytest.mark.parametrize("layers", [1, 2, 5])
def test_shapes_of_the_weights_are_known_without_a_network(layers):
    settings = {"layers": layers, "nodes": 6}
    made = Dnn(DnnSettings(**settings), LAYOUTS, 3).state_dict()
    assert weight_shapes(settings, LAYOUTS, 3) == {name: tuple(values.shape) for name, values in made.items()}


def test_hidden_values_are_dropped_in_training_alone():
    network = Dnn(DnnSettings(2, 64), LAYOUTS, 3, dropout=0.5)
    whole = padded(with_values(utterances(1)))[1]
    assert not torch.equal(network(whole), network(whole))
    network.eval()
    assert torch.equal(network(whole), network(whole))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"layers": 0}, "`models.layers: 0` must be at least 1 and at most 5"),
        ({"layers": 6}, "`models.layers: 6` must be at least 1 and at most 5"),
        ({"nodes": 4097}, "`models.nodes: 4097` must be at least 1 and at most 4096"),
        ({"activation": "softmax"}, "`models.activation: softmax` must be one of tanh, sigmoid, relu"),
    ],
)
def test_settings_out_of_bounds(settings, said):
    with pytest.raises(SettingError, match=said):
        DnnSettings(**settings)


@pytest.mark.parametrize("family", ["dnn", "stack"])
def test_segments_are_no_input_of_a_network(family):
    blocks = {"track": PhoneTrack(PHONES)}
    examples = [one._replace(streams=(Stream(index=np.zeros((2, 3), int), starts=np.arange(2.0)),)) for one in TRAINING]
    settings = {"dnn": {"layers": 1}, "stack": {"letters": "F"}}[family]
    with pytest.raises(SettingError, match="`reads` names track, which has a row per segment"):
        own = task(family, settings, examples, examples, blocks)
        {"dnn": dnn, "stack": stack}[family].fit(own)


def changed(arrays, plain, **own):
    return arrays, {**plain, **own}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda a, s: changed(a, s, windows={"tri": 0.16}), "of the weights, layers.0.classes differ"),
        (lambda a, s: changed(a, s, windows={"tri": -0.1}), "-0.1 is less than or equal to the minimum of 0"),
        (lambda a, s: changed(a, s, windows={"tri": 5}), "5 is greater than the maximum of 1"),
        (lambda a, s: changed(a, s, windows={"tri": None}), "None is not of type 'number'"),
        (lambda a, s: changed(a, s, windows={}), "`windows` in its settings"),
        (lambda a, s: changed(a, s, windows={"ph": 0.12}), "there is no input block of a window"),
        (lambda a, s: changed(a, s, rate=10_000.0), "of the weights, layers.0.classes differ"),
        (lambda a, s: changed(a, s, settings={**s["settings"], "nodes": 4096}), "of the weights"),
        (lambda a, s: changed(a, s, settings={**s["settings"], "layers": 4}), "of the weights, layers.2"),
        (lambda a, s: changed(a, s, settings={**s["settings"], "layers": 10**9}), "must be at least 1 and at most 5"),
        (lambda a, s: changed(a, {k: v for k, v in s.items() if k != "windows"}), "layers.0.classes differ"),
    ],
)  # fmt: skip
def test_altered_files_are_refused_before_a_network_is_made(generated, tmp_path, monkeypatch, change, said):
    path = tmp_path / "model.safetensors"
    generated.model.save(path)
    write_model(path, *change(*read_model(path)))
    monkeypatch.setattr(dnn, "Dnn", None)
    with pytest.raises(StorageError, match=said) as found:
        load_model(path)
    assert "model.safetensors" in str(found.value)


def test_real_values_in_a_window_alone():
    examples = [one._replace(streams=one.streams[1:]) for one in with_values(TRAINING)]
    own = task("dnn", {"layers": 1, "nodes": 4}, examples, examples, {"dense": Values(2)}, {**FAST, "max_epochs": 1})
    fitted = dnn.fit(replace(own, row=replace(own.row, windows={"dense": 0.08})))
    assert {name: tuple(values.shape) for name, values in fitted.model.module.layers[0].state_dict().items()} == {
        "values": (4, 10),
        "bias": (4,),
    }
