"""The phones of an utterance with their neighbours and start times: what HMMs read."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.contexts import phone_contexts
from visualspeech.features.streams import Layout, Stream
from visualspeech.storage.layouts import PHONES, FileLayout


@dataclass(frozen=True)
class PhoneTrack:
    """A row a phone: left, current and right phone, and the start in seconds.

    Parameters
    ----------
    phones : inventory, K entries
    """

    kind: ClassVar[str] = "phone_track"
    settings: ClassVar[type | None] = None
    stored: ClassVar[FileLayout] = FileLayout(plain={"phones": PHONES})

    phones: tuple[str, ...]

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "PhoneTrack":
        return cls(tuple(phones))

    @property
    def layout(self) -> Layout:
        return Layout(sizes=(len(self.phones),) * 3, segmental=True)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        for one in sources:
            starts = np.array([phone.start for phone in one.alignment.phones])
            yield Stream(index=phone_contexts(one.alignment, self.phones), starts=starts)

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"phones": list(self.phones)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "PhoneTrack":
        return cls(tuple(plain["phones"]))


BLOCK = PhoneTrack
