"""The state of an interrupted training in one safetensors file."""

import math
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import StorageError
from visualspeech.jobs import log
from visualspeech.storage.models import part_of, read_model, write_model

#: Numbers of a training's state.
ERRORS = ("best_error", "improved_error")
COUNTS = ("best_epoch", "improved_epoch", "since_decay", "updates")


def write_checkpoint(path: str | Path, identity: str, state) -> None:
    """Keep a training's state: weights, their moving average, best weights, optimiser, random numbers, learning curve.

    Parameters
    ----------
    identity : digest of settings, data and code; a checkpoint of another one is not read
    state : see :class:`visualspeech.models.training._State`
    """
    tensors = {f"weights.{name}": values.numpy() for name, values in state.module.state_dict().items()}
    tensors |= {f"average.{name}": values.numpy() for name, values in state.average.state_dict().items()}
    tensors |= {f"best.{name}": values.numpy() for name, values in state.best.items()}
    optimiser = state.optimiser.state_dict()
    for number, moments in optimiser["state"].items():
        for name, values in moments.items():
            if values is not None:
                tensors[f"optimiser.{number}.{name}"] = values.numpy()
    tensors["random"] = torch.get_rng_state().numpy()
    tensors["curve"] = np.array(state.curve, dtype=np.float64).reshape(-1, 4)
    settings = {
        "kind": "checkpoint",
        "identity": identity,
        "learning_rate": optimiser["param_groups"][0]["lr"],
        **{name: getattr(state, name) for name in (*ERRORS, *COUNTS)},
    }
    write_model(path, tensors, settings)


def read_checkpoint(path: str | Path, identity: str, state) -> bool:
    """Bring ``state`` and the random numbers to where the checkpoint was; False where none fits ``identity``."""
    if not Path(path).is_file():
        return False
    try:
        tensors, settings = read_model(path)
    except StorageError:
        log.warning("%s cannot be read; training starts from the beginning", path)
        return False
    if settings.get("kind") != "checkpoint" or settings.get("identity") != identity:
        log.info("%s was made with other settings, data or code; training starts from the beginning", path)
        return False
    state.module.load_state_dict(_part(tensors, "weights"))
    state.average.load_state_dict(_part(tensors, "average"))
    state.best = _part(tensors, "best")
    moments: dict[int, dict[str, torch.Tensor]] = {}
    for name, values in _part(tensors, "optimiser").items():
        number, entry = name.split(".", 1)
        moments.setdefault(int(number), {})[entry] = values.reshape(()) if entry == "step" else values
    groups = state.optimiser.state_dict()["param_groups"]
    state.optimiser.load_state_dict({"state": moments, "param_groups": groups})
    for group in state.optimiser.param_groups:
        group["lr"] = settings["learning_rate"]
    for name in ERRORS:
        setattr(state, name, math.inf if settings[name] is None else settings[name])
    for name in COUNTS:
        setattr(state, name, settings[name])
    state.curve = [(int(row[0]), *map(float, row[1:])) for row in tensors["curve"]]
    torch.set_rng_state(torch.tensor(tensors["random"]))
    return True


def _part(tensors, part: str) -> dict[str, torch.Tensor]:
    return {name: torch.tensor(values) for name, values in part_of(tensors, part).items()}
