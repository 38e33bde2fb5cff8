import dataclasses
import math
import os
import signal
import subprocess
import sys
from dataclasses import asdict

import numpy as np
import pytest
import torch

from tests.unit.models.examples import BLOCKS, RATE, Values, task, utterances, with_stream
from visualspeech.errors import DataError, SettingError
from visualspeech.features.blocks.label_parts import LabelParts
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models import stack
from visualspeech.models import training as module
from visualspeech.models.network import Network
from visualspeech.models.objectives import ConcordanceCorrelation, objective_of
from visualspeech.models.stack import Stack
from visualspeech.models.stack_settings import StackSettings
from visualspeech.models.training import remove_checkpoint, train
from visualspeech.models.training_settings import TrainingSettings, training_settings
from visualspeech.storage.models import read_model

TRAINING, VALIDATION = utterances(20), utterances(5, seed=1)
FAST = training_settings(max_epochs=6, batch_size=4, learning_rate=0.01)


def run(
    settings=FAST, letters="FB", checkpoint=None, training=None, validation=None, blocks=None, identity=(), nodes=8
):
    own, blocks = StackSettings(letters, nodes), blocks or BLOCKS
    layouts = [block.layout for block in blocks.values()]
    given = task(
        "stack",
        training=TRAINING if training is None else training,
        validation=validation or VALIDATION,
        blocks=blocks,
        checkpoint=checkpoint,
    )
    return train(lambda outputs: Stack(own, layouts, outputs, settings.dropout), given, settings, identity, 0.0)


def network(result, letters="FB", blocks=None):
    return Network("stack", asdict(StackSettings(letters, 8)), result.module, result.scaling, blocks or BLOCKS, RATE)


def bytes_of(result):
    parts = [values.numpy().tobytes() for values in result.module.state_dict().values()]
    return b"".join([*parts, result.scaling.mean.tobytes(), result.scaling.scale.tobytes()])


def without_seconds(result):
    return [row[:3] for row in result.curve]


class Killed(BaseException):
    pass


def kill_after(epochs, monkeypatch):
    """Let training die right after it has kept the given number of checkpoints."""
    write, left = module.write_checkpoint, [epochs]

    def dying(*arguments):
        write(*arguments)
        left[0] -= 1
        if not left[0]:
            raise Killed

    monkeypatch.setattr(module, "write_checkpoint", dying)


def error_of(name, result, letters="FB", validation=VALIDATION):
    """The objective of a network on utterances, through what it predicts, in units of the targets."""
    pairs = [(network(result, letters).predict(one.streams), one.target) for one in validation]
    predicted, true = (torch.tensor(np.concatenate(side)).double()[None] for side in zip(*pairs, strict=True))
    frames = torch.tensor([true.shape[1]])
    objective = objective_of(training_settings(objective=name))
    loss = objective.loss(predicted, true, frames).item()
    return loss / frames.item() if objective.additive else loss


@pytest.mark.parametrize(("objective", "batcher"), [("sse", "utterances"), ("mse", "utterances"), ("ccc", "frames")])
def test_learning_beats_the_mean_and_the_curve_is_the_error_of_the_network(objective, batcher):
    settings = training_settings(
        max_epochs=25, batch_size=2, batch_frames=60, batcher=batcher, learning_rate=0.02, dropout=0.0,
        objective=objective,
    )  # fmt: skip
    result = run(settings)
    error = {row[0]: row[2] for row in result.curve}
    assert error_of(objective, result) == pytest.approx(error[result.best_epoch], rel=1e-4)
    assert error[result.best_epoch] == min(error.values())
    values = np.concatenate([one.target for one in TRAINING])
    squares = sum(np.square(values.mean(axis=0) - one.target).sum() for one in VALIDATION)
    frames = sum(len(one.target) for one in VALIDATION)
    mean = {"sse": squares / 2 / frames, "mse": squares / frames / 4, "ccc": 1.0}[objective]
    assert error[result.best_epoch] < 0.35 * mean


def test_dimensions_scaled_apart_are_scaled_back():
    wide = [one._replace(target=one.target * np.float32([1, 10, 100, 0.1])) for one in TRAINING]
    check = [one._replace(target=one.target * np.float32([1, 10, 100, 0.1])) for one in VALIDATION]
    settings = dataclasses.replace(FAST, max_epochs=25, learning_rate=0.02, dropout=0.0, scaling="dimension")
    result = run(settings, training=wide, validation=check)
    frames = np.concatenate([one.target for one in wide]).astype(np.float64)
    assert np.allclose(result.scaling.scale, frames.std(axis=0)) and np.allclose(
        result.scaling.mean, frames.mean(axis=0)
    )
    predicted, true = (
        np.concatenate(side)
        for side in zip(*((network(result).predict(o.streams), o.target) for o in check), strict=True)
    )
    # Every dimension is learned, the smallest too; the curve is in units of the scaled targets.
    shares = np.square(predicted - true).mean(axis=0) / true.var(axis=0)
    assert (shares < 0.5).all()
    scaled = 0.5 * np.square((predicted - true) / result.scaling.scale).sum() / len(true)
    assert scaled == pytest.approx(result.curve[result.best_epoch - 1][2], rel=1e-4)


@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_the_same_settings_give_the_same_bytes_on_any_number_of_threads(optimiser):
    settings = training_settings(optimiser=optimiser, max_epochs=2, batch_size=4, learning_rate=1e-5)
    first = bytes_of(run(settings))
    torch.rand(3)
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        assert bytes_of(run(settings)) == first
    finally:
        torch.set_num_threads(threads)
    assert bytes_of(run(dataclasses.replace(settings, seed=2))) != first


def test_random_numbers_of_the_caller_are_left_alone():
    torch.manual_seed(3)
    expected = torch.rand(2)
    torch.manual_seed(3)
    run(dataclasses.replace(FAST, max_epochs=1))
    assert torch.equal(torch.rand(2), expected)


@pytest.mark.parametrize("epochs", range(1, 7))
@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_killed_after_any_epoch_then_resumed_is_as_if_never_killed(tmp_path, monkeypatch, optimiser, epochs):
    rate = 0.02 if optimiser == "adam" else 1e-5
    # A short patience for the learning rate, so that its decay is interrupted too.
    settings = training_settings(
        optimiser=optimiser, max_epochs=6, batch_size=4, learning_rate=rate, lr_decay=0.5, lr_patience=1
    )
    whole = run(settings)
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(epochs, patch)
        run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    resumed = run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    assert bytes_of(resumed) == bytes_of(whole)
    assert without_seconds(resumed) == without_seconds(whole)


def test_a_resumed_training_of_frames_by_concordance_is_as_if_never_killed(tmp_path, monkeypatch):
    settings = dataclasses.replace(FAST, objective="ccc", batcher="frames", batch_frames=80, scaling="dimension")
    whole = run(settings)
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(3, patch)
        run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    resumed = run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    assert bytes_of(resumed) == bytes_of(whole) and without_seconds(resumed) == without_seconds(whole)


def test_resuming_does_not_repeat_what_was_done(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.safetensors"
    run(checkpoint=path)
    monkeypatch.setattr(module, "_epoch", lambda *_: pytest.fail("trained again"))
    assert len(run(checkpoint=path).curve) == 6


@pytest.mark.parametrize(
    "change",
    [
        {"settings": dataclasses.replace(FAST, learning_rate=0.02)},
        {"settings": dataclasses.replace(FAST, objective="mse")},
        {"settings": dataclasses.replace(FAST, batcher="frames", batch_frames=80)},
        {"settings": dataclasses.replace(FAST, scaling="dimension")},
        {"training": TRAINING[1:]},
        {"validation": VALIDATION[1:]},
        {"identity": ("another code of the module",)},
    ],
)
def test_a_checkpoint_of_other_settings_data_or_code_is_not_used(tmp_path, change):
    path = tmp_path / "checkpoint.safetensors"
    run(checkpoint=path)
    result = run(**change, checkpoint=path)
    assert without_seconds(result) == without_seconds(run(**change)) and bytes_of(result) == bytes_of(run(**change))


def dense(dtype, shift=0.0):
    """The utterances with one more input block, of real values of one type."""
    generator = np.random.default_rng(3)
    parts = []
    for examples in (TRAINING, VALIDATION):
        values = [np.round(generator.normal(size=(len(one.target), 2)), 1) for one in examples]
        values[0][0, 0] += shift
        parts.append(with_stream(examples, [Stream(values=one.astype(dtype)) for one in values]))
    return {"training": parts[0], "validation": parts[1], "blocks": {**BLOCKS, "dense": Values(2)}}


@pytest.mark.parametrize("change", [{"dtype": np.float64}, {"dtype": np.float32, "shift": 1e-6}])
def test_dense_inputs_of_another_type_or_of_other_bytes_are_not_resumed(tmp_path, monkeypatch, change):
    path = tmp_path / "checkpoint.safetensors"
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(2, patch)
        run(**dense(np.float32), checkpoint=path)
    started = []
    epoch = module._epoch
    monkeypatch.setattr(module, "_epoch", lambda state, own: (started.append(len(state.curve)), epoch(state, own)))
    run(**dense(**change), checkpoint=path)
    assert started[0] == 0
    started.clear()
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(2, patch)
        run(**dense(np.float32), checkpoint=path)
    started.clear()
    run(**dense(np.float32), checkpoint=path)
    assert started[0] == 2


def test_a_broken_checkpoint_is_not_used(tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    path.write_bytes(b"half a file")
    assert bytes_of(run(checkpoint=path)) == bytes_of(run())
    remove_checkpoint(path)
    assert not path.exists()
    remove_checkpoint(path)
    remove_checkpoint(None)


SCRIPT = """
import os, signal, sys
from visualspeech.models import training as module
from tests.unit.models.test_training import FAST, run
write, left = module.write_checkpoint, [3]
def dying(*arguments):
    write(*arguments)
    left[0] -= 1
    if not left[0]:
        os.kill(os.getpid(), signal.SIGKILL)
module.write_checkpoint = dying
run(FAST, checkpoint=sys.argv[1])
"""


def test_a_process_that_is_really_killed(tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    killed = subprocess.run([sys.executable, "-c", SCRIPT, str(path)], env=environment, capture_output=True)
    assert killed.returncode == -signal.SIGKILL, killed.stderr.decode()
    assert bytes_of(run(checkpoint=path)) == bytes_of(run())


def test_paper_preset_steps_as_equation_11():
    settings = training_settings(
        optimiser="paper", max_epochs=2, batch_size=1, learning_rate=1e-4, momentum=0.5, patience=5
    )
    one = [TRAINING[0]]
    result = run(settings, "F", training=one, validation=one, nodes=3)
    given = module.batch(one, np.arange(1), result.scaling)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        own = module._start(Stack(StackSettings("F", 3), [BLOCKS["tri"].layout], 4), settings).module
    step = [torch.zeros_like(weights) for weights in own.parameters()]
    assert torch.equal(given.targets[0], torch.tensor(one[0].target))
    for _ in range(2):
        error = 0.5 * torch.sum((own(given) - given.targets) ** 2)
        gradients = torch.autograd.grad(error, list(own.parameters()))
        step = [0.5 * before - 1e-4 * gradient for before, gradient in zip(step, gradients, strict=True)]
        with torch.no_grad():
            for weights, change in zip(own.parameters(), step, strict=True):
                weights += change
    assert result.best_epoch == 2
    for name, weights in own.state_dict().items():
        assert torch.allclose(result.module.state_dict()[name], weights, rtol=1e-5, atol=1e-7)


def test_training_ends_by_patience():
    settings = training_settings(max_epochs=50, patience=3, min_improvement=0.9, batch_size=20, learning_rate=1e-6)
    result = run(settings)
    assert len(result.curve) == 4
    # Falls too small to train on for are no reason to keep worse weights.
    errors = [row[2] for row in result.curve]
    assert errors[result.best_epoch - 1] == min(errors) < errors[0]


def test_the_learning_rate_decays_when_validation_stands_still(tmp_path):
    settings = training_settings(
        max_epochs=7, patience=50, min_improvement=0.9, learning_rate=1e-6, lr_patience=2, lr_decay=0.5
    )
    path = tmp_path / "checkpoint.safetensors"
    run(settings, checkpoint=path)
    # Better in the first epoch alone; then three times two epochs without.
    assert read_model(path)[1]["learning_rate"] == pytest.approx(1e-6 / 8)


@pytest.mark.parametrize("objective", ["sse", "ccc"])
def test_divergence_names_the_learning_rate(objective, monkeypatch):
    settings = training_settings(optimiser="paper", max_epochs=50, learning_rate=1.0, objective=objective)
    if objective == "ccc":
        monkeypatch.setattr(ConcordanceCorrelation, "value", lambda self, sums, frames: math.nan)
    with pytest.raises(SettingError, match="training of model diverged in epoch .* `training.learning_rate` .now 1"):
        run(settings)


def test_the_norm_of_the_gradient_is_bounded():
    settings = training_settings(
        optimiser="paper", max_epochs=1, batch_size=20, learning_rate=1.0, momentum=0.0, max_grad_norm=1e-3
    )
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        before = module._start(Stack(StackSettings("FB", 8), [BLOCKS["tri"].layout], 4), settings).module.state_dict()
    after = run(settings).module.state_dict()
    moved = math.sqrt(sum(((after[name] - before[name]) ** 2).sum().item() for name in before))
    assert moved == pytest.approx(1e-3, rel=1e-2)


def test_the_average_of_the_weights_follows_its_definition():
    def weights(decay):
        settings = dataclasses.replace(FAST, max_epochs=1, batch_size=20, ema_decay=decay, dropout=0.0)
        return run(settings).module.state_dict()["output.bias"]

    # One update: with the decay of the first update, 1 / 10, the average lies 9 / 10 of the way to the new weights.
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(FAST.seed)
        start = Stack(StackSettings("FB", 8), [BLOCKS["tri"].layout], 4).state_dict()["output.bias"]
    assert torch.allclose(weights(0.99), start + 0.9 * (weights(0.0) - start), atol=1e-7)


def test_data_that_does_not_fit():
    with pytest.raises(DataError, match="no training utterance"):
        run(training=[])
    (stream,), values, rate = TRAINING[0]
    with pytest.raises(DataError, match="`tri`: a class is outside its inventory"):
        run(training=[Example((Stream(stream.index + np.int16(6)),), values, rate)])
    with pytest.raises(DataError, match="a training utterance has target parameters that are not finite"):
        run(training=[TRAINING[0]._replace(target=values * np.nan)])
    with pytest.raises(DataError, match="a validation utterance has target parameters that are not finite"):
        run(validation=[TRAINING[0]._replace(target=values * np.inf)])


@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_a_family_trains_what_its_row_says(tmp_path, optimiser):
    options = {"optimiser": optimiser, "max_epochs": 2, "learning_rate": 1e-5}
    given = task("stack", {"letters": "FB", "nodes": 6}, TRAINING, VALIDATION, options=options, seed=5, coding="abc")
    fitted = stack.fit(given)
    assert fitted.curve.columns.tolist() == ["epoch", "train", "validation", "seconds"] and len(fitted.curve) == 2
    model = fitted.model
    assert (model.coding, model.rate, model.blocks, model.outputs) == ("abc", RATE, BLOCKS, 4)
    assert model.about["training"]["seed"] == 5 and model.about["training"]["optimiser"] == optimiser
    assert model.about["epochs"] == 2 and model.settings["letters"] == "FB"
    model.save(tmp_path / "model.safetensors")
    streams = VALIDATION[0].streams
    assert np.array_equal(stack.load(tmp_path / "model.safetensors").predict(streams), model.predict(streams))


def test_a_network_learns_from_a_second_block_and_keeps_it(tmp_path):
    """What the second block says is half of the face, and the phones say nothing of it."""
    generator = np.random.default_rng(1)

    def rich(examples):
        parts = [generator.integers(0, 4, len(one.target)).astype(np.int16) for one in examples]
        shifts = [20 * np.stack([np.sin(part), np.cos(part), part, -part], axis=1) for part in parts]
        moved = [
            one._replace(target=(one.target + shift).astype(np.float32))
            for one, shift in zip(examples, shifts, strict=True)
        ]
        return with_stream(moved, [Stream(index=part[:, None]) for part in parts])

    training, validation = rich(TRAINING), rich(VALIDATION)
    blocks = {**BLOCKS, "parts": LabelParts(("stress",))}
    settings = TrainingSettings(max_epochs=30, dropout=0.0, ema_decay=0.0, learning_rate=0.02)
    both = run(settings, "F", training=training, validation=validation, blocks=blocks)
    plain = [[one._replace(streams=one.streams[:1]) for one in part] for part in (training, validation)]
    poor = run(settings, "F", training=plain[0], validation=plain[1])
    assert min(row[2] for row in both.curve) < 0.5 * min(row[2] for row in poor.curve)
    network(both, "F", blocks).save(tmp_path / "both.safetensors")
    again = stack.load(tmp_path / "both.safetensors")
    assert again.blocks == blocks and list(again.blocks) == ["tri", "parts"]
    streams = validation[0].streams
    np.testing.assert_array_equal(again.predict(streams), network(both, "F", blocks).predict(streams))
    with pytest.raises(DataError, match="1 input streams given, the model reads 2: tri, parts"):
        again.predict(streams[:1])
    with pytest.raises(DataError, match="`parts`: a class is outside its inventory"):
        again.predict([streams[0], Stream(index=streams[1].index + 4)])


@pytest.mark.parametrize(
    "change",
    [
        {"batch_size": 0}, {"batch_frames": 0}, {"learning_rate": 0}, {"dropout": 1.0}, {"patience": 0},
        {"objective": "mae"}, {"batcher": "frame"}, {"scaling": True}, {"ema_decay": 1},
    ],
)  # fmt: skip
def test_settings_out_of_range_are_named(change):
    with pytest.raises(SettingError, match=f"training.{next(iter(change))}"):
        TrainingSettings(**change)


def test_unknown_settings_are_named():
    with pytest.raises(SettingError, match="training.learning_rat`"):
        training_settings(learning_rat=0.1)
    with pytest.raises(SettingError, match="optimiser"):
        training_settings(optimiser="adamm")


def test_presets():
    assert training_settings() == TrainingSettings()
    paper = training_settings({"optimiser": "paper"}, seed=3)
    assert (paper.learning_rate, paper.momentum, paper.scaling, paper.seed) == (1e-6, 0.9, "none", 3)
    assert paper.initial_std > 0
    assert training_settings({"optimiser": "paper", "dropout": 0.5}, dropout=0.2).dropout == 0.2
