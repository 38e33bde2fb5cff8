"""What a family of models is given to learn from, and what it hands back: the same for networks, HMMs and baselines."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream, check_stream
from visualspeech.models.lips import Lips
from visualspeech.models.rows import ModelRow


@dataclass(frozen=True)
class Task:
    """One model to be trained.

    Parameters
    ----------
    row : what the settings ask for
    blocks : the input blocks that it reads, by name, in the order of its streams
    training, validation : utterances
    coding : digest of the visual coding whose parameters are predicted, kept with the model
    parents : files of the models that it is made from
    checkpoint : file in which a long training keeps its state; None for none
    lips : of the training utterances, for networks whose training weights closures or open vowels; without it, these
        weights count as 0
    regions : columns of the targets by region of the face, each in one; empty where the visual coding has none
    """

    row: ModelRow
    blocks: Mapping[str, Block]
    training: Sequence[Example]
    validation: Sequence[Example]
    coding: str = ""
    parents: Sequence[Path] = ()
    checkpoint: Path | None = None
    lips: Lips | None = None
    regions: Mapping[str, Sequence[int]] = field(default_factory=dict)


class Model(Protocol):
    """A trained model: streams of its input blocks in, parameters of the visual coding out."""

    blocks: Mapping[str, Block]
    rate: float
    coding: str

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""

    def predict(self, streams: Sequence[Stream], frames: int, rate: float) -> np.ndarray:
        """Parameters (frames, N) float32 of one utterance at ``rate`` Hz."""

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""


@dataclass(frozen=True)
class Fitted:
    """A trained model and how its training went.

    Parameters
    ----------
    model : with its best parameters
    curve : data frame, a row an epoch or iteration; columns as the family says
    """

    model: Model
    curve: object = field(repr=False)


def check_examples(examples: Sequence[Example], blocks: Mapping[str, Block], name: str) -> None:
    """Check that there is an utterance and that all of them fit the blocks.

    Raises
    ------
    DataError
        They do not; ``name`` (training, validation) is for the message.
    """
    if not len(examples):
        raise DataError(f"there is no {name} utterance to learn from. Add recordings, or change `split`.")
    for number in range(len(examples)):
        check_streams(examples[number].streams, blocks)
        if not np.isfinite(examples[number].target).all():
            raise DataError(
                f"a {name} utterance has target parameters that are not finite numbers; delete the targets of the "
                "system and run again."
            )


def check_streams(streams: Sequence[Stream], blocks: Mapping[str, Block]) -> None:
    """Check the streams of one utterance against the blocks of a model.

    Raises
    ------
    DataError
        Their number or their columns differ.
    """
    if len(streams) != len(blocks):
        raise DataError(f"{len(streams)} input streams given, the model reads {len(blocks)}: {', '.join(blocks)}.")
    for stream, (name, block) in zip(streams, blocks.items(), strict=True):
        check_stream(stream, block.layout, name)
