import dataclasses
import os
import signal
import subprocess
import sys

import numpy as np
import pytest
import torch

from tests.unit.models.examples import PHONES, utterances
from visualspeech.errors import DataError, SettingError
from visualspeech.models import training as module
from visualspeech.models.blstm import StackSettings
from visualspeech.models.training import TrainingSettings, sum_of_squared_errors, train, training_settings

TRAINING, VALIDATION = utterances(20), utterances(5, seed=1)
FAST = training_settings(max_epochs=6, batch=4, learning_rate=0.01)


def run(settings=FAST, letters="FB", checkpoint=None, training=None, seconds=0.0):
    data = TRAINING if training is None else training
    return train(StackSettings(letters, 8), PHONES, data, VALIDATION, 25.0, settings, checkpoint, seconds)


def bytes_of(result, folder):
    result.network.save(folder / "network.safetensors")
    return (folder / "network.safetensors").read_bytes()


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


def test_error_is_half_the_sum_of_squares():
    # Two frames of two dimensions: (1 + 4 + 0 + 9) / 2.
    assert sum_of_squared_errors(torch.tensor([[1.0, 2], [3, 4]]), torch.tensor([[0.0, 0], [3, 1]])).item() == 7.0


def test_learning_beats_the_mean_and_the_curve_is_the_error_of_the_network():
    result = run(training_settings(max_epochs=25, batch=2, learning_rate=0.02, dropout=0.0), "FB")
    frames = sum(len(values) for _, values in VALIDATION)
    squares = sum(np.square(result.network.predict(labels) - values).sum() for labels, values in VALIDATION)
    error = {row[0]: row[2] for row in result.curve}
    assert squares / 2 / frames == pytest.approx(error[result.best_epoch], rel=1e-4)
    assert error[result.best_epoch] == pytest.approx(min(error.values()), rel=1e-3)
    values = np.concatenate([values for _, values in TRAINING])
    mean = sum(np.square(values.mean(axis=0) - truth).sum() for _, truth in VALIDATION) / 2 / frames
    assert error[result.best_epoch] < 0.35 * mean


@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_the_same_settings_give_the_same_bytes_on_any_number_of_threads(tmp_path, optimiser):
    settings = training_settings(optimiser, max_epochs=2, batch=4, learning_rate=1e-5)
    first = bytes_of(run(settings), tmp_path)
    torch.rand(3)
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        assert bytes_of(run(settings), tmp_path) == first
    finally:
        torch.set_num_threads(threads)
    assert bytes_of(run(dataclasses.replace(settings, seed=2)), tmp_path) != first


@pytest.mark.parametrize("epochs", range(1, 7))
@pytest.mark.parametrize("optimiser", ["adam", "paper"])
def test_killed_after_any_epoch_then_resumed_is_as_if_never_killed(tmp_path, monkeypatch, optimiser, epochs):
    rate = 0.02 if optimiser == "adam" else 1e-5
    # A short patience for the learning rate, so that its decay is interrupted too.
    settings = training_settings(optimiser, max_epochs=6, batch=4, learning_rate=rate, decay=0.5, decay_patience=1)
    whole = run(settings)
    with monkeypatch.context() as patch, pytest.raises(Killed):
        kill_after(epochs, patch)
        run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    resumed = run(settings, checkpoint=tmp_path / "checkpoint.safetensors")
    assert bytes_of(resumed, tmp_path) == bytes_of(whole, tmp_path)
    assert without_seconds(resumed) == without_seconds(whole)


def test_resuming_does_not_repeat_what_was_done(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.safetensors"
    run(checkpoint=path)
    monkeypatch.setattr(module, "_epoch", lambda *_: pytest.fail("trained again"))
    assert len(run(checkpoint=path).curve) == 6


def test_a_checkpoint_of_other_settings_or_data_is_not_used(tmp_path, monkeypatch):
    path = tmp_path / "checkpoint.safetensors"
    changed = dataclasses.replace(FAST, learning_rate=0.02)
    expected = bytes_of(run(changed), tmp_path), bytes_of(run(training=TRAINING[1:]), tmp_path)
    run(checkpoint=path)
    assert bytes_of(run(changed, checkpoint=path), tmp_path) == expected[0]
    assert bytes_of(run(training=TRAINING[1:], checkpoint=path), tmp_path) == expected[1]


def test_a_broken_checkpoint_is_not_used(tmp_path):
    path = tmp_path / "checkpoint.safetensors"
    path.write_bytes(b"half a file")
    assert bytes_of(run(checkpoint=path), tmp_path) == bytes_of(run(), tmp_path)


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
    assert bytes_of(run(checkpoint=path), tmp_path) == bytes_of(run(), tmp_path)


def test_paper_preset_steps_as_equation_11():
    settings = training_settings("paper", max_epochs=2, batch=1, learning_rate=1e-4, momentum=0.5, patience=5)
    one = [TRAINING[0]]
    result = train(StackSettings("F", 3), PHONES, one, one, 25.0, settings)
    labels = torch.tensor(one[0][0].astype(np.int64))[None]
    truth, lengths = torch.tensor(one[0][1])[None], torch.tensor([len(one[0][1])])
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        stack = module._start(StackSettings("F", 3), len(PHONES), 4, settings).module
    step = [torch.zeros_like(weights) for weights in stack.parameters()]
    for _ in range(2):
        gradients = torch.autograd.grad(sum_of_squared_errors(stack(labels, lengths), truth), list(stack.parameters()))
        step = [0.5 * before - 1e-4 * gradient for before, gradient in zip(step, gradients, strict=True)]
        with torch.no_grad():
            for weights, change in zip(stack.parameters(), step, strict=True):
                weights += change
    assert result.best_epoch == 2
    for name, weights in stack.state_dict().items():
        assert np.allclose(result.network.weights[name], weights.numpy(), rtol=1e-5, atol=1e-7)


def test_training_ends_by_patience():
    settings = training_settings(max_epochs=50, patience=3, min_improvement=0.9, batch=20, learning_rate=1e-6)
    assert len(run(settings).curve) == 4


def test_divergence_names_the_learning_rate():
    settings = training_settings("paper", max_epochs=50, learning_rate=1.0)
    with pytest.raises(SettingError, match="learning_rate"):
        run(settings)


def test_data_that_does_not_fit():
    with pytest.raises(DataError, match="no training utterance"):
        run(training=[])
    labels, values = TRAINING[0]
    with pytest.raises(DataError, match="inventory"):
        run(training=[(labels + np.int16(6), values)])
    with pytest.raises(DataError, match="no number"):
        run(training=[(labels, values * np.nan)])


@pytest.mark.parametrize("change", [{"batch": 0}, {"learning_rate": 0}, {"dropout": 1.0}, {"patience": 0}])
def test_settings_out_of_range_are_named(change):
    with pytest.raises(SettingError, match=f"training.{next(iter(change))}"):
        TrainingSettings(**change)


def test_unknown_settings_are_named():
    with pytest.raises(SettingError, match="training.learning_rat`"):
        training_settings(learning_rat=0.1)
    with pytest.raises(SettingError, match="optimiser"):
        training_settings("adamm")


def test_presets():
    assert training_settings() == TrainingSettings()
    paper = training_settings("paper")
    assert (paper.learning_rate, paper.momentum, paper.scale_targets) == (1e-6, 0.9, False)
    assert paper.initial_std > 0
