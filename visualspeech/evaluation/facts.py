"""Facts about the data of a table's figures, shown in the header of every table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from visualspeech import __version__
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import PROTOCOLS
from visualspeech.provenance import split_hash

#: Analyses of an appearance model in the order in which papers give their numbers of components.
_ORDER = ("shape", "texture", "appearance")
_COMPONENTS = "_components"


@dataclass(frozen=True)
class TableFacts:
    """Facts about the data of a table.

    The commit is not among them, because every commit would then make all tables out of date.

    Parameters
    ----------
    corpus, system : names
    split_hash : from :func:`visualspeech.provenance.split_hash`
    rate : frame rates of the test utterances in Hz, usually only one
    coding : name of the visual coding
    coding_sizes : its numbers of components, for example ``66 shape, 100 texture, 87 appearance``, or of coordinates
    drift : method of drift removal, ``none`` where there is none
    seeds : of the models
    version : of this program
    """

    corpus: str
    system: str
    split_hash: str
    rate: tuple[float, ...]
    coding: str
    coding_sizes: str
    drift: str
    seeds: tuple[int, ...]
    version: str = __version__

    @classmethod
    def of(
        cls,
        given: Mapping[str, str],
        split: Mapping[str, str],
        shapes: Mapping[str, Sequence[int]],
        measured: MeasuredRows,
    ) -> "TableFacts":
        """Facts of measured rows.

        Parameters
        ----------
        given : ``corpus``, ``system``, ``coding``, ``drift``
        split : utterance -> split
        shapes : shapes of the arrays of the coding's model (:func:`visualspeech.storage.models.read_shapes`)
        """
        return cls(
            **given,
            split_hash=split_hash(split),
            rate=measured.rates,
            coding_sizes=coding_sizes(shapes),
            seeds=measured.seeds,
        )

    def at(self, rate: float) -> "TableFacts":
        """The facts of a system of that frame rate in Hz, whose figures are taken on other frames; 0: the same rate."""
        return replace(self, rate=(rate,)) if rate else self

    def lines(self, measured: MeasuredRows, protocol: str = "") -> tuple[tuple[str, str], ...]:
        """The facts as (name, text) pairs, with the number of test utterances and frames, and the protocol if given."""
        lines = (
            ("corpus", self.corpus),
            ("system", self.system),
            ("split", self.split_hash),
            ("rate", self.rate_text),
            ("visual coding", self.coding_text),
            ("drift removal", self.drift),
            ("seeds", ", ".join(map(str, self.seeds))),
            ("test utterances", str(measured.utterances)),
            ("test frames", str(measured.frames)),
            ("visualspeech", self.version),
            ("protocol", PROTOCOLS.get(protocol, "")),
        )
        return tuple((name, text) for name, text in lines if text)

    @property
    def rate_text(self) -> str:
        """The frame rate with its unit; of several rates, the lowest and the highest."""
        ends = dict.fromkeys((*self.rate[:1], *self.rate[-1:]))
        return "–".join(f"{rate:g}" for rate in ends) + " Hz" if ends else ""

    @property
    def coding_text(self) -> str:
        """Name and sizes of the coding."""
        return f"{self.coding} ({self.coding_sizes})" if self.coding_sizes else self.coding


def coding_sizes(shapes: Mapping[str, Sequence[int]]) -> str:
    """Numbers of components of a coding's model: the rows of its arrays ``shape_components`` and so on; of one without
    components the number of its coordinates."""
    if "deviation" in shapes:
        return f"{shapes['deviation'][-1]} coordinates"
    sizes = {name.removesuffix(_COMPONENTS): shape[0] for name, shape in shapes.items() if name.endswith(_COMPONENTS)}
    ordered = sorted(sizes, key=lambda name: (_ORDER.index(name) if name in _ORDER else len(_ORDER), name))
    return ", ".join(f"{sizes[name]} {name}" for name in ordered)
