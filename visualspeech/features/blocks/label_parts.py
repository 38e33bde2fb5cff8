"""What labels say beyond phones and states: position in the syllable and in the word, stress (Fan 2015, 3.1)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.label_parts import PARTS, label_parts, part_sizes
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech import tts
from visualspeech.speech.phones import SILENCE
from visualspeech.storage.layouts import FileLayout


@dataclass(frozen=True)
class LabelPartsSettings(Settings):
    """Settings of the block ``label_parts``."""

    section: ClassVar[str] = "blocks"

    parts: tuple[str, ...] = setting(
        tuple(PARTS),
        "Parts of a label beside phone and state.",
        item={"choices": tuple(PARTS), "description": "Name of a part."},
        min_items=1,
        max_items=100,
        unique=True,
    )


@dataclass(frozen=True)
class LabelParts:
    """One class a part and frame.

    Parameters
    ----------
    parts : names of :data:`visualspeech.features.label_parts.PARTS`
    """

    kind: ClassVar[str] = "label_parts"
    arpabet: ClassVar[bool] = True
    settings: ClassVar[type | None] = LabelPartsSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={"parts": {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": list(PARTS)}}}
    )

    parts: tuple[str, ...]

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "LabelParts":
        return cls(tuple(settings["parts"]))

    @property
    def layout(self) -> Layout:
        return Layout(sizes=part_sizes(self.parts))

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        stresses = {}
        if "stress" in self.parts:
            # One call for all words: each starts a process of the synthesiser.
            spoken = {word.label for one in sources for word in one.alignment.words}
            stresses = tts.stresses(sorted(spoken - {SILENCE}))
        for one in sources:
            yield Stream(index=label_parts(one.alignment, one.frames, one.rate, self.parts, stresses))

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"parts": list(self.parts)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "LabelParts":
        return cls(tuple(plain["parts"]))


BLOCK = LabelParts
