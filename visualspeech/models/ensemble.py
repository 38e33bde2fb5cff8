"""Ensembles: the mean of the predictions of finished models of any families."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Stream
from visualspeech.models.members import (
    MEMBERS,
    Member,
    blocks_of,
    check_alike,
    pack,
    predictions,
    read_member,
    unpack,
    without_members,
)
from visualspeech.models.task import Fitted, Task
from visualspeech.storage.layouts import FileLayout
from visualspeech.storage.models import check_model, write_model

FAMILY = "ensemble"


@dataclass(frozen=True)
class Ensemble:
    """Models whose predictions are averaged.

    Parameters
    ----------
    members : of one frame rate, visual coding and number of parameters; they may read different input blocks
    """

    members: tuple[Member, ...]

    @property
    def blocks(self) -> dict[str, Block]:
        """All input blocks that members read, by name."""
        return blocks_of([member.model for member in self.members])

    @property
    def rate(self) -> float:
        """Frame rate in Hz."""
        return self.members[0].model.rate

    @property
    def coding(self) -> str:
        """Digest of the visual coding whose parameters are predicted."""
        return self.members[0].model.coding

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return self.members[0].model.outputs

    def predict(self, streams: Sequence[Stream], frames: int, rate: float) -> np.ndarray:
        """Parameters (frames, N) float32 of one utterance at ``rate`` Hz; each member reads its own of the streams.

        Raises
        ------
        DataError
            As the members' ``predict``.
        """
        total, models = 0.0, [member.model for member in self.members]
        for predicted in predictions(models, self.blocks, streams, frames, rate):
            total = total + predicted.astype(np.float64)
        return (total / len(models)).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write it with all its members as one safetensors file."""
        arrays, members = pack(self.members)
        write_model(path, arrays, {"kind": "model", "family": FAMILY, "members": members})


def fit(task: Task) -> Fitted:
    """The ensemble of the models that a row is made of; there is nothing to learn.

    Raises
    ------
    DataError
        There are none, they do not fit each other, or they read other input blocks than the row.
    StorageError
        A file is damaged.
    """
    import pandas

    if not task.parents:
        raise DataError(f"`models.{task.row.group}.members` names no model.")
    ensemble = Ensemble(tuple(read_member(path) for path in task.parents))
    try:
        check_alike([member.model for member in ensemble.members])
    except DataError as error:
        raise DataError(f"the members of `models.{task.row.group}` do not fit each other: {error}") from error
    if list(ensemble.blocks) != list(task.blocks):
        raise DataError(
            f"the members of `models.{task.row.group}` read {', '.join(ensemble.blocks)}, not {', '.join(task.blocks)}."
        )
    return Fitted(ensemble, pandas.DataFrame({"figure": ["members"], "value": [len(ensemble.members)]}))


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Ensemble:
    """The ensemble in a file's content.

    Raises
    ------
    StorageError
        As :func:`visualspeech.storage.models.check_model` and :func:`visualspeech.models.members.unpack`.
    """
    check_model(without_members(arrays), settings, path, "ensemble", ["model"], LAYOUT, FAMILY)
    return Ensemble(unpack(arrays, settings["members"], path))


LAYOUT = FileLayout({}, {"members": MEMBERS})
