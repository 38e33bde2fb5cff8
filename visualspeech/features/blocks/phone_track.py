"""The phones of an utterance, or their states, with neighbours and start times: what HMMs read."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.contexts import phone_contexts
from visualspeech.features.labels import state_labels
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.alignment import starts_of
from visualspeech.speech.phones import STATES
from visualspeech.storage.layouts import PHONES, FileLayout


@dataclass(frozen=True)
class PhoneTrackSettings(Settings):
    """Settings of the block ``phone_track``."""

    section: ClassVar[str] = "blocks"

    states: str = setting(
        "none",
        "Times within a phone: none, or aligned: those of the three states of the forced alignment, a row for each.",
        choices=("none", "aligned"),
    )


@dataclass(frozen=True)
class PhoneTrack:
    """A row a phone: left, current and right phone, and the start in seconds; or a row a state, with its number 0..2.

    Parameters
    ----------
    phones : inventory, K entries
    options : phones or states
    """

    kind: ClassVar[str] = "phone_track"
    settings: ClassVar[type | None] = PhoneTrackSettings
    segmental: ClassVar[bool] = True
    stored: ClassVar[FileLayout] = FileLayout(plain={"phones": PHONES, "states": {"enum": ["none", "aligned"]}})

    phones: tuple[str, ...]
    options: PhoneTrackSettings = PhoneTrackSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "PhoneTrack":
        return cls(tuple(phones), PhoneTrackSettings(**settings))

    @property
    def divisions(self) -> int:
        """Rows of each phone: 1, or the number of states, whose number is then the last column."""
        return 1 if self.options.states == "none" else STATES

    @property
    def layout(self) -> Layout:
        numbers = () if self.divisions == 1 else (self.divisions,)
        return Layout(sizes=(len(self.phones),) * 3 + numbers, segmental=True)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        for one in sources:
            if self.divisions == 1:
                contexts, starts = phone_contexts(one.alignment, self.phones), starts_of(one.alignment.phones)
            else:
                starts, contexts = state_labels(one.alignment, self.phones, self.options.states)
            yield Stream(index=contexts, starts=starts)

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"phones": list(self.phones), **asdict(self.options)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "PhoneTrack":
        return cls(tuple(plain["phones"]), PhoneTrackSettings(plain["states"]))


BLOCK = PhoneTrack
