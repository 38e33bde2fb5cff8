"""Names of networks, the one place that makes and reads them: ``FBB-128``, ``FBB-128-s2``, ``FBB-128-rich``.

A network is named by its stack and its width. The first seed of a run and the plain labels go without saying; another
seed is ``-s`` and its number, and richer labels (:mod:`visualspeech.features.richer`) are ``-rich``.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from visualspeech.errors import SettingError

_FORM = re.compile(r"([A-Za-z]+)-(\d{1,9})(-rich)?(?:-s(\d{1,9}))?")


@dataclass(frozen=True)
class NetworkName:
    """What a network's name says.

    Parameters
    ----------
    letters, nodes : the stack and its width
    rich : whether it learns from the richer labels
    seed : of its training; None is the run's first
    """

    letters: str
    nodes: int
    rich: bool = False
    seed: int | None = None

    def __str__(self) -> str:
        return self.cell + (f"-s{self.seed}" if self.seed is not None else "")

    @property
    def row(self) -> str:
        """Row of the network in a table of topologies: stack, and whether its labels are the richer ones."""
        return self.letters + ("-rich" if self.rich else "")

    @property
    def cell(self) -> str:
        """Name without the seed: networks of one cell of a table have this in common."""
        return f"{self.letters}-{self.nodes}" + ("-rich" if self.rich else "")


def parse_name(name: str) -> NetworkName:
    """The parts of a network's name.

    Raises
    ------
    SettingError
        It has no such form. Whether letters and width make a stack is checked by
        :class:`visualspeech.models.blstm.StackSettings`.
    """
    match = _FORM.fullmatch(name)
    if not match:
        raise SettingError(
            f"the model {name!r} is not of the form LETTERS-NODES, for example FBB-128 (FBB-128-s2 of a second seed, "
            "FBB-128-rich of richer labels)."
        )
    return NetworkName(match[1], int(match[2]), bool(match[3]), int(match[4]) if match[4] else None)


def is_network(name: str) -> bool:
    """Whether a row of a table is a network, and not a baseline or an HMM."""
    return _FORM.fullmatch(name) is not None


def cells_of(names: Iterable[str]) -> dict[str, list[str]]:
    """Networks by the cell that they are repetitions of, both in the order given; other names are left out."""
    found: dict[str, list[str]] = {}
    for name in names:
        if is_network(name):
            found.setdefault(parse_name(name).cell, []).append(name)
    return found
