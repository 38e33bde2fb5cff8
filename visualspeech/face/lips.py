"""The opening of the mouth: how far the inner contours of the lips are apart in a face of a visual coding."""

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.point_sets import PointSet, to_points


def has_inner_lips(points: PointSet) -> bool:
    """Whether the opening of the mouth can be told from a point set."""
    return len(points.regions.get("inner_lips", ())) > 0


def opening_weights(points: PointSet) -> np.ndarray:
    """Weights (N,) of the vertical coordinates of the points, whose sum is the opening: a linear function of the face.

    The opening is the mean height of the lower inner lip below the upper one, corners left out; positive where the
    mouth is open. The mean over all points of a lip varies less with the errors of a landmark tracker than the
    distance of two points.
    """
    ring, (right, left) = list(points.regions["inner_lips"]), points.mouth_corners
    start = ring.index(right)
    ring = ring[start:] + ring[:start]
    upper, lower = ring[1 : ring.index(left)], ring[ring.index(left) + 1 :]
    weights = np.zeros(points.size)
    weights[upper] = -1 / len(upper)
    weights[lower] = 1 / len(lower)
    return weights


def lip_opening(faces: np.ndarray, points: PointSet) -> np.ndarray:
    """Opening of the mouth (T,) in the unit of the points of faces (T, N, 2).

    Raises
    ------
    DataError
        The faces are not those of the point set.
    """
    faces = np.asarray(faces, np.float64)
    if faces.shape[-2:] != (points.size, 2):
        raise DataError(f"expected the {points.size} points of {points.name}, got faces of shape {faces.shape}")
    return faces[..., 1] @ opening_weights(points)


def opening_stream(shape: np.ndarray, points: PointSet) -> dict[str, np.ndarray]:
    """The opening (T,) float32 of shape vectors (T, 2N), under its name in files; empty without inner lips."""
    if not has_inner_lips(points):
        return {}
    return {"opening": lip_opening(to_points(shape), points).astype(np.float32)}
