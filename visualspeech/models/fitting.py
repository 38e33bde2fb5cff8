"""How every family of networks is trained: what it learns, and the network that comes of it."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import partial

import torch

from visualspeech.errors import SettingError
from visualspeech.features.streams import Layout
from visualspeech.models.network import Network, layouts_of
from visualspeech.models.task import Fitted, Task, check_examples
from visualspeech.models.training import train
from visualspeech.models.training_settings import TrainingSettings
from visualspeech.models.trajectory.generation import MAX_STEP, step_of
from visualspeech.models.trajectory.mlpg import Mlpg, Observed, error_variance, target_variance
from visualspeech.models.trajectory.settings import TrajectorySettings
from visualspeech.provenance import code_digest


def fit_network(
    task: Task,
    family: str,
    settings: TrajectorySettings,
    training: TrainingSettings,
    build: Callable[[Sequence[Layout], int], torch.nn.Module],
    identity: Sequence,
) -> Fitted:
    """Train a network of the family that the settings belong to, with static or with all three kinds of outputs.

    Parameters
    ----------
    task, identity : as for :func:`visualspeech.models.training.train`
    settings : of the module and of its trajectory
    build : (columns and windows of the input streams, number of outputs) -> module

    Raises
    ------
    DataError
        As :func:`visualspeech.models.training.train`.
    SettingError
        As there, or the windows of the deltas are too wide, or an input has no row per frame.
    """
    check_examples(task.training, task.blocks, "training")
    rate, generated = task.training[0].rate, settings.trajectory == "mlpg"
    given = task
    if generated:
        if step_of(settings.delta_step, rate) > MAX_STEP:
            raise SettingError(
                f"`models.{task.row.group or task.row.name}.delta_step: {settings.delta_step:g}` must be at most "
                f"{MAX_STEP / rate:g} at {rate:g} Hz: {MAX_STEP} frames."
            )
        training_examples, validation = (
            Observed(part, settings.delta_step) for part in (task.training, task.validation)
        )
        given = replace(task, training=training_examples, validation=validation)
    layouts = layouts_of(task.blocks, task.row.windows, rate)
    known = [asdict(settings), list(map(asdict, layouts)), *identity, code_digest(__file__)]
    trained = train(partial(build, layouts), given, training, known)
    network = Network(
        family=family,
        settings=asdict(settings),
        module=trained.module,
        scaling=trained.scaling,
        blocks=task.blocks,
        rate=rate,
        coding=task.coding,
        windows=task.row.windows,
        about={"training": asdict(training), "epochs": len(trained.curve), "best_epoch": trained.best_epoch},
    )
    return Fitted(_generating(network, given.training, settings) if generated else network, trained.curve_table())


def _generating(network: Network, training: Observed, settings: TrajectorySettings) -> Network:
    """The network with the trajectory of its outputs; its variances are learned from training utterances."""
    utterances = (training[number] for number in range(len(training)))
    if settings.trajectory_variance == "targets":
        variance = target_variance(one.target for one in utterances)
    else:
        variance = error_variance(network.observed(one.streams) - one.target for one in utterances)
    return replace(network, mlpg=Mlpg(variance, settings.delta_step))
