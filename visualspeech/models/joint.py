"""Networks that predict the regions of a face jointly or separately (Sadoughi and Busso 2017, section 4).

A joint network minimises the objective over the outputs of all regions: of ``ccc`` and ``mse``, the mean over all
outputs, in which a region counts by its number of outputs. The paper gives no weights of its tasks, and says that
Joint-1 is the same as a network that predicts all outputs at once, which this mean makes it. Separate networks are
trained one after the other, each with its own scaling, early stopping, learning-rate decay and gradient clipping.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.features.examples import Example
from visualspeech.features.streams import Layout
from visualspeech.jobs import log
from visualspeech.models.batches import Scaling
from visualspeech.models.fitting import fit_network
from visualspeech.models.joint_network import Joint, output_columns, stored, weight_shapes
from visualspeech.models.joint_settings import JointSettings, check_regions
from visualspeech.models.network import Network, layouts_of, restore_network
from visualspeech.models.objectives import objective_of
from visualspeech.models.task import Fitted, Task
from visualspeech.models.training_settings import TrainingSettings, training_settings
from visualspeech.provenance import code_digest

FAMILY = "joint"


def fit(task: Task) -> Fitted:
    """Train the network of a row; one per region, one after the other, if they share no layer.

    The learning curve of separate networks has the objective over the outputs of all regions; a region whose training
    has ended counts with its best epoch from then on. ``validation_<region>`` is that of each.

    Raises
    ------
    DataError, SettingError
        As :func:`visualspeech.models.fitting.fit_network`.
    SettingError
        The visual coding has no regions, or separate networks are to weight lips, whose points are of several regions.
    """
    settings = JointSettings(**task.row.settings)
    training = training_settings(task.row.training, seed=task.row.seed)
    key = f"models.{task.row.group or task.row.name}"
    if not task.regions:
        raise SettingError(
            f"`{key}.family: {FAMILY}` predicts regions of the face, and the visual coding of this system names none. "
            "Choose a `coding` of the kind markers, or another family."
        )
    regions = {name: [int(column) for column in columns] for name, columns in sorted(task.regions.items())}
    if len(task.training):
        _check(regions, task.training[0].target.shape[1])
    if not settings.separate or len(regions) == 1:
        return _searched(task, settings, training, regions)
    if training.closure_weight or training.open_weight:
        raise SettingError(f"`{key}` has networks per region, for which `closure_weight` and `open_weight` must be 0.")
    parts = []
    for number, (name, columns) in enumerate(regions.items()):
        own = replace(
            task,
            row=replace(task.row, name=f"{task.row.name} ({name})"),
            training=_Columns(task.training, columns),
            validation=_Columns(task.validation, columns),
            checkpoint=_numbered(task.checkpoint, number),
            lips=None,
        )
        parts.append(_searched(own, settings, training, {name: list(range(len(columns)))}))
    return _together(parts, regions, settings, training)


def _check(regions: Mapping[str, Sequence[int]], outputs: int) -> None:
    try:
        check_regions(regions, outputs)
    except ValueError as error:
        raise DataError(f"the visual coding does not fit its parameters: {error}. Delete it and run again.") from error


class _Columns(Sequence):
    """Utterances with some columns of their targets."""

    def __init__(self, examples: Sequence[Example], columns: Sequence[int]) -> None:
        self.examples, self.columns = examples, list(columns)

    def __len__(self) -> int:
        return len(self.examples)

    def __getitem__(self, number: int) -> Example:
        example = self.examples[number]
        return example._replace(target=np.ascontiguousarray(example.target[:, self.columns]))


def _numbered(checkpoint: Path | None, number: int) -> Path | None:
    """File for the state of one of several trainings, ``checkpoint-0.safetensors`` beside ``checkpoint.safetensors``.

    The state of a finished one is kept until all are: a killed job does not train it again.
    """
    return checkpoint and checkpoint.with_name(f"{checkpoint.stem}-{number}{checkpoint.suffix}")


def _searched(
    task: Task, settings: JointSettings, training: TrainingSettings, regions: Mapping[str, Sequence[int]]
) -> Fitted:
    """The network with the lowest validation error among those of all learning rates of the search, if there is one."""
    if not settings.learning_rates:
        return _fitted(task, settings, training, regions)
    found, failed = {}, None
    for number, rate in enumerate(settings.learning_rates):
        own = replace(
            task,
            row=replace(task.row, name=f"{task.row.name} (learning rate {rate:g})"),
            checkpoint=_numbered(task.checkpoint, number),
        )
        try:
            found[rate] = _fitted(own, settings, replace(training, learning_rate=rate), regions)
        except SettingError as error:  # it diverged
            log.warning("%s", error)
            failed = error
    if not found:
        raise failed
    errors = {rate: float(one.curve["validation"].min()) for rate, one in found.items()}
    best = min(errors, key=errors.get)
    log.info("%s: learning rate %g has the lowest validation error, %.5g", task.row.name, best, errors[best])
    model = found[best].model
    searched = {f"{rate:g}": error for rate, error in errors.items()}
    return replace(found[best], model=replace(model, about={**model.about, "learning_rates": searched}))


def _fitted(
    task: Task, settings: JointSettings, training: TrainingSettings, regions: Mapping[str, Sequence[int]]
) -> Fitted:
    """One trained network; its file names the columns of the regions."""

    def build(layouts: Sequence[Layout], outputs: int) -> Joint:
        return Joint(settings, layouts, output_columns(regions, settings, outputs), training.dropout)

    fitted = fit_network(task, FAMILY, settings, training, build, [regions, code_digest(__file__)])
    return replace(fitted, model=_with_regions(fitted.model, regions))


def _with_regions(model: Network, regions: Mapping[str, Sequence[int]]) -> Network:
    return replace(model, settings={**model.settings, "regions": dict(regions)})


def _together(
    parts: Sequence[Fitted],
    regions: Mapping[str, Sequence[int]],
    settings: JointSettings,
    training: TrainingSettings,
) -> Fitted:
    """One network of those of all regions."""
    models = [part.model for part in parts]
    first, count = models[0], sum(len(one.scaling.mean) for one in models)
    columns = output_columns(regions, settings, count)
    module = Joint(settings, layouts_of(first.blocks, first.windows, first.rate), columns)
    module.load_state_dict(
        {
            name.replace("regions.0.", f"regions.{number}.", 1): values
            for number, one in enumerate(models)
            for name, values in one.module.state_dict().items()
        }
    )

    def joined(values: Sequence[np.ndarray]) -> np.ndarray:
        whole = np.zeros(count, values[0].dtype)
        for own, numbers in zip(values, columns.values(), strict=True):
            whole[numbers] = own
        return whole

    return Fitted(
        replace(
            _with_regions(first, regions),
            module=module.eval(),
            scaling=Scaling(
                joined([one.scaling.mean for one in models]), joined([one.scaling.scale for one in models])
            ),
            mlpg=first.mlpg and replace(first.mlpg, variance=joined([one.mlpg.variance for one in models])),
            about={name: dict(one.about) for name, one in zip(regions, models, strict=True)},
        ),
        _common_curve([part.curve for part in parts], regions, objective_of(training).additive),
    )


def _common_curve(curves: Sequence, regions: Mapping[str, Sequence[int]], additive: bool):
    """The learning curve over the outputs of all regions, as :func:`fit` says."""
    import pandas

    sizes = np.array([len(columns) for columns in regions.values()], float)
    shares = np.ones(len(sizes)) if additive else sizes / sizes.sum()
    epochs = np.arange(1, max(map(len, curves)) + 1)
    table = {"epoch": epochs}

    def held(curve, name: str) -> np.ndarray:
        best = curve[name].iloc[int(curve["validation"].to_numpy().argmin())]
        return np.concatenate([curve[name].to_numpy(), np.full(len(epochs) - len(curve), best)])

    for name in ("train", "validation"):
        table[name] = shares @ np.stack([held(curve, name) for curve in curves])
    seconds = [np.pad(curve["seconds"].to_numpy(), (0, len(epochs) - len(curve))) for curve in curves]
    table["seconds"] = np.sum(seconds, axis=0)
    table |= {f"validation_{name}": held(one, "validation") for name, one in zip(regions, curves, strict=True)}
    return pandas.DataFrame(table)


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Network:
    """The network in a file's content; raises as :func:`visualspeech.models.network.restore_network`."""

    def build(own: Mapping, layouts: Sequence[Layout], outputs: int) -> Joint:
        made, regions = stored(own, outputs)
        return Joint(made, layouts, regions)

    return restore_network(arrays, settings, path, FAMILY, build, weight_shapes)
