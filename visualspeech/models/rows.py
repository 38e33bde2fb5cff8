"""A model as a row of the result tables: what the settings ask for, as plain data, without any code of a model."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

#: Role of a model whose input is read off the recorded face of the utterance that it predicts.
ORACLE = "oracle"
#: What a row is in a table: a model that learns, one that is told part of the answer, a trivial baseline, or the error
#: that the visual coding alone makes.
ROLES = ("model", ORACLE, "baseline", "floor")
#: Longest window before and after a frame in seconds.
MAX_WINDOW = 1.0


@dataclass(frozen=True)
class ModelRow:
    """One model of a system.

    Parameters
    ----------
    name : unique in its system; folder of its results, for example ``FBB-128-s2``
    title : shown in tables
    family : entry of the registry, for example ``stack`` or ``hmm``
    settings : of the family, all defaults filled in (``letters``, ``nodes``, ...)
    reads : names of the input blocks
    training : settings of its training, all defaults filled in; empty for families without any
    seed : of everything random in its training
    group : key of the system's ``models:`` that asks for it, for example ``nets``
    cell : name without the seed; rows of one cell are repetitions of each other
    parents : names of the rows that it is made from
    role : of :data:`ROLES`
    windows : seconds before and after each frame that the model reads beside it, by input block; of the others it reads
        single frames
    """

    name: str
    title: str
    family: str
    settings: Mapping = field(default_factory=dict)
    reads: tuple[str, ...] = ()
    training: Mapping = field(default_factory=dict)
    seed: int = 1
    group: str = ""
    cell: str = ""
    parents: tuple[str, ...] = ()
    role: str = "model"
    windows: Mapping[str, float] = field(default_factory=dict)

    @property
    def inputs(self) -> tuple[str, ...]:
        """What it reads, for people: names of blocks, with their windows."""
        return tuple(
            f"{name} ({self.windows[name]:g} s either side)" if name in self.windows else name for name in self.reads
        )

    def plain(self) -> dict:
        """The row as JSON can hold it; ``windows`` is left out where there is none."""
        plain = {**asdict(self), "reads": list(self.reads), "parents": list(self.parents)}
        return {name: value for name, value in plain.items() if name != "windows" or value}

    @classmethod
    def of(cls, plain: Mapping) -> "ModelRow":
        """The inverse of :meth:`plain`."""
        return cls(**{**plain, "reads": tuple(plain["reads"]), "parents": tuple(plain["parents"])})
