"""Triphone and HMM state of every frame (Fan 2015, section 3.1): four classes, one-hot 3K + 3 inputs."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.labels import label_indices
from visualspeech.features.streams import Layout, Stream
from visualspeech.speech.phones import STATES
from visualspeech.storage.layouts import PHONES, FileLayout


@dataclass(frozen=True)
class TriphoneState:
    """Left, current and right phone of the inventory, and the state 0..2 of the current one.

    Parameters
    ----------
    phones : inventory, K entries
    """

    kind: ClassVar[str] = "triphone_state"
    settings: ClassVar[type | None] = None
    stored: ClassVar[FileLayout] = FileLayout(plain={"phones": PHONES})

    phones: tuple[str, ...]

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "TriphoneState":
        return cls(tuple(phones))

    @property
    def layout(self) -> Layout:
        return Layout(sizes=(len(self.phones),) * 3 + (STATES,))

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        for one in sources:
            yield Stream(index=label_indices(one.alignment, one.frames, one.rate, self.phones))

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"phones": list(self.phones)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "TriphoneState":
        return cls(tuple(plain["phones"]))


BLOCK = TriphoneState
