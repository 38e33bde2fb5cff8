"""The training loop of every network: any module, batches and objective; early stopping, checkpoint and resume."""

import copy
import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import torch

from visualspeech.errors import SettingError
from visualspeech.features.examples import Example
from visualspeech.jobs import log
from visualspeech.models.batches import Batch, Content, Scaling, batch, batches, content
from visualspeech.models.checkpoints import read_checkpoint, write_checkpoint
from visualspeech.models.frames import FrameBatch, FrameStore
from visualspeech.models.lip_loss import LipLoss
from visualspeech.models.objectives import Objective, objective_of
from visualspeech.models.task import Task
from visualspeech.models.training_settings import FRAME_BATCHERS, TrainingSettings
from visualspeech.provenance import code_digest, digest

PROGRESS_SECONDS = 3.0


@contextmanager
def one_thread():
    """Let torch compute on one thread: small networks run faster so, and sums do not depend on the machine's cores."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


@dataclass(frozen=True)
class Trained:
    """A finished training.

    Parameters
    ----------
    module : with the weights of the best epoch
    scaling : from the module's outputs to targets
    curve : a row an epoch: (epoch, train, validation, seconds); the objective in units of the targets (``sse``: E of
        Fan 2015, Eq. 10, per frame); ``train`` is taken during the epoch (with dropout), ``validation`` after it
    best_epoch : the epoch whose weights are kept
    """

    module: torch.nn.Module
    scaling: Scaling
    curve: tuple[tuple[int, float, float, float], ...]
    best_epoch: int

    def curve_table(self):
        """The learning curve as a data frame: epoch, train, validation, seconds."""
        import pandas

        return pandas.DataFrame(list(self.curve), columns=["epoch", "train", "validation", "seconds"])


@dataclass
class _State:
    """All that an interrupted training needs to continue as if nothing had happened."""

    module: torch.nn.Module
    average: torch.nn.Module
    optimiser: torch.optim.Optimizer
    best: dict[str, torch.Tensor]
    best_error: float = math.inf
    best_epoch: int = 0
    improved_error: float = math.inf
    improved_epoch: int = 0
    since_decay: int = 0
    updates: int = 0
    curve: list[tuple[int, float, float, float]] = field(default_factory=list)


@dataclass(frozen=True)
class _Run:
    """What stays the same over the epochs of a training."""

    name: str
    settings: TrainingSettings
    training: Sequence[Example]
    validation: Sequence[Example]
    known: tuple[Content, Content]
    scaling: Scaling
    lips: LipLoss | None
    store: FrameStore | None

    def batches(self) -> Iterator[tuple[Batch | FrameBatch, np.ndarray]]:
        """The batches of an epoch in random order, each with the numbers of its utterances, none for single frames."""
        if self.store is not None:
            for given in self.store.batches(self.settings.batch_frames):
                yield given, np.zeros(0, np.int64)
            return
        order = batches(self.known[0].lengths, self.settings, torch.randperm(len(self.training)).numpy())
        for chosen in torch.randperm(len(order)).tolist():
            yield batch(self.training, order[chosen], self.scaling), order[chosen]

    @property
    def objective(self) -> Objective:
        return objective_of(self.settings)


def train(
    build: Callable[[int], torch.nn.Module],
    task: Task,
    settings: TrainingSettings,
    identity: Sequence,
    checkpoint_seconds: float = 10.0,
) -> Trained:
    """Train a module on utterances with early stopping by the validation error; the weights of the best epoch are kept.

    Runs on one thread. The same data and settings give the same bytes, interrupted or not.

    Parameters
    ----------
    build : number N of outputs -> module, whose ``forward`` takes a :class:`~visualspeech.models.batches.Batch` and
        returns (B, T, N), zero in padded frames, or with a batcher of single frames a
        :class:`~visualspeech.models.frames.FrameBatch` too; called once, after the seed is set
    task : utterances, blocks, and the file that the state is kept in after an epoch, at most every
        ``checkpoint_seconds``. If it is there and was made by this code from these settings and data, training resumes
        from it. The caller removes it once the model is saved
    identity : what makes the module what it is beside settings and data: its own settings and the digest of its code

    Raises
    ------
    DataError
        There is nothing to learn from, or the data does not fit the blocks.
    SettingError
        The error is no longer a finite number.
    """
    known = tuple(
        content(examples, task.blocks, name)
        for examples, name in ((task.training, "training"), (task.validation, "validation"))
    )
    scaling = Scaling.of(known[0], settings.scaling)
    lips, layouts, store = LipLoss.of(task.lips, scaling, settings), [one.layout for one in task.blocks.values()], None
    if settings.batcher in FRAME_BATCHERS:
        store = FrameStore.of(task.training, known[0].lengths, layouts, scaling.mean, scaling.scale)
    run = _Run(task.row.name, settings, task.training, task.validation, known, scaling, lips, store)
    whole = digest(
        [
            list(identity),
            asdict(settings),
            list(map(asdict, layouts)),
            [part.digest for part in known],
            task.lips.digest if lips else "",
            torch.__version__,
            code_digest(__file__),
        ]
    )
    with one_thread(), torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        state = _start(build(len(scaling.mean)), settings)
        if task.checkpoint is not None and read_checkpoint(task.checkpoint, whole, state):
            log.info("%s: resumed after epoch %d", run.name, len(state.curve))
        saved = reported = time.monotonic()
        while not _finished(state, settings):
            _epoch(state, run)
            if time.monotonic() - reported >= PROGRESS_SECONDS or _finished(state, settings):
                reported = time.monotonic()
                log.info("%s: epoch %d of at most %d, %s", run.name, len(state.curve), settings.max_epochs, _row(state))
            if task.checkpoint is not None and time.monotonic() - saved >= checkpoint_seconds:
                write_checkpoint(task.checkpoint, whole, state)
                saved = time.monotonic()
        if task.checkpoint is not None:
            write_checkpoint(task.checkpoint, whole, state)
    state.average.load_state_dict(state.best)
    return Trained(state.average.eval(), scaling, tuple(state.curve), state.best_epoch)


def remove_checkpoint(path: Path | None) -> None:
    """Remove the checkpoint of a training whose model is saved."""
    if path is not None:
        path.unlink(missing_ok=True)


def _row(state: _State) -> str:
    _, error, validation, seconds = state.curve[-1]
    best = f"best so far in epoch {state.best_epoch}"
    return f"training error {error:.5g}, validation error {validation:.5g} ({best}), {seconds:.1f} s per epoch"


def _start(module: torch.nn.Module, settings: TrainingSettings) -> _State:
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


def _copy(module: torch.nn.Module) -> dict[str, torch.Tensor]:
    return {name: values.detach().clone() for name, values in module.state_dict().items()}


def _average(state: _State, decay: float) -> None:
    # The first averages would be mostly the random start: let them forget faster.
    decay = min(decay, state.updates / (state.updates + 9)) if decay else 0.0
    with torch.no_grad():
        torch._foreach_lerp_(list(state.average.parameters()), list(state.module.parameters()), 1 - decay)


def _finished(state: _State, settings: TrainingSettings) -> bool:
    epochs = len(state.curve)
    return epochs >= settings.max_epochs or epochs - state.improved_epoch >= settings.patience


def _epoch(state: _State, run: _Run) -> None:
    start = time.monotonic()
    number, settings = len(state.curve) + 1, run.settings
    unit = run.scaling.unit(run.objective.power)
    error = run.objective.value(_updates(state, run), int(run.known[0].lengths.sum())) * unit
    validation = validation_error(state.average, run.validation, run.known[1].lengths, settings, run.scaling) * unit
    if not (math.isfinite(error) and math.isfinite(validation)):
        raise SettingError(
            f"the training of {run.name} diverged in epoch {number}: its error is not a finite number. "
            f"Lower `training.learning_rate` (now {state.optimiser.param_groups[0]['lr']:g})."
        )
    if validation < state.best_error or not state.best_epoch:
        state.best, state.best_error, state.best_epoch = _copy(state.average), validation, number
    # Of the value's size, whatever its sign.
    margin = settings.min_improvement * abs(state.improved_error)
    if not state.improved_epoch or validation < state.improved_error - margin:
        state.improved_error, state.improved_epoch, state.since_decay = validation, number, 0
    else:
        state.since_decay += 1
        if state.since_decay >= settings.lr_patience:
            state.since_decay = 0
            for group in state.optimiser.param_groups:
                group["lr"] *= settings.lr_decay
    state.curve.append((number, float(error), float(validation), time.monotonic() - start))


def _updates(state: _State, run: _Run) -> np.ndarray:
    """One update a batch of the training utterances, in random order; the sums of the objective's statistics."""
    settings, objective, sums = run.settings, run.objective, 0.0
    state.module.train()
    for given, numbers in run.batches():
        predicted = state.module(given)
        loss = objective.loss(predicted, given.targets, given.lengths)
        # The learning curve is that of the objective.
        minimised = loss if run.lips is None else loss + run.lips(predicted, numbers)
        # Adam does not see the loss's scale; the mean over frames makes `max_grad_norm` independent of the batch.
        per_frame = objective.additive and settings.optimiser == "adam"
        state.optimiser.zero_grad()
        (minimised / given.lengths.sum() if per_frame else minimised).backward()
        if settings.max_grad_norm:
            torch.nn.utils.clip_grad_norm_(state.module.parameters(), settings.max_grad_norm)
        state.optimiser.step()
        state.updates += 1
        _average(state, settings.ema_decay)
        sums = sums + objective.statistics(loss.detach(), predicted.detach(), given.targets, given.lengths)
    return sums


def validation_error(
    module: torch.nn.Module,
    examples: Sequence[Example],
    lengths: np.ndarray,
    settings: TrainingSettings,
    scaling: Scaling,
) -> float:
    """The objective of a module on utterances, in units of the scaled targets."""
    objective = objective_of(settings)
    module.eval()
    rows = []
    with torch.inference_mode():
        for numbers in batches(lengths, settings, np.arange(len(lengths)), least=16):
            given: Batch = batch(examples, numbers, scaling)
            predicted = module(given)
            loss = objective.loss(predicted, given.targets, given.lengths)
            rows.append(objective.statistics(loss, predicted, given.targets, given.lengths))
    sums = np.array([math.fsum(column) for column in zip(*rows, strict=True)])
    return objective.value(sums, int(lengths.sum()))
