"""Phones with their neighbours, their place in the utterance and start times: what HSMMs of phones in context read.

The columns are those that the questions of decision trees are asked about, as full-context labels hold them for speech
synthesis (Tokuda et al. 2002): two phones on either side, and positions and numbers of phones, syllables, words and
phrases, for the rows of Thangthai et al. 2016, Table 1, from the syllable to the utterance.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

import numpy as np

from visualspeech.features.blocks.base import Source
from visualspeech.features.contexts import phone_contexts
from visualspeech.features.streams import Layout, Stream
from visualspeech.fields import Settings, section_schema, setting
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.structure import LONG_PAUSE, MAX_PAUSE, SHORT_PAUSE, structure_of, symbols_of
from visualspeech.storage.layouts import PHONES, FileLayout

#: A unit of speech, what contains it, and the plural of the unit.
_LEVELS = (
    ("phone", "syllable"),
    ("syllable", "word"),
    ("syllable", "phrase"),
    ("word", "phrase"),
    ("syllable", "utterance"),
    ("word", "utterance"),
    ("phrase", "utterance"),
)
#: Names of the columns that follow the phones.
FACTORS: tuple[str, ...] = tuple(
    name
    for unit, whole in _LEVELS
    for name in (f"{unit} in {whole}", f"{unit} from the end of {whole}", f"{unit}s in {whole}")
)


@dataclass(frozen=True)
class FullContextSettings(Settings):
    """Settings of the block ``full_context``."""

    section: ClassVar[str] = "blocks"

    neighbours: int = setting(
        2, "Phones on either side of the phone itself; 2 gives quinphones.", minimum=0, maximum=10
    )
    max_number: int = setting(
        20, "Largest position or number of units in a column; larger ones count as this one.", minimum=1, maximum=200
    )
    long_pause: float = setting(
        LONG_PAUSE,
        "Duration in seconds from which on a pause inside an utterance is `sil` and ends a phrase; shorter ones are "
        "`sp`.",
        minimum=0,
        maximum=MAX_PAUSE,
    )


@dataclass(frozen=True)
class FullContext:
    """A row per phone: the phones around it, its positions from both ends and numbers of units, its start in seconds.

    Parameters
    ----------
    phones : inventory of the corpus, which has no short pause
    options : sizes of the columns, and which pauses are long
    """

    kind: ClassVar[str] = "full_context"
    arpabet: ClassVar[bool] = True
    settings: ClassVar[type | None] = FullContextSettings
    stored: ClassVar[FileLayout] = FileLayout(
        plain={"phones": PHONES, **section_schema(FullContextSettings)["properties"]}
    )
    segmental: ClassVar[bool] = True
    #: Rows of each phone, as those of the block ``phone_track``.
    divisions: ClassVar[int] = 1

    phones: tuple[str, ...]
    options: FullContextSettings = FullContextSettings()

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "FullContext":
        return cls(tuple(phones), FullContextSettings(**settings))

    @property
    def symbols(self) -> tuple[str, ...]:
        """What the columns of phones number: the inventory and the short pause."""
        return (*self.phones, SHORT_PAUSE)

    @property
    def factors(self) -> tuple[tuple[str, int], ...]:
        """Name and number of values of each column that follows the phones; 0 is a pause."""
        return tuple((name, self.options.max_number + 1) for name in FACTORS)

    @property
    def layout(self) -> Layout:
        sizes = (len(self.symbols),) * (2 * self.options.neighbours + 1)
        return Layout(sizes=(*sizes, *(values for _, values in self.factors)), segmental=True)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        for one in sources:
            yield Stream(index=self._contexts(one.alignment), starts=starts_of(one.alignment.phones))

    def _contexts(self, alignment: Alignment) -> np.ndarray:
        """All columns of the phones of an utterance, (P, C) int16."""
        symbols = symbols_of(alignment, self.options.long_pause)
        renamed = tuple(replace(one, label=symbol) for one, symbol in zip(alignment.phones, symbols, strict=True))
        around = self.options.neighbours
        contexts = phone_contexts(replace(alignment, phones=renamed), self.symbols, around, around)
        structure, columns = vars(structure_of(alignment, self.options.long_pause)), []
        for unit, whole in _LEVELS:
            position, number = structure[f"{unit}_in_{whole}"], structure[f"{unit}s_in_{whole}"]
            columns += [position, np.where(number > 0, number - position + 1, 0), number]
        numbers = np.minimum(np.stack(columns, axis=1), self.options.max_number)
        return np.concatenate([contexts, numbers], axis=1).astype(np.int16)

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        return {}, {"phones": list(self.phones), **asdict(self.options)}

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "FullContext":
        options = {name: value for name, value in plain.items() if name != "phones"}
        return cls(tuple(plain["phones"]), FullContextSettings(**options))


BLOCK = FullContext
