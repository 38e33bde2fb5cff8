"""Contextual features of the dynamic viseme of every frame: Thangthai et al. (2016), Table 1, dynamic visemes."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source, restore
from visualspeech.features.blocks.dynamic_visemes import LARGEST, DynamicVisemes
from visualspeech.features.counts import COUNTS, Counts, fit_counts
from visualspeech.features.linguistic import Columns
from visualspeech.features.streams import Layout, Stream
from visualspeech.features.viseme_contexts import FEATURES, sizes_of, viseme_columns
from visualspeech.fields import Settings, setting
from visualspeech.speech.structure import LONG_PAUSE
from visualspeech.storage.layouts import Array, FileLayout
from visualspeech.storage.models import part_of

MAX_PAUSE = 60.0


@dataclass(frozen=True)
class VisemeContextSettings(Settings):
    """Settings of the block ``viseme_context``."""

    section: ClassVar[str] = "blocks"

    visemes: str = setting(
        "", "Block of the kind dynamic_visemes whose visemes the features are those of.", max_length=32
    )
    features: tuple[str, ...] = setting(
        tuple(FEATURES),
        "Contextual features of the current viseme.",
        item={"choices": tuple(FEATURES), "description": "Name of a contextual feature."},
        min_items=1,
        max_items=100,
        unique=True,
    )
    long_pause: float = setting(
        LONG_PAUSE, "Pauses between words end a phrase from this duration in seconds on.", minimum=0, maximum=MAX_PAUSE
    )


@dataclass(frozen=True)
class VisemeContext:
    """Classes, then normalised counts, each in the order of the features.

    Parameters
    ----------
    visemes : the block whose visemes are described
    counts : statistics of the counts over the training frames
    options : which features, and when a pause ends a phrase
    """

    kind: ClassVar[str] = "viseme_context"
    arpabet: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = ("text", "faces")
    made_of: ClassVar[Mapping[str, str]] = {"visemes": DynamicVisemes.kind}
    settings: ClassVar[type | None] = VisemeContextSettings
    stored: ClassVar[FileLayout] = FileLayout(
        {"visemes.*": Array("fiu", None, high=LARGEST)},
        {
            "counts": COUNTS,
            "visemes": {"type": "object"},
            "name": {"type": "string", "maxLength": 32},
            "features": {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": list(FEATURES)}},
            "long_pause": {"type": "number", "minimum": 0, "maximum": MAX_PAUSE},
        },
    )

    visemes: DynamicVisemes
    counts: Counts
    options: VisemeContextSettings = VisemeContextSettings()

    @classmethod
    def encoding_needs(cls, settings: Mapping) -> tuple[str, ...]:
        """What a stream is computed from beside what those visemes are computed from."""
        return ("text",)

    @property
    def encoded_from(self) -> tuple[str, ...]:
        """What a stream is computed from."""
        return tuple(dict.fromkeys(["text", *self.visemes.encoded_from]))

    @property
    def phones(self) -> tuple[str, ...]:
        """Inventory of the corpus."""
        return self.visemes.phones

    @classmethod
    def fit(
        cls,
        settings: Mapping,
        phones: Sequence[str],
        training: Iterable[Source],
        blocks: Mapping[str, DynamicVisemes],
    ) -> "VisemeContext":
        """The block, with statistics of one pass over the training utterances.

        Raises
        ------
        DataError
            There is no training utterance.
        """
        options = VisemeContextSettings(**settings)
        visemes = blocks[options.visemes]
        sizes = sizes_of(options.features, len(visemes.classes))
        counts = fit_counts((_columns(visemes, one, options).counts for one in training), sizes.counts)
        return cls(visemes, counts, options)

    @property
    def layout(self) -> Layout:
        sizes = sizes_of(self.options.features, len(self.visemes.classes))
        return Layout(sizes.sizes, sizes.counts)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance.

        Raises
        ------
        DataError
            The visemes are those of a recorded face and there is none, or a phone is not ARPAbet.
        """
        for one in sources:
            found = _columns(self.visemes, one, self.options)
            values = self.counts.normalised(found.counts)
            yield Stream(found.index if self.layout.sizes else None, values if self.layout.dimension else None)

    def for_new_speech(self) -> "VisemeContext":
        """The block without the models that only training utterances need."""
        return VisemeContext(self.visemes.for_new_speech(), self.counts, self.options)

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        arrays, plain = self.visemes.state()
        return {f"visemes.{name}": values for name, values in arrays.items()}, {
            "counts": self.counts.plain(),
            "visemes": plain,
            "name": self.options.visemes,
            "features": list(self.options.features),
            "long_pause": self.options.long_pause,
        }

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "VisemeContext":
        """The inverse of :meth:`state`.

        Raises
        ------
        DamagedFile
            What is stored of the visemes is damaged.
        SettingError
            The statistics are not those of the features.
        """
        options = VisemeContextSettings(plain["name"], tuple(plain["features"]), plain["long_pause"])
        visemes = restore(DynamicVisemes.kind, part_of(arrays, "visemes"), plain["visemes"])
        counts = Counts.of(plain["counts"], sizes_of(options.features, len(visemes.classes)).counts)
        return cls(visemes, counts, options)


def _columns(visemes: DynamicVisemes, source: Source, options: VisemeContextSettings) -> Columns:
    gestures, classes = visemes.visemes(source)
    return viseme_columns(source.alignment, source.rate, gestures, classes, options.features, options.long_pause)


BLOCK = VisemeContext
