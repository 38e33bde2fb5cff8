"""Training of one model and prediction, on arrays or on the features of a finished run."""

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from pathlib import Path

import numpy as np

from visualspeech.api.speech import named
from visualspeech.errors import DataError, SettingError
from visualspeech.features.blocks.arrays import Arrays
from visualspeech.features.blocks.base import Source
from visualspeech.features.examples import Example, Examples
from visualspeech.features.streams import Stream
from visualspeech.fields import shortened
from visualspeech.models.entries import ENTRY, family_settings
from visualspeech.models.families import FAMILIES
from visualspeech.models.inventory import needs_of_model, phones_of, predict_source
from visualspeech.models.lips import WEIGHTS, recorded_lips
from visualspeech.models.registry import expand
from visualspeech.models.rows import ModelRow
from visualspeech.models.task import Fitted, Model, Task
from visualspeech.models.training_settings import training_fields
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.sound import Sound
from visualspeech.speech.substitutes import in_phones
from visualspeech.timing import frames_in

#: Name of the input block of arrays.
INPUTS = "inputs"


class RunExamples(Examples):
    """Utterances of a finished run as a model reads them (:meth:`visualspeech.System.examples`).

    Parameters
    ----------
    blocks, targets, ids : as of :class:`~visualspeech.features.examples.Examples`
    fitted : the input blocks by name, in the order of the streams
    coding : digest of the visual coding
    regions : region of the face -> columns of the targets
    alignments : table files of the alignment
    """

    def __init__(self, blocks, targets, ids, fitted: Mapping, coding: str, regions: Mapping, alignments) -> None:
        super().__init__(blocks, targets, ids)
        self.targets, self.fitted, self.coding = targets, dict(fitted), coding
        self.regions, self.alignments = regions, tuple(alignments)


class ArrayExamples(Sequence):
    """Utterances that are given as arrays.

    Parameters
    ----------
    pairs : inputs (T, D) real-valued or (T, C) whole numbers, and targets (T, N), of each utterance
    rate : frame rate in Hz
    name : training or validation, for messages

    Raises
    ------
    DataError
        An array has another form than the others, or a value that is not finite; the message names the utterance.
    """

    def __init__(self, pairs: Sequence, rate: float, name: str) -> None:
        self._examples = [_example(pair, rate, f"{name} utterance {number}") for number, pair in enumerate(pairs)]
        if not self._examples:
            raise DataError(f"there is no {name} utterance; give at least one pair of inputs and targets.")
        first = _form(self._examples[0])
        for number, one in enumerate(self._examples):
            if _form(one) != first:
                raise DataError(
                    f"{name} utterance {number} has {_form(one)}, utterance 0 {first}; give all the same columns."
                )

    def __len__(self) -> int:
        return len(self._examples)

    def __getitem__(self, number: int) -> Example:
        return self._examples[number]


def _example(pair, rate: float, where: str) -> Example:
    try:
        inputs, targets = pair
    except (TypeError, ValueError):
        raise DataError(f"{where}: give a pair of arrays, inputs (T, D) and targets (T, N).") from None
    targets = np.asarray(targets)
    if targets.ndim != 2 or targets.dtype.kind not in "fiu" or not np.isfinite(targets).all():
        raise DataError(f"{where}: targets are finite numbers of shape (T, N), not {targets.dtype} {targets.shape}.")
    stream = _stream(inputs, where)
    if len(stream) != len(targets):
        raise DataError(f"{where} has {len(stream)} frames of inputs and {len(targets)} frames of targets.")
    return Example((stream,), targets.astype(np.float32), float(rate))


def _stream(inputs, where: str) -> Stream:
    values = np.asarray(inputs)
    if values.ndim == 1:
        values = values[:, None]
    if values.ndim != 2 or not values.size or values.dtype.kind not in "fiub":
        raise DataError(f"{where}: inputs are numbers of shape (T, D), not {values.dtype} {values.shape}.")
    if values.dtype.kind == "f":
        if not np.isfinite(values).all():
            raise DataError(f"{where}: an input is no finite number.")
        return Stream(values=values.astype(np.float32))
    if values.min() < 0:
        raise DataError(f"{where}: whole numbers are classes, from 0 on; give real-valued inputs as floats.")
    return Stream(index=values.astype(np.int64))


def _form(example: Example) -> str:
    stream = example.streams[0]
    kind, values = ("classes", stream.index) if stream.values is None else ("real-valued inputs", stream.values)
    return f"{values.shape[1]} columns of {kind} and {example.target.shape[1]} of targets"


def train(
    training: Sequence,
    validation: Sequence,
    family: str = "stack",
    *,
    rate: float = 25.0,
    reads: Sequence | None = None,
    seed: int = 1,
    **settings,
) -> Fitted:
    """Train one model.

    ``fitted.model`` predicts (:func:`predict`) and is saved by ``fitted.model.save(path)``; ``fitted.curve`` is a data
    frame of its training.

    Parameters
    ----------
    training, validation : pairs of arrays, one pair per utterance: inputs (T, D), real-valued, or (T, C), whole numbers
        of classes that the model sees as one-hot vectors; and targets (T, N). Or utterances of a run
        (:meth:`visualspeech.System.examples`). Training ends by the validation utterances
    family : of models, ``stack`` (``letters="FBB"``, ``nodes=64``), ``dnn``, ``joint``, ``hmm``, ``lookup`` or ``mean``
    rate : frame rate of arrays in Hz; a run has its own
    reads : input blocks, with windows, as in a system's settings: ``[{"inputs": 0.1}]``; default: all, without windows
    seed : of initial weights, order and dropout
    settings : of the family and of training, by their names in ``config/README.md`` (``max_epochs=20``)

    Raises
    ------
    SettingError
        A setting is unknown or out of range, or the family cannot be trained on these data.
    DataError
        Arrays do not fit each other.
    """
    if isinstance(training, RunExamples) != isinstance(validation, RunExamples):
        raise DataError("training and validation must both be arrays, or both utterances of a run.")
    if isinstance(training, RunExamples):
        if list(training.fitted) != list(validation.fitted) or training.coding != validation.coding:
            raise DataError("training and validation read different input blocks, or are of different systems.")
        blocks, coding, regions = training.fitted, training.coding, training.regions
    else:
        if not (isinstance(rate, int | float) and 0 < rate <= 10_000):
            raise SettingError(f"rate={shortened(rate)}: give the frame rate of the arrays in Hz, above 0.")
        training, validation = (
            ArrayExamples(given, rate, name) for given, name in ((training, "training"), (validation, "validation"))
        )
        if _form(training[0]) != _form(validation[0]):
            raise DataError(f"validation has {_form(validation[0])}, training {_form(training[0])}.")
        blocks, coding, regions = {INPUTS: _block([*training, *validation])}, "", {}
    row = _row(family, list(blocks) if reads is None else list(reads), blocks, seed, settings)
    if list(row.reads) not in ([], list(blocks)):
        raise SettingError(f"`reads` must name all input blocks of the utterances in their order: {', '.join(blocks)}.")
    given = training, validation
    if not row.reads:
        blocks, given = {}, tuple(map(_TargetsAlone, given))
    lips = None
    if any(row.training.get(name) for name in WEIGHTS):
        if not isinstance(training, RunExamples):
            raise SettingError(f"{' and '.join(WEIGHTS)} need the alignment and the lips of a run; leave them out.")
        lips = recorded_lips(row, training.ids, training.targets, training.alignments)
    task = Task(row, blocks, *given, coding, lips=lips, regions=regions)
    return import_module(FAMILIES[row.family].module).fit(task)


class _TargetsAlone(Sequence):
    """Utterances for a model that reads no input; they are read as they are asked for."""

    def __init__(self, examples: Sequence[Example]) -> None:
        self._examples = examples

    def __len__(self) -> int:
        return len(self._examples)

    def __getitem__(self, number: int) -> Example:
        return self._examples[number]._replace(streams=())


def _block(examples: Sequence[Example]) -> Arrays:
    """The block of the inputs: numbers of columns, and of the classes that occur."""
    streams = [one.streams[0] for one in examples]
    if streams[0].values is not None:
        return Arrays(streams[0].values.shape[1])
    return Arrays(sizes=tuple(int(size) for size in 1 + np.max([one.index.max(axis=0) for one in streams], axis=0)))


def _row(family: str, reads: list, blocks: Mapping, seed: int, settings: Mapping) -> ModelRow:
    """The model that is asked for, as a system's settings would ask for it."""
    reserved = sorted(set(settings) & set(ENTRY))
    if reserved:
        raise SettingError(f"`{reserved[0]}` is no setting of a model that is trained by itself; leave it out.")
    of_training = {name: value for name, value in settings.items() if name in training_fields()}
    entry = {"family": family, **{name: value for name, value in settings.items() if name not in of_training}}
    known = FAMILIES.get(family) if isinstance(family, str) else None
    if known is not None and (known.made_of or not known.module):
        raise SettingError(f"models of the family {family} are made of others; train it in a run.")
    if known is None or known.trained:
        entry["training"] = of_training
    elif of_training:
        named = next(iter(of_training))
        raise SettingError(f"`{named}` is for networks; the family {family} is trained in another way.")
    elif known.made_from(family_settings(known, settings, "models.model", {})):
        raise SettingError(f"such a model of the family {family} is made from another; train it in a run.")
    if known is None or known.reads[1] != 0:
        entry["reads"] = reads
    rows = [row for row in expand({"model": entry}, list(blocks), {}, [seed], "models") if row.group == "model"]
    if len(rows) > 1:
        raise SettingError("a list of values asks for several models; train() trains one. Call it once per value.")
    for name in rows[0].reads:
        if blocks[name].layout.segmental != known.segmental:
            needed = "segments, for example of the input block phone_track" if known.segmental else "frames"
            raise SettingError(f"the family {family} reads {needed}; the input block `{name}` has others.")
    return rows[0]


def predict(model: Model, inputs, *, sound: str | Path | np.ndarray | Sound | None = None) -> np.ndarray:
    """Parameters (T, N) float32 of one utterance, at ``model.rate``.

    Parameters
    ----------
    model : from :func:`train`, :func:`visualspeech.load_model` or :meth:`visualspeech.System.model`
    inputs : what the model reads: an :class:`~visualspeech.Alignment` (of :func:`visualspeech.align`); for a model that
        was trained on arrays, such an array; or an utterance of a run (:meth:`visualspeech.System.examples`); None for
        a model that reads sound alone
    sound : for a model that reads sound: path of a recording, or samples (n,) int16 or in [-1, 1], mono, 16 kHz

    Raises
    ------
    DataError
        The model reads something else.
    RejectedUtterance
        The recording cannot be read.
    """
    needs = needs_of_model(model)
    if isinstance(inputs, Example):
        return model.predict(inputs.streams if model.blocks else (), len(inputs.target), inputs.rate)
    if isinstance(inputs, np.ndarray | list):
        if not model.blocks:
            return model.predict((), len(inputs), model.rate)
        if [block.kind for block in model.blocks.values()] != ["arrays"]:
            raise DataError(f"the model reads {_what(needs)}, no array; see the documentation of predict().")
        stream = _stream(inputs, "the utterance")
        layout = next(iter(model.blocks.values())).layout
        own = (0, layout.dimension) if stream.index is None else (len(layout.sizes), 0)
        given = (0, stream.values.shape[1]) if stream.index is None else (stream.index.shape[1], 0)
        if own != given or layout.sizes and (stream.index.max(axis=0) >= np.array(layout.sizes)).any():
            raise DataError(
                f"the array {np.shape(inputs)} is not what the model was trained on: {layout.dimension} real-valued "
                f"columns, {len(layout.sizes)} of classes{f' {layout.sizes}' * bool(layout.sizes)}."
            )
        return model.predict((stream,), len(stream), model.rate)
    if "faces" in needs:
        raise DataError("the model reads dynamic visemes of the recording that it predicts; new speech has none.")
    if isinstance(inputs, Alignment):
        heard = _sound(sound) if "audio" in needs else None
        known = in_phones(inputs, phones_of(model))[0]
        return predict_source(model, Source(frames_in(inputs.duration, model.rate), model.rate, known, heard))
    if inputs is None and needs == {"audio"}:
        heard = _sound(sound)
        return predict_source(model, Source(max(1, frames_in(heard.seconds, model.rate)), model.rate, sound=heard))
    raise DataError(
        f"the model reads {_what(needs)}; give an alignment as align() returns it, not {type(inputs).__name__}."
    )


def _what(needs: frozenset[str]) -> str:
    names = {"text": "phones", "audio": "sound", "faces": "recorded faces"}
    return " and ".join(names[one] for one in sorted(needs, reverse=True)) or "nothing"


def _sound(sound) -> Sound:
    if isinstance(sound, Sound):
        return sound
    if sound is None:
        raise DataError("the model reads sound; give it with sound=, a path or samples at 16 kHz.")
    from visualspeech.speech.spoken import spooled

    if isinstance(sound, str | Path):
        with named(sound):
            return spooled(sound)
    samples = np.asarray(sound)
    if samples.ndim != 1 or not (samples.dtype == np.int16 or samples.dtype.kind == "f"):
        raise DataError(
            f"samples are (n,) int16, or floats in [-1, 1], mono, 16 kHz; not {samples.dtype} {samples.shape}."
        )
    return Sound(samples) if samples.dtype == np.int16 else Sound.of(samples, 16_000)


def predictions(model: Model, examples: RunExamples) -> Iterator[tuple[str, np.ndarray]]:
    """Id and predicted parameters (T, N) of each utterance of a run."""
    for number, name in enumerate(examples.ids):
        yield name, predict(model, examples[number])
