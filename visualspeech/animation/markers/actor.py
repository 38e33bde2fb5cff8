"""Controls of an animation system from recorded or predicted markers, by the range of an actor's motion.

After Mariooryad and Busso, as Sadoughi and Busso (2017, section 3.3) use it: the idle position of the markers is the
neutral face, and the range of each actor's motion is scaled to the range of each parameter. A control is linear in the
points: the displacement of some markers from the idle face along a direction of the face (:mod:`.layouts`), times a
scale. The scale takes the 99th percentile of the absolute displacement in the recordings to the control's range. Left
and right of a control share the larger displacement, so that an even face stays even.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.animation.markers.fap import faps
from visualspeech.animation.markers.layouts import IDENTITY, Frame, Layout, frame_of
from visualspeech.animation.markers.live_link import channels
from visualspeech.errors import DataError
from visualspeech.timing import frame_times

PERCENTILE = 99.0
IDLE_SHARE = 0.1  # of the frames: the quietest ones
_WINDOW = 0.2  # seconds of sound that decide whether a frame is quiet
_STILL = 6e-3  # range of a mean marker of a control, as a share of the face's size, below which it is measurement noise
_SIDES = (("Left", "Right"), ("_l_", "_r_"))


@dataclass(frozen=True)
class Controls:
    """Linear controls: ``values = clip(weights . (points - origin))``.

    Parameters
    ----------
    names : (K,) of the controls
    origin : (P, d)
    weights : (K, P, d)
    least, most : (K,) bounds
    """

    names: tuple[str, ...]
    origin: np.ndarray
    weights: np.ndarray
    least: np.ndarray
    most: np.ndarray


@dataclass(frozen=True)
class Actor:
    """The idle face of an actor and the controls of its motion.

    Parameters
    ----------
    markers : (P,) names
    idle : (P, d)
    frame : axes and roles of the idle face
    fap, live_link : controls of either system
    """

    markers: tuple[str, ...]
    idle: np.ndarray
    frame: Frame
    fap: Controls
    live_link: Controls

    def faps(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """MPEG-4 parameters, name -> (T,), of points (T, P, d); what the actor never moves is missing."""
        return self._driven(self.fap, points)

    def blend_shapes(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Channels of Live Link Face, name -> (T,), of points (T, P, d)."""
        return self._driven(self.live_link, points)

    def _driven(self, controls: Controls, points: np.ndarray) -> dict[str, np.ndarray]:
        points = np.asarray(points, float)
        if points.shape[1:] != self.idle.shape:
            raise DataError(f"points of the shape {points.shape[1:]} do not fit an actor of {self.idle.shape}.")
        values = np.tensordot(points - controls.origin, controls.weights, axes=([1, 2], [1, 2]))
        values = np.clip(values, controls.least, controls.most)
        return {name: values[:, column] for column, name in enumerate(controls.names)}


def fit_actor(layout: Layout, names: Sequence[str], points: np.ndarray, quiet: np.ndarray) -> Actor:
    """The actor of recorded points.

    Parameters
    ----------
    layout : of the markers
    names : (P,) of the markers
    points : (N, P, d) recorded frames, in any order
    quiet : (N,) loudness about each frame (:func:`loudness`); the mean of the quietest tenth is the idle face

    Raises
    ------
    DataError
        There is no frame.
    """
    points = np.asarray(points, float)
    if not len(points):
        raise DataError("the range of an actor needs recorded frames, and there is none.")
    count = max(1, int(round(IDLE_SHARE * len(points))))
    idle = points[np.argsort(quiet, kind="stable")[:count]].mean(axis=0)
    frame = frame_of(layout, names, idle)
    moved = points - idle
    size = float(np.linalg.norm(np.ptp(idle, axis=0))) if idle.shape[1] > 1 else 1.0
    bounds = {name: (-one.limit if one.negative else 0, one.limit, one.range) for name, one in faps().items()}
    shapes = {name: (0.0, 1.0, most) for name, most in channels().items()}
    if layout.live_link == IDENTITY:
        live_link = _identity([name for name in names if name in shapes], frame, idle)
    else:
        live_link = _fitted(layout.live_link, shapes, frame, idle, moved, size)
    return Actor(tuple(names), idle, frame, _fitted(layout.fap, bounds, frame, idle, moved, size), live_link)


def _fitted(movements: Mapping, bounds: Mapping, frame: Frame, idle, moved: np.ndarray, size: float) -> Controls:
    """Controls whose range in recorded displacements ``moved`` (N, P, d) is that of ``bounds``.

    Parameters
    ----------
    bounds : name -> least, most, range
    size : of the face
    """
    weights, ranges, still = {}, {}, {}
    for name, movement in movements.items():
        directions = {key: value for key, value in movement.items() if key != "like"}
        if not _possible(directions, frame):
            continue
        weights[name] = _weights(directions, frame, moved.shape[1:])
        values = np.tensordot(moved, weights[name], axes=([1, 2], [0, 1]))
        if bounds[name][0] >= 0:
            values = np.maximum(values, 0)
        ranges[name] = float(np.percentile(np.abs(values), PERCENTILE))
        markers = sum(abs(weight) for one in directions.values() for weight in one.values())
        still[name] = ranges[name] <= _STILL * size * markers
    kept, scales = [], []
    for name in weights:
        scale_of = movements[name].get("like", name)
        pair = {scale_of, _other_side(scale_of)} & set(ranges)
        widest = max(ranges[one] for one in pair)
        if not all(still[one] for one in pair) and bounds[scale_of][2] > 0:
            kept.append(name)
            scales.append(bounds[scale_of][2] / widest)
    shape = (len(kept), *moved.shape[1:])
    stacked = np.array([scale * weights[name] for name, scale in zip(kept, scales, strict=True)]).reshape(shape)
    limits = np.array([bounds[name][:2] for name in kept], float).reshape(-1, 2)
    return Controls(tuple(kept), idle, stacked, limits[:, 0], limits[:, 1])


def _possible(directions: Mapping, frame: Frame) -> bool:
    """Whether the points have the directions of a movement: flat ones do not move forward."""
    return not ({"forward", "back"} & set(directions) and "forward" not in frame.axes)


def _weights(directions: Mapping, frame: Frame, shape: tuple[int, int]) -> np.ndarray:
    weights = np.zeros(shape)
    for direction, markers in directions.items():
        for marker, weight in markers.items():
            weights[frame.index[marker]] += weight * frame.direction(direction)
    return weights


def _identity(names: Iterable[str], frame: Frame, idle: np.ndarray) -> Controls:
    """Channels as they are; rotations have no bounds."""
    names = tuple(names)
    weights = np.zeros((len(names), *idle.shape))
    for row, name in enumerate(names):
        weights[row, frame.index[name], 0] = 1.0
    return Controls(names, np.zeros_like(idle), weights, np.full(len(names), -np.inf), np.full(len(names), np.inf))


def _other_side(name: str) -> str:
    for left, right in _SIDES:
        if left in name:
            return name.replace(left, right)
        if right in name:
            return name.replace(right, left)
    return name


def loudness(samples: np.ndarray, sample_rate: float, frames: int, rate: float) -> np.ndarray:
    """Mean square (frames,) of the sound in 0.2 s about each frame; frames without sound count as silent."""
    total = np.concatenate([[0.0], np.cumsum(np.asarray(samples, float) ** 2)])
    edges = frame_times(frames, rate)[:, None] + np.array([-0.5, 0.5]) * _WINDOW
    first, last = np.clip(np.rint(edges * sample_rate), 0, len(samples)).astype(int).T
    return (total[last] - total[first]) / np.maximum(last - first, 1)
