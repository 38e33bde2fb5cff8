"""Contextual features of the phone of every frame: Thangthai et al. (2016), Table 1, phonetic units, and section 4.

Positions and the five phones of a segment are classes; answers about acoustic classes are 0 or 1; counts are
normalised by the training frames. All but the window over frames, with which a model reads the block ``phone``.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.counts import COUNTS, Counts, fit_counts
from visualspeech.features.linguistic import FEATURES, Columns, linguistic_columns, sizes_of
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.acoustic_classes import ACOUSTIC_CLASSES
from visualspeech.speech.phones import PHONES as ARPABET
from visualspeech.speech.structure import LONG_PAUSE, MAX_PAUSE, SHORT_PAUSE, symbols_of
from visualspeech.storage.layouts import PHONES, FileLayout


@dataclass(frozen=True)
class LinguisticSettings(Settings):
    """Settings of the block ``linguistic``."""

    section: ClassVar[str] = "blocks"

    features: tuple[str, ...] = setting(
        tuple(FEATURES),
        "Contextual features of the current phone.",
        item={"choices": tuple(FEATURES), "description": "Name of a contextual feature."},
        min_items=1,
        max_items=100,
        unique=True,
    )
    long_pause: float = setting(
        LONG_PAUSE,
        "Pauses between words are silence and end a phrase from this duration in seconds on; shorter ones are short "
        "pauses (`sp`) within it.",
        minimum=0,
        maximum=MAX_PAUSE,
    )


@dataclass(frozen=True)
class Linguistic:
    """Classes, then normalised counts, then acoustic classes, each in the order of the features.

    Parameters
    ----------
    phones : inventory of the corpus; the phones that it lacks are replaced before they are encoded
    counts : statistics of the counts over the training frames
    short_pauses : whether a training utterance has one; otherwise all pauses are silence
    options : which features, and when a pause is short
    """

    kind: ClassVar[str] = "linguistic"
    arpabet: ClassVar[bool] = True
    settings: ClassVar[type | None] = LinguisticSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={
            "counts": COUNTS,
            "phones": {**PHONES, "items": {"enum": list(ARPABET)}},
            "short_pauses": {"type": "boolean"},
            # A model's inputs are these, in this order.
            "classes": {"const": list(ACOUSTIC_CLASSES)},
            "features": {"type": "array", "minItems": 1, "uniqueItems": True, "items": {"enum": list(FEATURES)}},
            "long_pause": {"type": "number", "minimum": 0, "maximum": MAX_PAUSE},
        },
    )

    phones: tuple[str, ...]
    counts: Counts
    short_pauses: bool = True
    options: LinguisticSettings = LinguisticSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "Linguistic":
        """The block, with statistics of one pass over the training utterances.

        Raises
        ------
        DataError
            There is no training utterance.
        """
        options = LinguisticSettings(**settings)
        found: set[str] = set()

        def counts_of_each() -> Iterator[np.ndarray]:
            for one in training:
                found.update(symbols_of(one.alignment, options.long_pause))
                yield _columns(one, options, True).counts

        counts = fit_counts(counts_of_each(), sizes_of(options.features).counts)
        return cls(tuple(phones), counts, SHORT_PAUSE in found, options)

    @property
    def layout(self) -> Layout:
        sizes = sizes_of(self.options.features)
        return Layout(sizes.sizes, sizes.counts + sizes.classes)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance.

        Raises
        ------
        DataError
            An alignment has no phones, or a phone that is not ARPAbet.
        """
        for one in sources:
            found = _columns(one, self.options, self.short_pauses)
            values = np.concatenate([self.counts.normalised(found.counts), found.classes], axis=1, dtype=np.float32)
            yield Stream(found.index if self.layout.sizes else None, values if self.layout.dimension else None)

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {
            "counts": self.counts.plain(),
            "phones": list(self.phones),
            "short_pauses": self.short_pauses,
            "classes": list(ACOUSTIC_CLASSES),
            "features": list(self.options.features),
            "long_pause": self.options.long_pause,
        }

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "Linguistic":
        """The inverse of :meth:`state`; raises :class:`SettingError` where counts and features do not fit."""
        options = LinguisticSettings(tuple(plain["features"]), plain["long_pause"])
        counts = Counts.of(plain["counts"], sizes_of(options.features).counts)
        return cls(tuple(plain["phones"]), counts, plain["short_pauses"], options)


def _columns(source: Source, options: LinguisticSettings, short_pauses: bool) -> Columns:
    asked = source.alignment, source.frames, source.rate, options.features
    return linguistic_columns(*asked, options.long_pause, short_pauses)


BLOCK = Linguistic
