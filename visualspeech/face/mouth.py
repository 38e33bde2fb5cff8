"""The mouth of a tracked or decoded face: which of its points are lips, and how far and how wide the mouth is open.

Faces of different visual codings have different points. Lips are therefore found by the names of their points, and
always in one order, so that those of one coding can be compared with those of another and with the recorded ones.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from visualspeech.face.markers import LANDMARK_NAMES
from visualspeech.face.point_sets import LANDMARKS

#: Outer corners of the eyes among the 68 landmarks (right, left).
EYES = (36, 45)


@dataclass(frozen=True)
class Mouth:
    """Indices of the lips among the points of a face.

    Parameters
    ----------
    lips : all lip points, in one order for all faces that are compared
    corners : right and left corner of the mouth; empty where the face has none
    upper, lower : the lips on either side of the opening, corners left out; empty where the opening cannot be told
    """

    lips: tuple[int, ...] = ()
    corners: tuple[int, ...] = ()
    upper: tuple[int, ...] = ()
    lower: tuple[int, ...] = ()

    def opening(self, points: np.ndarray) -> np.ndarray:
        """How far the lips are apart, (T,) in the unit of points (T, P, d).

        In an image, how far the mean of the lower points lies below that of the upper ones, the same quantity as
        :func:`visualspeech.face.lips.lip_opening`; in space, their distance.
        """
        points = np.asarray(points, np.float64)
        apart = points[:, list(self.lower)].mean(axis=1) - points[:, list(self.upper)].mean(axis=1)
        return apart[:, 1] if points.shape[2] == 2 else np.linalg.norm(apart, axis=1)

    def width(self, points: np.ndarray) -> np.ndarray:
        """Distance of the corners of the mouth, (T,) in the unit of points (T, P, d)."""
        right, left = (np.asarray(points, np.float64)[:, corner] for corner in self.corners)
        return np.linalg.norm(left - right, axis=1)


@dataclass(frozen=True)
class MouthNames:
    """Names of the lip points of a recorded face: the parts of a :class:`Mouth`.

    Parameters
    ----------
    inner : whether upper and lower points lie on the inner lips, so that closed lips can be told
    """

    lips: tuple[str, ...] = ()
    corners: tuple[str, ...] = ()
    upper: tuple[str, ...] = ()
    lower: tuple[str, ...] = ()
    inner: bool = False

    def among(self, names: Sequence[str]) -> Mouth:
        """The mouth of a face whose points have these names; without a part of which a point is missing."""
        at = {name: number for number, name in enumerate(names)}
        parts = {one.name: getattr(self, one.name) for one in fields(Mouth)}
        return Mouth(**{part: tuple(at[one] for one in own) for part, own in parts.items() if set(own) <= set(at)})


def _landmarks(*numbers: int) -> tuple[str, ...]:
    return tuple(LANDMARK_NAMES[number] for number in numbers)


#: Of the 68-point iBUG scheme: all lips, the corners of the outer lips, the inner lips without their corners.
LANDMARK_MOUTH = MouthNames(
    _landmarks(*range(48, 68)), _landmarks(48, 54), _landmarks(61, 62, 63), _landmarks(65, 66, 67), inner=True
)
#: Markers of IEMOCAP: around the outer lips, and those between whose means the directions right to left and down to up
#: lie. What a number inside a group stands for is read off the mean face.
_MOUTH_MARKERS = tuple(f"mou{number}" for number in range(1, 9))
_ACROSS = (tuple(f"rc{number}" for number in range(1, 9)), tuple(f"lc{number}" for number in range(1, 9)))
_UPWARDS = (("ch1", "ch2", "ch3"), ("fh1", "fh2", "fh3"))


def find_mouth(names: Sequence[str], mean_face: Callable[[], np.ndarray]) -> MouthNames:
    """The mouth of recorded faces whose points have these names; empty where none is known by its names.

    Parameters
    ----------
    names : of P landmarks, markers or channels
    mean_face : gives the mean (P, d) of the training utterances; called only for markers
    """
    if set(LANDMARK_MOUTH.lips) <= set(names):
        return LANDMARK_MOUTH
    at = {name.lower(): number for number, name in enumerate(names)}
    needed = {*_MOUTH_MARKERS, *(name for ends in (*_ACROSS, *_UPWARDS) for name in ends)}
    if not needed <= set(at):
        return MouthNames()
    face = np.asarray(mean_face(), np.float64)
    across, upwards = (
        np.subtract(*(face[[at[name] for name in end]].mean(axis=0) for end in reversed(ends)))
        for ends in (_ACROSS, _UPWARDS)
    )
    along = {name: float(face[at[name]] @ across) for name in _MOUTH_MARKERS}
    right, *between, left = sorted(_MOUTH_MARKERS, key=along.get)
    *lower, third, fourth, fifth, sixth = sorted(between, key=lambda name: float(face[at[name]] @ upwards))
    lower, upper = (*lower, third), (fourth, fifth, sixth)
    parts = (_MOUTH_MARKERS, (right, left), upper, lower)
    return MouthNames(*(tuple(names[at[name]] for name in part) for part in parts))


def point_names(coding) -> tuple[str, ...]:
    """Names of the points that a visual coding (:class:`~visualspeech.face.coding.VisualCoding`) decodes to, (P,).

    Points of a point set that are no landmarks have no name.
    """
    if coding.points is None:
        return coding.markers.names
    return tuple(
        LANDMARK_NAMES[int(np.argmax(row))] if np.count_nonzero(row) == 1 else "" for row in coding.points.selection
    )


def eye_distance(points: np.ndarray) -> float:
    """Distance of the outer corners of the eyes of a face (68, 2), in its unit."""
    if np.shape(points) != (LANDMARKS, 2):
        raise ValueError(f"expected a face of {LANDMARKS} landmarks, got {np.shape(points)}")
    right, left = (np.asarray(points, np.float64)[corner] for corner in EYES)
    return float(np.linalg.norm(left - right))
