"""The state of a training through its file."""

import numpy as np
import torch

from visualspeech.models.checkpoints import COUNTS, ERRORS, read_checkpoint, write_checkpoint
from visualspeech.models.training import _start
from visualspeech.models.training_settings import training_settings
from visualspeech.storage.models import write_model


def state(optimiser="adam", updates=3):
    """A state after some updates of a small module."""
    torch.manual_seed(1)
    result = _start(torch.nn.Linear(2, 1), training_settings(optimiser=optimiser, learning_rate=0.01))
    for _ in range(updates):
        result.optimiser.zero_grad()
        result.module(torch.ones(1, 2)).sum().backward()
        result.optimiser.step()
    result.best_error, result.best_epoch, result.improved_error, result.improved_epoch = 0.5, 2, 0.6, 1
    result.since_decay, result.updates = 1, updates
    result.curve = [(1, 3.0, 2.0, 0.1), (2, 1.0, 0.5, 0.1)]
    result.optimiser.param_groups[0]["lr"] = 0.005
    return result


def test_everything_comes_back(tmp_path):
    for optimiser in ("adam", "paper"):
        path, before = tmp_path / optimiser, state(optimiser)
        write_checkpoint(path, "identity", before)
        expected = torch.rand(3)
        after = state(optimiser, updates=0)
        assert read_checkpoint(path, "identity", after)
        assert torch.equal(torch.rand(3), expected)
        for name in ("module", "average"):
            for one, other in zip(getattr(before, name).parameters(), getattr(after, name).parameters(), strict=True):
                assert torch.equal(one, other)
        for name in (*ERRORS, *COUNTS, "curve"):
            assert getattr(after, name) == getattr(before, name)
        assert after.optimiser.param_groups[0]["lr"] == 0.005
        for one, other in zip(before.optimiser.state.values(), after.optimiser.state.values(), strict=True):
            assert one.keys() == other.keys() and all(torch.equal(one[name], other[name]) for name in one)


def test_what_is_no_checkpoint_of_this_training_is_not_read(tmp_path):
    path = tmp_path / "checkpoint"
    assert not read_checkpoint(path, "identity", None)
    write_checkpoint(path, "other", state())
    assert not read_checkpoint(path, "identity", None)
    path.write_bytes(b"half a file")
    assert not read_checkpoint(path, "identity", None)
    write_model(path, {"mean": np.zeros(1)}, {"kind": "model", "identity": "identity"})
    assert not read_checkpoint(path, "identity", None)
