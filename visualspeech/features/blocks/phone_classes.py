"""Articulatory classes of the left, the current and the right phone: inputs that phones in unknown context share."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.labels import DIVISIONS, mean_over_frames, state_labels
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.phone_classes import PHONE_CLASSES, class_members
from visualspeech.speech.phones import PHONES, STATES
from visualspeech.storage.layouts import FileLayout
from visualspeech.timing import frame_times, interval_of_frame

_STATES = (*DIVISIONS, "none")


@dataclass(frozen=True)
class PhoneClassesSettings(Settings):
    """Settings of the block ``phone_classes``."""

    section: ClassVar[str] = "blocks"

    fractional: bool = setting(
        False, "Give the share of the frame that each class fills; otherwise the classes at the frame's centre."
    )
    states: str = setting(
        "aligned",
        "Where the three states of a phone, which are three further columns, begin: at the times of the forced "
        "alignment, or at the thirds of the phone; none: no such columns.",
        choices=_STATES,
    )


@dataclass(frozen=True)
class PhoneClasses:
    """Membership of three phones in each class, 0 or 1, or the share of the frame with such a phone; and of the states.

    The classes are those of the phone set, not of a corpus, so that a phone which training lacks has known ones.

    Parameters
    ----------
    options : membership or shares, and whose state times
    """

    kind: ClassVar[str] = "phone_classes"
    arpabet: ClassVar[bool] = True
    settings: ClassVar[type | None] = PhoneClassesSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={
            # A model's inputs are these, in this order.
            "classes": {"const": list(PHONE_CLASSES)},
            "fractional": {"type": "boolean"},
            "states": {"enum": list(_STATES)},
        }
    )

    options: PhoneClassesSettings = PhoneClassesSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "PhoneClasses":
        return cls(PhoneClassesSettings(**settings))

    @property
    def layout(self) -> Layout:
        return Layout(dimension=3 * len(PHONE_CLASSES) + (STATES if self.options.states != "none" else 0))

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        members, numbers = class_members().astype(np.float32), np.eye(STATES, dtype=np.float32)
        without = self.options.states == "none"
        for one in sources:
            starts, labels = state_labels(one.alignment, PHONES, DIVISIONS[0] if without else self.options.states)
            values = np.concatenate([*(members[labels[:, n]] for n in range(3)), numbers[labels[:, 3]]], axis=1)
            values = values[:, : self.layout.dimension]
            if self.options.fractional:
                yield Stream(values=mean_over_frames(values, starts, one.frames, one.rate))
            else:
                yield Stream(values=values[interval_of_frame(starts, frame_times(one.frames, one.rate))])

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"classes": list(PHONE_CLASSES), **asdict(self.options)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "PhoneClasses":
        return cls.fit({name: value for name, value in plain.items() if name != "classes"}, (), ())


BLOCK = PhoneClasses
