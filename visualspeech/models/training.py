"""Training of a stack by the sum of squared errors (Fan 2015, Eq. 9-11), with early stopping, checkpoint and resume."""

import copy
import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import SettingError
from visualspeech.features.label_parts import part_sizes
from visualspeech.jobs import log
from visualspeech.models.batches import batch, batches, content
from visualspeech.models.blstm import Stack, StackSettings
from visualspeech.models.checkpoints import read_checkpoint, write_checkpoint
from visualspeech.models.network import Network, one_thread
from visualspeech.provenance import code_digest, digest

PROGRESS_SECONDS = 3.0

#: What the optimiser presets change against the defaults of TrainingSettings.
PRESETS = {
    "adam": {},
    "paper": {
        "learning_rate": 1e-6,
        "decay": 1.0,
        "clip": 0.0,
        "initial_std": 0.1,
        "scale_targets": False,
        "dropout": 0.0,
        "averaging": 0.0,
    },
}


@dataclass(frozen=True)
class TrainingSettings:
    """How a network is trained. The defaults are the ``adam`` preset; see :func:`training_settings`.

    Parameters
    ----------
    optimiser : ``adam``, or ``paper``: gradient descent with momentum (Eq. 11)
    learning_rate : step size; for ``paper`` it multiplies the gradient of a batch's summed error, for ``adam`` scale
        does not matter
    momentum : m of Eq. 11; Adam's decay of the mean gradient
    batch : utterances an update
    max_epochs : epochs at most
    patience : epochs without a better validation error after which training ends (R of section 4.2)
    min_improvement : smallest relative fall of the validation error that counts as better
    decay : factor on the learning rate after ``decay_patience`` epochs without a better validation error; 1: none
    decay_patience : see ``decay``
    clip : limit of the gradient's norm (of the mean error a frame); 0: none
    initial_std : standard deviation of the Gaussian that all weights start from; 0: uniform, by layer width (torch's)
    scale_targets : learn (appearance - training mean) / one global standard deviation in place of raw appearance
    dropout : share of hidden values set to zero in training, after each hidden layer
    weight_decay : pull of the weights to zero, apart from the gradient (Loshchilov and Hutter 2019)
    averaging : the network that is judged and kept has the running mean of the weights over updates, each mean this
        share of the last (in the first updates, a smaller share); 0: the weights themselves
    seed : of initial weights, order and dropout
    """

    optimiser: str = "adam"
    learning_rate: float = 2e-3
    momentum: float = 0.9
    batch: int = 8
    max_epochs: int = 200
    patience: int = 8
    min_improvement: float = 1e-4
    decay: float = 0.5
    decay_patience: int = 4
    clip: float = 1.0
    initial_std: float = 0.0
    scale_targets: bool = True
    dropout: float = 0.3
    weight_decay: float = 0.0
    averaging: float = 0.99
    seed: int = 1

    def __post_init__(self) -> None:
        ranges = {
            "optimiser": (self.optimiser in PRESETS, f"one of {', '.join(PRESETS)}"),
            "learning_rate": (0 < self.learning_rate <= 1, "above 0 and at most 1"),
            "momentum": (0 <= self.momentum < 1, "at least 0 and below 1"),
            "batch": (self.batch >= 1, "at least 1"),
            "max_epochs": (self.max_epochs >= 1, "at least 1"),
            "patience": (self.patience >= 1, "at least 1"),
            "min_improvement": (0 <= self.min_improvement < 1, "at least 0 and below 1"),
            "decay": (0 < self.decay <= 1, "above 0 and at most 1"),
            "decay_patience": (self.decay_patience >= 1, "at least 1"),
            "clip": (self.clip >= 0, "at least 0"),
            "initial_std": (self.initial_std >= 0, "at least 0"),
            "dropout": (0 <= self.dropout < 1, "at least 0 and below 1"),
            "weight_decay": (self.weight_decay >= 0, "at least 0"),
            "averaging": (0 <= self.averaging < 1, "at least 0 and below 1"),
        }
        for name, (good, rule) in ranges.items():
            if not good:
                raise SettingError(f"`training.{name}: {getattr(self, name)}` must be {rule}.")


def training_settings(optimiser: str = "adam", **changes) -> TrainingSettings:
    """Settings of a preset (``adam`` or ``paper``), with changes.

    Raises
    ------
    SettingError
        The preset or a setting is unknown, or a value is out of range.
    """
    if optimiser not in PRESETS:
        raise SettingError(f"`training.optimiser: {optimiser}` must be one of {', '.join(PRESETS)}.")
    unknown = sorted(set(changes) - set(TrainingSettings.__dataclass_fields__))
    if unknown:
        known = ", ".join(TrainingSettings.__dataclass_fields__)
        raise SettingError(f"unknown setting `training.{unknown[0]}`. Known: {known}.")
    return TrainingSettings(**{"optimiser": optimiser, **PRESETS[optimiser], **changes})


@dataclass(frozen=True)
class Training:
    """A finished training.

    Parameters
    ----------
    network : with the weights of the best epoch
    curve : a row an epoch: (epoch, train, validation, seconds); errors are E of Eq. 10 a frame, in squared units of the
        appearance; ``train`` is taken during the epoch (with dropout), ``validation`` after it
    best_epoch : the epoch of the lowest validation error
    """

    network: Network
    curve: tuple[tuple[int, float, float, float], ...]
    best_epoch: int

    def curve_table(self):
        """The learning curve as a data frame: epoch, train, validation, seconds."""
        import pandas

        return pandas.DataFrame(list(self.curve), columns=["epoch", "train", "validation", "seconds"])


def sum_of_squared_errors(predicted: torch.Tensor, truth: torch.Tensor) -> torch.Tensor:
    """E of Eq. 9 and 10: half the squared differences, summed over dimensions, frames and sequences.

    Frames that only fill up a batch must be equal in both; the stack and the batches make them zero.
    """
    return 0.5 * torch.sum((predicted - truth) ** 2)


def _row(state: "_State") -> str:
    _, error, validation, seconds = state.curve[-1]
    best = f"best so far epoch {state.best_epoch}"
    return f"error a frame {error:.5g}, validation {validation:.5g} ({best}), {seconds:.1f} s an epoch"


@dataclass
class _State:
    """All that an interrupted training needs to go on as if nothing had happened."""

    module: Stack
    average: Stack
    optimiser: torch.optim.Optimizer
    best: dict[str, torch.Tensor]
    best_error: float = math.inf
    best_epoch: int = 0
    since_decay: int = 0
    updates: int = 0
    curve: list[tuple[int, float, float, float]] = field(default_factory=list)


def train(
    stack: StackSettings,
    phones: Sequence[str],
    training: Sequence[tuple[np.ndarray, np.ndarray]],
    validation: Sequence[tuple[np.ndarray, np.ndarray]],
    rate: float,
    settings: TrainingSettings | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_seconds: float = 10.0,
    aam: str = "",
    parts: Sequence[str] = (),
) -> Training:
    """Train a network on utterances, ending by the validation error, with the weights of the best epoch.

    Runs on one thread. The same data and settings give the same bytes, interrupted or not.

    Parameters
    ----------
    stack : hidden layers
    phones : inventory, K entries
    training, validation : utterances as (labels (T, 4), appearance (T, N)); read one batch at a time
    rate : frame rate in Hz, kept in the network's file
    checkpoint : file that the state is kept in after an epoch, at most every ``checkpoint_seconds``; if it is there and
        was made by this code from these settings and data, training goes on from it. The caller removes it once the
        network is saved.
    aam : digest of the appearance model, kept in the network's file
    parts : label parts, a further column of the labels each (:data:`visualspeech.features.label_parts.PARTS`)

    Raises
    ------
    DataError
        There is nothing to learn from, or the data does not fit the inventory.
    SettingError
        The error is no longer a finite number.
    """
    settings = settings or TrainingSettings()
    sizes = part_sizes(parts)
    known = [
        content(examples, len(phones), name, sizes)
        for examples, name in ((training, "training"), (validation, "validation"))
    ]
    mean = known[0].mean if settings.scale_targets else np.zeros_like(known[0].mean)
    scale = known[0].deviation if settings.scale_targets else 1.0
    identity = digest(
        [
            asdict(stack),
            asdict(settings),
            list(phones),
            list(parts),
            [part.digest for part in known],
            torch.__version__,
            code_digest(__file__),
        ]
    )
    with one_thread(), torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        state = _start(stack, len(phones), len(mean), settings, sizes)
        if checkpoint is not None and read_checkpoint(checkpoint, identity, state):
            log.info("%s: going on after epoch %d", stack.name, len(state.curve))
        saved = told = time.monotonic()
        while not _finished(state, settings):
            _epoch(state, settings, (training, validation), known, mean, scale, stack.name)
            if time.monotonic() - told >= PROGRESS_SECONDS or _finished(state, settings):
                told = time.monotonic()
                log.info(
                    "%s: epoch %d of at most %d, %s", stack.name, len(state.curve), settings.max_epochs, _row(state)
                )
            if checkpoint is not None and time.monotonic() - saved >= checkpoint_seconds:
                write_checkpoint(checkpoint, identity, state)
                saved = time.monotonic()
        if checkpoint is not None:
            write_checkpoint(checkpoint, identity, state)
    network = Network(
        stack=stack,
        phones=tuple(phones),
        weights={name: values.numpy().copy() for name, values in state.best.items()},
        mean=mean.astype(np.float32),
        scale=scale,
        rate=rate,
        aam=aam,
        about={"training": asdict(settings), "epochs": len(state.curve), "best_epoch": state.best_epoch},
        parts=tuple(parts),
    )
    return Training(network, tuple(state.curve), state.best_epoch)


def _start(
    stack: StackSettings, phones: int, outputs: int, settings: TrainingSettings, parts: Sequence[int] = ()
) -> _State:
    module = Stack(stack, phones, outputs, settings.dropout, parts)
    if settings.initial_std:
        for weights in module.parameters():
            torch.nn.init.normal_(weights, std=settings.initial_std)
    if settings.optimiser == "adam":
        optimiser = torch.optim.AdamW(
            module.parameters(),
            lr=settings.learning_rate,
            betas=(settings.momentum, 0.999),
            weight_decay=settings.weight_decay,
            fused=True,
        )
    else:
        optimiser = torch.optim.SGD(
            module.parameters(),
            lr=settings.learning_rate,
            momentum=settings.momentum,
            weight_decay=settings.weight_decay,
        )
    return _State(module, copy.deepcopy(module).eval(), optimiser, _copy(module))


def _copy(module: Stack) -> dict[str, torch.Tensor]:
    return {name: values.detach().clone() for name, values in module.state_dict().items()}


def _average(state: _State, share: float) -> None:
    # The first means would be mostly the random start: let them forget faster.
    share = min(share, state.updates / (state.updates + 9)) if share else 0.0
    with torch.no_grad():
        torch._foreach_lerp_(list(state.average.parameters()), list(state.module.parameters()), 1 - share)


def _finished(state: _State, settings: TrainingSettings) -> bool:
    epochs = len(state.curve)
    return epochs >= settings.max_epochs or epochs - state.best_epoch >= settings.patience


def _epoch(state: _State, settings: TrainingSettings, data, known, mean, scale, name: str) -> None:
    start = time.monotonic()
    number = len(state.curve) + 1
    order = batches(known[0].lengths, settings.batch, torch.randperm(len(data[0])).numpy())
    errors = 0.0
    state.module.train()
    for chosen in torch.randperm(len(order)).tolist():
        labels, lengths, targets = batch(data[0], order[chosen], mean, scale)
        error = sum_of_squared_errors(state.module(labels, lengths), targets)
        # Adam does not see the error's scale; the mean over frames makes `clip` independent of the batch.
        objective = error / lengths.sum() if settings.optimiser == "adam" else error
        state.optimiser.zero_grad()
        objective.backward()
        if settings.clip:
            torch.nn.utils.clip_grad_norm_(state.module.parameters(), settings.clip)
        state.optimiser.step()
        state.updates += 1
        _average(state, settings.averaging)
        errors += error.item()
    unit = scale**2
    row_train = errors * unit / known[0].lengths.sum()
    row_validation = validation_error(state.average, data[1], known[1].lengths, settings.batch, mean, scale) * unit
    if not (math.isfinite(row_train) and math.isfinite(row_validation)):
        raise SettingError(
            f"the training of {name} diverged in epoch {number}: its error is no longer a number. "
            f"Lower `training.learning_rate` (now {state.optimiser.param_groups[0]['lr']:g})."
        )
    if row_validation < state.best_error * (1 - settings.min_improvement):
        state.best, state.best_error, state.best_epoch = _copy(state.average), row_validation, number
        state.since_decay = 0
    else:
        state.since_decay += 1
        if state.since_decay >= settings.decay_patience:
            state.since_decay = 0
            for group in state.optimiser.param_groups:
                group["lr"] *= settings.decay
    seconds = time.monotonic() - start
    state.curve.append((number, float(row_train), float(row_validation), seconds))


def validation_error(module: Stack, examples, lengths: np.ndarray, size: int, mean: np.ndarray, scale: float) -> float:
    """E a frame (Eq. 10) of a stack on utterances, in units of the scaled targets."""
    module.eval()
    with torch.inference_mode():
        errors = [
            sum_of_squared_errors(module(labels, counts), targets).item()
            for labels, counts, targets in (
                batch(examples, numbers, mean, scale)
                for numbers in batches(lengths, max(size, 16), np.arange(len(lengths)))
            )
        ]
    return math.fsum(errors) / int(lengths.sum())
