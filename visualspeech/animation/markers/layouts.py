"""Layouts of known sets of markers: directions of the face, roles, lines of a drawing, and controls.

A layout is data, ``marker_layouts/*.yaml``; no code knows a marker by name. Keys:

``dimensions`` : allowed numbers of coordinates per point
``axes`` : ``left``, ``up`` and, for three coordinates, ``forward``, each ``from`` and ``to``: the direction from the
    mean of some markers to that of others in the idle face. Left is that of the person. The axes of a file's coordinate
    system are not needed.
``sorted`` : markers in the order of their idle positions along an axis, and the roles that they get by it
``ring`` : markers in their order around their middle, from the leftmost one over the uppermost, and their roles
``lines`` : chains of markers or roles that a drawing joins
``fap``, ``live_link`` : a control -> its movement: direction -> marker or role -> weight. ``value`` is the direction of
    channels, which have one coordinate. ``like`` names a control of the same layout whose scale is used.
``live_link: identity`` : the markers are channels of Live Link Face themselves
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.settings import read_yaml

FOLDER = Path(__file__).parent / "marker_layouts"
OPPOSITE = {"right": "left", "down": "up", "back": "forward"}
IDENTITY = "identity"


@dataclass(frozen=True)
class Layout:
    """A set of markers as its file describes it (see the module)."""

    name: str
    dimensions: Sequence[int]
    axes: Mapping[str, Mapping[str, Sequence[str]]] = field(default_factory=dict)
    sorted: Sequence[Mapping] = ()
    ring: Mapping = field(default_factory=dict)
    lines: Sequence[Sequence[str]] = ()
    fap: Mapping[str, Mapping] = field(default_factory=dict)
    live_link: Mapping[str, Mapping] | str = field(default_factory=dict)

    @property
    def roles(self) -> tuple[str, ...]:
        """All roles that markers get by their position."""
        return tuple(role for one in (*self.sorted, *([self.ring] if self.ring else [])) for role in one["roles"])

    @property
    def markers(self) -> frozenset[str]:
        """All markers that the layout names; a set of markers must have them."""
        placed = [*self.sorted, *([self.ring] if self.ring else [])]
        found = {name for one in placed for name in one["of"]}
        found |= {name for axis in self.axes.values() for end in axis.values() for name in end}
        found |= {name for line in self.lines for name in line}
        shapes = self.live_link if isinstance(self.live_link, Mapping) else {}
        for movement in (*self.fap.values(), *shapes.values()):
            found |= {name for weights in movement.values() if isinstance(weights, Mapping) for name in weights}
        return frozenset(found - set(self.roles))


@cache
def layouts() -> tuple[Layout, ...]:
    """All layouts, sorted by name."""
    return tuple(Layout(name=path.stem, **read_yaml(path)) for path in sorted(FOLDER.glob("*.yaml")))


def layout_of(names: Iterable[str], dimensions: int) -> Layout | None:
    """The layout for markers of these names and number of coordinates; None if there is none."""
    names = frozenset(names)
    fitting = [one for one in layouts() if dimensions in one.dimensions and one.markers <= names]
    return max(fitting, key=lambda one: len(one.markers), default=None)


@dataclass(frozen=True)
class Frame:
    """The idle face of a layout: where its markers are, and which way its axes point.

    Parameters
    ----------
    index : marker or role -> row of the points
    axes : ``left``, ``up`` and, in three dimensions, ``forward`` -> unit vector (d,); empty for channels
    """

    index: Mapping[str, int]
    axes: Mapping[str, np.ndarray]

    def direction(self, name: str) -> np.ndarray:
        """Unit vector (d,) of a direction; ``value`` is that of channels.

        Raises
        ------
        DataError
            The points have no such direction.
        """
        if name == "value":
            return np.ones(1)
        sign, axis = (-1.0, OPPOSITE[name]) if name in OPPOSITE else (1.0, name)
        if axis not in self.axes:
            raise DataError(f"points of {len(self.axes)} dimensions have no direction {name!r}.")
        return sign * self.axes[axis]


def frame_of(layout: Layout, names: Sequence[str], idle: np.ndarray) -> Frame:
    """Axes and roles of an idle face (P, d)."""
    index = {name: row for row, name in enumerate(names)}
    axes = _axes(layout, index, idle)
    frame = Frame(index, axes)
    roles: dict[str, int] = {}
    for one in layout.sorted:
        along = frame.direction(one["along"])
        rows = sorted((index[name] for name in one["of"]), key=lambda row: float(idle[row] @ along))
        roles |= dict(zip(one["roles"], rows, strict=True))
    if layout.ring:
        rows = [index[name] for name in layout.ring["of"]]
        flat = np.stack([idle[rows] @ axes["left"], idle[rows] @ axes["up"]], axis=1)
        flat = (flat - flat.mean(axis=0)) / np.maximum(np.ptp(flat, axis=0), 1e-12)
        first = int(np.argmax(flat[:, 0]))
        angles = np.arctan2(flat[:, 1], flat[:, 0])
        turned = np.mod(angles - angles[first] + 1e-9, 2 * np.pi)
        roles |= {role: rows[at] for role, at in zip(layout.ring["roles"], np.argsort(turned), strict=True)}
    return Frame({**index, **roles}, axes)


def _axes(layout: Layout, index: Mapping[str, int], idle: np.ndarray) -> dict[str, np.ndarray]:
    """Orthogonal unit vectors; ``left`` is exact, ``up`` is turned square to it, ``forward`` square to both."""
    if not layout.axes:
        return {}
    ends = {
        name: [np.mean([idle[index[one]] for one in axis[end]], axis=0) for end in ("from", "to")]
        for name, axis in layout.axes.items()
    }
    towards = {name: to - start for name, (start, to) in ends.items()}
    left = _unit(towards["left"])
    up = _unit(towards["up"] - (towards["up"] @ left) * left)
    found = {"left": left, "up": up}
    if len(left) == 3:
        square = np.cross(left, up)
        found["forward"] = square * (1.0 if square @ towards["forward"] >= 0 else -1.0)
    return found


def _unit(vector: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(vector))
    if not length > 0:
        raise DataError("the idle face has no extent: markers of different places lie in one point.")
    return vector / length
