"""Arrays that a program gives, in place of something that is computed from speech (:func:`visualspeech.train`).

A model that was trained on them reads such arrays alone. A run cannot use the block: its settings hold no arrays.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

from visualspeech.errors import DataError
from visualspeech.features.blocks.base import Source
from visualspeech.features.streams import Layout, Stream
from visualspeech.storage.layouts import FileLayout

MAX_COLUMNS, MAX_CLASSES = 100_000, 1_000_000
_COMPUTED = "the input block arrays holds what a program gives to visualspeech.train; it is computed from no recording."


@dataclass(frozen=True)
class Arrays:
    """Columns of given arrays.

    Parameters
    ----------
    dimension : number of real-valued columns
    sizes : number of classes of each categorical column
    """

    kind: ClassVar[str] = "arrays"
    needs: ClassVar[tuple[str, ...]] = ()
    settings: ClassVar[type | None] = None
    stored: ClassVar[FileLayout] = FileLayout(
        plain={
            "dimension": {"type": "integer", "minimum": 0, "maximum": MAX_COLUMNS},
            "sizes": {
                "type": "array",
                "maxItems": MAX_COLUMNS,
                "items": {"type": "integer", "minimum": 1, "maximum": MAX_CLASSES},
            },
        }
    )

    dimension: int = 0
    sizes: tuple[int, ...] = ()

    @classmethod
    def unavailable(cls) -> str:
        """Why a system cannot have the block."""
        return f"{_COMPUTED} Name another kind."

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "Arrays":
        raise DataError(_COMPUTED)

    @property
    def layout(self) -> Layout:
        return Layout(self.sizes, self.dimension)

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        raise DataError(_COMPUTED)

    def state(self) -> tuple[dict, dict]:
        return {}, {"dimension": self.dimension, "sizes": list(self.sizes)}

    @classmethod
    def restore(cls, arrays: Mapping, plain: Mapping) -> "Arrays":
        return cls(plain["dimension"], tuple(plain["sizes"]))


BLOCK = Arrays
