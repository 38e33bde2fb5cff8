"""The phone of every frame, one of 41 symbols: the centre phone of Thangthai et al. (2016), section 4.1.

Read with a window (``reads: [{phone: 0.16}]``) it is the paper's phonetic window context.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from visualspeech.features.blocks.base import Source
from visualspeech.features.linguistic import symbol_numbers
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, setting
from visualspeech.speech.alignment import starts_of
from visualspeech.speech.phones import PHONES as ARPABET
from visualspeech.speech.structure import LONG_PAUSE, MAX_PAUSE, SHORT_PAUSE, SYMBOLS, symbols_of
from visualspeech.storage.layouts import PHONES, FileLayout
from visualspeech.timing import frame_times, interval_of_frame


@dataclass(frozen=True)
class PhoneSettings(Settings):
    """Settings of the block ``phone``."""

    section: ClassVar[str] = "blocks"

    long_pause: float = setting(
        LONG_PAUSE,
        "Pauses between words are silence (`sil`) from this duration in seconds on; shorter ones are short pauses "
        "(`sp`). Those at the ends of an utterance are always silence.",
        minimum=0,
        maximum=MAX_PAUSE,
    )


@dataclass(frozen=True)
class Phone:
    """One class of 41 per frame.

    Parameters
    ----------
    phones : inventory of the corpus; the phones that it lacks are replaced before they are encoded
    short_pauses : whether a training utterance has one; otherwise all pauses are silence, since a model would not
        know what to do in a short one
    options : when a pause is short
    """

    kind: ClassVar[str] = "phone"
    arpabet: ClassVar[bool] = True
    settings: ClassVar[type | None] = PhoneSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={
            "phones": {**PHONES, "items": {"enum": list(ARPABET)}},
            "short_pauses": {"type": "boolean"},
            "long_pause": {"type": "number", "minimum": 0, "maximum": MAX_PAUSE},
        }
    )

    phones: tuple[str, ...]
    short_pauses: bool = True
    options: PhoneSettings = PhoneSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "Phone":
        options = PhoneSettings(**settings)
        short = any(SHORT_PAUSE in symbols_of(one.alignment, options.long_pause) for one in training)
        return cls(tuple(phones), short, options)

    @property
    def layout(self) -> Layout:
        return Layout(sizes=(len(SYMBOLS),))

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance.

        Raises
        ------
        DataError
            An alignment has no phones, or a phone that is not ARPAbet.
        """
        for one in sources:
            symbols = symbol_numbers(one.alignment, self.options.long_pause, self.short_pauses)
            of_frame = interval_of_frame(starts_of(one.alignment.phones), frame_times(one.frames, one.rate))
            yield Stream(index=symbols[of_frame][:, None])

    def state(self) -> tuple[dict, dict]:
        own = {"phones": list(self.phones), "short_pauses": self.short_pauses}
        return {}, {**own, "long_pause": self.options.long_pause}

    @classmethod
    def restore(cls, arrays: Mapping, plain: Mapping) -> "Phone":
        return cls(tuple(plain["phones"]), plain["short_pauses"], PhoneSettings(plain["long_pause"]))


BLOCK = Phone
