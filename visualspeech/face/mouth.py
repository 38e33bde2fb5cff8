"""The mouth of a tracked or decoded face: which of its points are lips, and how far and how wide the mouth is open.

Faces of different visual codings have different points. A :class:`Mouth` says where the lips lie among them, always in
one order, so that lips of one coding can be compared with those of another and with the tracked ones.
"""

from dataclasses import dataclass

import numpy as np

from visualspeech.face.point_sets import LANDMARKS, PointSet

#: Landmarks of the 68-point iBUG scheme: all lips, the corners of the outer lips (right, left), and the inner lips
#: without their corners.
LIPS = tuple(range(48, 68))
CORNERS, UPPER, LOWER = (48, 54), (61, 62, 63), (65, 66, 67)
#: Outer corners of the eyes (right, left).
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

    lips: tuple[int, ...]
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


#: Of a face of all 68 landmarks.
TRACKED = Mouth(LIPS, CORNERS, UPPER, LOWER)


def mouth_of(points: PointSet) -> Mouth | None:
    """The mouth of a point set; None where it lacks a lip landmark."""
    single = np.flatnonzero(np.count_nonzero(points.selection, axis=1) == 1)
    at = {int(np.argmax(points.selection[number])): int(number) for number in single}
    if not set(LIPS) <= set(at):
        return None
    return Mouth(*(tuple(at[landmark] for landmark in part) for part in (LIPS, CORNERS, UPPER, LOWER)))


def eye_distance(points: np.ndarray) -> float:
    """Distance of the outer corners of the eyes of a face (68, 2), in its unit."""
    if np.shape(points) != (LANDMARKS, 2):
        raise ValueError(f"expected a face of {LANDMARKS} landmarks, got {np.shape(points)}")
    right, left = (np.asarray(points, np.float64)[corner] for corner in EYES)
    return float(np.linalg.norm(left - right))
