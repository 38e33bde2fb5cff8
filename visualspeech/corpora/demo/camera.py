"""The demo head in three dimensions: a smooth surface behind the canonical image, rotated, translated and projected.

Coordinates are canonical pixels: x to the right, y down, z away from the camera, with the origin at the centre of the
image. The camera is at ``DISTANCE`` in front of the origin and has the same focal length, so the head at rest (no
rotation, no translation) is projected onto itself.
"""

import numpy as np

from visualspeech.corpora.demo.portrait import HEIGHT, MIDDLE

DISTANCE = 1100.0
CENTRE = np.array([MIDDLE, (HEIGHT - 1) / 2])
PIVOT = np.array([0.0, 95.0, 35.0])  # the neck, about which the head turns


def depth(points: np.ndarray) -> np.ndarray:
    """Depth z (...) of the face's surface at canonical points (..., 2)."""
    x, y = points[..., 0] - MIDDLE, points[..., 1]
    skull = 95 * np.exp(-(x**2) / (2 * 62**2) - (y - 175) ** 2 / (2 * 105**2))
    tip = 18 * np.exp(-(x**2) / (2 * 12**2) - (y - 191) ** 2 / (2 * 13**2))
    ridge = 9 * np.exp(-(x**2) / (2 * 10**2) - (y - 172) ** 2 / (2 * 20**2))
    return 60.0 - skull - tip - ridge


def surface(points: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the head at rest that appear at canonical points (..., 2)."""
    z = depth(points)
    return np.concatenate([(points - CENTRE) * (1 + z / DISTANCE)[..., None], z[..., None]], axis=-1)


def rotation_matrix(vector: np.ndarray) -> np.ndarray:
    """Rotation matrix (3, 3) of a Rodrigues vector (3,)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def project(points: np.ndarray, rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
    """Positions (..., 2) in the frame, in pixels, of canonical points (..., 2).

    Parameters
    ----------
    rotation : (3,) Rodrigues vector in radians, about the pivot
    translation : (3,) in canonical pixels
    """
    turned = (surface(points) - PIVOT) @ rotation_matrix(rotation).T + PIVOT + translation
    return CENTRE + turned[..., :2] / (1 + turned[..., 2:] / DISTANCE)


def unproject(pixels: np.ndarray, rotation: np.ndarray, translation: np.ndarray, steps: int = 4) -> np.ndarray:
    """The inverse of :func:`project`, by fixed-point iteration; each step divides the error by about five."""
    points = pixels.copy()
    for _ in range(steps):
        points += pixels - project(points, rotation, translation)
    return points
