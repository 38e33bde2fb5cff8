"""Triphone and HMM state of every frame (Fan 2015, section 3.1): one-hot 3K + 3 inputs, or shares of the frame."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.labels import DIVISIONS, label_indices, label_shares
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.phones import STATES
from visualspeech.storage.layouts import PHONES, FileLayout


@dataclass(frozen=True)
class TriphoneStateSettings(Settings):
    """Settings of the block ``triphone_state``."""

    section: ClassVar[str] = "blocks"

    fractional: bool = setting(
        False,
        "Give the share of the frame that each phone and state fills, as real values; otherwise the classes at the "
        "frame's centre.",
    )
    states: str = setting(
        "aligned",
        "Where the three states of a phone begin: at the times of the forced alignment, or at the thirds of the phone.",
        choices=DIVISIONS,
    )


@dataclass(frozen=True)
class TriphoneState:
    """Left, current and right phone of the inventory, and the state 0..2 of the current one.

    Parameters
    ----------
    phones : inventory, K entries
    options : classes or shares, and whose state times
    """

    kind: ClassVar[str] = "triphone_state"
    settings: ClassVar[type | None] = TriphoneStateSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={"phones": PHONES, "fractional": {"type": "boolean"}, "states": {"enum": list(DIVISIONS)}}
    )

    phones: tuple[str, ...]
    options: TriphoneStateSettings = TriphoneStateSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "TriphoneState":
        return cls(tuple(phones), TriphoneStateSettings(**settings))

    @property
    def layout(self) -> Layout:
        sizes = (len(self.phones),) * 3 + (STATES,)
        return Layout(dimension=sum(sizes)) if self.options.fractional else Layout(sizes=sizes)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        for one in sources:
            asked = one.alignment, one.frames, one.rate, self.phones, self.options.states
            yield (
                Stream(values=label_shares(*asked)) if self.options.fractional else Stream(index=label_indices(*asked))
            )

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"phones": list(self.phones), **asdict(self.options)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "TriphoneState":
        return cls.fit({name: value for name, value in plain.items() if name != "phones"}, plain["phones"], ())


BLOCK = TriphoneState
