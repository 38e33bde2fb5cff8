"""Global-variance compensation: the predictions of a finished model with excursions as large as the recorded ones.

Models that minimise a squared error predict less variance than was recorded, the less the less they know (Toda and
Tokuda 2007 call the variance of an utterance its global variance). Each parameter's excursion from the mean of its
utterance is multiplied by (recorded / predicted standard deviation) ^ strength. This gives back articulation and costs
squared error.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.fields import restored
from visualspeech.models.combined_settings import GvCompensationSettings
from visualspeech.models.members import MEMBERS, Member, pack, predictions, read_member, unpack, without_members
from visualspeech.models.task import Fitted, Task, check_examples
from visualspeech.storage.layouts import Array, FileLayout
from visualspeech.storage.models import check_model, write_model

FAMILY = "gv_compensation"
_LEAST = 1e-3  # predicted over recorded deviation below which a parameter counts as not predicted and is left alone


@dataclass(frozen=True)
class GvCompensation:
    """A model whose excursions are made larger.

    Parameters
    ----------
    member : the model
    factor : (N,) on the excursion of each parameter
    settings : what the factors were made with
    """

    member: Member
    factor: np.ndarray
    settings: GvCompensationSettings

    @property
    def blocks(self) -> Mapping[str, Block]:
        """The input blocks that the model reads, by name."""
        return self.member.model.blocks

    @property
    def rate(self) -> float:
        """Frame rate in Hz."""
        return self.member.model.rate

    @property
    def coding(self) -> str:
        """Digest of the visual coding whose parameters are predicted."""
        return self.member.model.coding

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return self.member.model.outputs

    def predict(self, streams: Sequence[Stream], frames: int, rate: float) -> np.ndarray:
        """Parameters (frames, N) float32 of one utterance at ``rate`` Hz; raises as the model's ``predict``."""
        (predicted,) = predictions([self.member.model], self.blocks, streams, frames, rate)
        mean = predicted.mean(axis=0, dtype=np.float64)
        return (mean + self.factor * (predicted - mean)).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write it with its model as one safetensors file."""
        arrays, members = pack([self.member])
        settings = {"strength": self.settings.strength}
        content = {"kind": "model", "family": FAMILY, "settings": settings, "members": members}
        write_model(path, {"factor": self.factor.astype(np.float32), **arrays}, content)


def fit(task: Task) -> Fitted:
    """The compensation of the model that a row is made from.

    Both deviations are taken over the training utterances, as all that is learned. A model that knows them by heart
    predicts more variance of them than of new speech, so that its factors are too small; networks that are stopped
    early and HMMs do not.

    Raises
    ------
    DataError
        There is no model or no training utterance, or the model reads other input blocks than the row.
    StorageError
        The file of the model is damaged.
    """
    import pandas

    if len(task.parents) != 1:
        raise DataError(f"`models.{task.row.group}.from` names no model.")
    settings, member = GvCompensationSettings(**task.row.settings), read_member(task.parents[0])
    model = member.model
    if list(model.blocks) != list(task.blocks):
        raise DataError(
            f"the model of `models.{task.row.group}` reads {', '.join(model.blocks)}, not {', '.join(task.blocks)}."
        )
    check_examples(task.training, task.blocks, "training")
    recorded = within_deviation(one.target for one in _each(task.training))
    predicted = within_deviation(model.predict(one.streams, len(one.target), one.rate) for one in _each(task.training))
    factor = compensation(recorded, predicted, settings.strength).astype(np.float32)
    figures = {"deviation_ratio": np.sqrt(np.square(predicted).sum() / max(np.square(recorded).sum(), 1e-300))}
    figures |= {"mean_factor": factor.mean(), "largest_factor": factor.max()}
    table = pandas.DataFrame({"figure": list(figures), "value": list(figures.values())})
    return Fitted(GvCompensation(member, factor, settings), table)


def _each(examples: Sequence[Example]) -> Iterator[Example]:
    return (examples[number] for number in range(len(examples)))


def within_deviation(utterances: Iterable[np.ndarray]) -> np.ndarray:
    """Standard deviation (N,) of each parameter about the mean of its utterance, over all frames of (T, N) each."""
    squares, frames = 0.0, 0
    for values in utterances:
        values = np.asarray(values, np.float64)
        squares, frames = squares + np.square(values - values.mean(axis=0)).sum(axis=0), frames + len(values)
    return np.sqrt(squares / frames)


def compensation(recorded: np.ndarray, predicted: np.ndarray, strength: float) -> np.ndarray:
    """Factors (N,) on the excursions, of deviations (N,); 1 for a parameter that is hardly predicted at all."""
    known = predicted > _LEAST * recorded
    return np.divide(recorded, predicted, out=np.ones_like(recorded), where=known) ** strength


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> GvCompensation:
    """The compensation in a file's content.

    Raises
    ------
    StorageError
        As :func:`visualspeech.storage.models.check_model` and :func:`visualspeech.models.members.unpack`, or there is
        not one factor per parameter.
    """
    own = without_members(arrays)
    check_model(own, settings, path, "global-variance compensation", ["model"], LAYOUT, FAMILY)
    (member,) = unpack(arrays, settings["members"], path)
    if len(own["factor"]) != member.model.outputs:
        raise DamagedFile(path, f"it has {len(own['factor'])} factors for {member.model.outputs} parameters")
    return GvCompensation(member, own["factor"], restored(GvCompensationSettings, settings["settings"], path))


LAYOUT = FileLayout(
    {"factor": Array("f", ("N",), 0, 1e4)}, {"settings": {"type": "object"}, "members": {**MEMBERS, "maxItems": 1}}
)
