"""The training mean: one constant face, the prediction that every model must beat."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Stream
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.task import Fitted, Task, check_examples
from visualspeech.storage.layouts import RATE, TEXT, Array, FileLayout
from visualspeech.storage.models import check_model, read_model, write_model

FAMILY = "mean"


@dataclass(frozen=True)
class TrainingMean:
    """A constant prediction.

    Parameters
    ----------
    mean : (N,) mean of all training frames
    rate : frame rate of the training utterances in Hz
    """

    mean: np.ndarray
    rate: float
    coding: str = ""
    blocks: Mapping[str, Block] = field(default_factory=dict)

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return len(self.mean)

    def predict(self, streams: Sequence[Stream], frames: int, rate: float = 0.0) -> np.ndarray:
        """The mean in every frame, (frames, N) float32."""
        return np.tile(self.mean, (frames, 1)).astype(np.float32)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        arrays, blocks = pack(self.blocks)
        settings = {"kind": "model", "family": FAMILY, "blocks": blocks, "rate": self.rate, "coding": self.coding}
        write_model(path, {"mean": self.mean, **arrays}, settings)


def fit(task: Task) -> Fitted:
    """The mean over all frames of the training utterances.

    Raises
    ------
    DataError
        There is no training utterance, or a target is not finite.
    """
    import pandas

    check_examples(task.training, task.blocks, "training")
    total, frames = 0.0, 0
    for number in range(len(task.training)):
        target = np.asarray(task.training[number].target, np.float64)
        total, frames = total + target.sum(axis=0), frames + len(target)
    model = TrainingMean(total / frames, float(task.training[0].rate), task.coding, task.blocks)
    return Fitted(model, pandas.DataFrame({"figure": ["frames"], "value": [frames]}))


def load(path: str | Path) -> TrainingMean:
    """Read a saved mean; raises as :func:`restore`."""
    return restore(*read_model(path), path)


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> TrainingMean:
    """The mean in a file's content; raises as :func:`visualspeech.storage.models.check_model`."""
    check_model(arrays, settings, path, "training mean", ["model"], LAYOUT, FAMILY)
    return TrainingMean(arrays["mean"], settings["rate"], settings["coding"], unpack(arrays, settings["blocks"], path))


LAYOUT = FileLayout({"mean": Array("f", ("N",)), **BLOCK_ARRAYS}, {"blocks": BLOCKS, "rate": RATE, "coding": TEXT})
