"""The demo head in space: a smooth surface behind the canonical picture, turned, shifted and projected.

Coordinates are canonical pixels: x to the right, y down, z away from the camera, the origin in the middle of the
picture. The camera stands ``DISTANCE`` before the origin; its focal length is the same, so that the resting head
(no rotation, no translation) is projected onto itself.
"""

import numpy as np

from visualspeech.corpora.demo.portrait import HEIGHT, MIDDLE

DISTANCE = 1100.0
CENTRE = np.array([MIDDLE, (HEIGHT - 1) / 2])
PIVOT = np.array([0.0, 95.0, 35.0])  # the neck, about which the head turns


def depth(points: np.ndarray) -> np.ndarray:
    """z of the face's surface at canonical points (..., 2); the nose stands out."""
    x, y = points[..., 0] - MIDDLE, points[..., 1]
    skull = 95 * np.exp(-(x**2) / (2 * 62**2) - (y - 175) ** 2 / (2 * 105**2))
    tip = 18 * np.exp(-(x**2) / (2 * 12**2) - (y - 191) ** 2 / (2 * 13**2))
    ridge = 9 * np.exp(-(x**2) / (2 * 10**2) - (y - 172) ** 2 / (2 * 20**2))
    return 60.0 - skull - tip - ridge


def surface(points: np.ndarray) -> np.ndarray:
    """Points in space (..., 3) that the resting head shows at canonical points (..., 2)."""
    z = depth(points)
    return np.concatenate([(points - CENTRE) * (1 + z / DISTANCE)[..., None], z[..., None]], axis=-1)


def rotation_matrix(vector: np.ndarray) -> np.ndarray:
    """Rodrigues vector (3,) to matrix (3, 3)."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def project(points: np.ndarray, rotation: np.ndarray, translation: np.ndarray) -> np.ndarray:
    """Where canonical points (..., 2) appear in the picture: (..., 2) pixels.

    ``rotation`` is a Rodrigues vector (radians) about the pivot, ``translation`` (3,) in canonical pixels.
    """
    turned = (surface(points) - PIVOT) @ rotation_matrix(rotation).T + PIVOT + translation
    return CENTRE + turned[..., :2] / (1 + turned[..., 2:] / DISTANCE)


def unproject(pixels: np.ndarray, rotation: np.ndarray, translation: np.ndarray, steps: int = 4) -> np.ndarray:
    """The inverse of :func:`project` by fixed-point iteration, which shrinks the error about fivefold a step."""
    points = pixels.copy()
    for _ in range(steps):
        points += pixels - project(points, rotation, translation)
    return points
