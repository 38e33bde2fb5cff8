"""The 51 points of the lower face (Fan 2015, section 3.2 and Fig. 2a) and the mesh that joins them.

The paper shows its points without listing them. Here: the jaw line (17), the nose (9) and the lips (20) of the
68-point iBUG scheme, which speech moves or which hold the region in place, and five points of the cheeks and the chin
hollow that no tracker gives. The five are means of tracked points: they add no freedom to the shape, they give the mesh
corners where there is skin without landmarks. Eyes and brows are left out: they blink and rise independently of speech.
The drawing is ``docs/points.png``.
"""

import numpy as np

from visualspeech.errors import DataError

POINTS = 51
JAW = slice(0, 17)
NOSE = slice(17, 26)
LIPS = slice(26, 46)
OUTER_LIPS = slice(26, 38)
INNER_LIPS = slice(38, 46)
DERIVED = slice(46, 51)

TRACKED = np.concatenate([np.arange(0, 17), np.arange(27, 36), np.arange(48, 68)])
"""Which of the 68 points the first 46 are."""

FREEDOM = 2 * len(TRACKED)
"""How many ways a shape can vary at most: the derived points move with the others."""

_MEANS = (
    (1, 30),  # below the right eye of the person: between jaw line and tip of the nose
    (15, 30),  # below the left eye
    (4, 31, 48),  # right cheek: jaw line, wing of the nose, corner of the mouth
    (12, 35, 54),  # left cheek
    (8, 57),  # chin hollow: chin and lower lip
)

LOWERED = np.zeros(POINTS)
LOWERED[[34, 35, 36, 43, 44, 45, 7, 8, 9, 50]] = 1.0
LOWERED[[33, 37, 6, 10]] = 0.7
LOWERED[[5, 11]] = 0.4
"""How far each point follows the jaw down: lower lip, chin and chin hollow fully, towards the corners less."""

OUTLINE = np.array([*range(17), 47, 17, 46])
"""The points around the region, in order: along the jaw, then over the cheeks below the eyes and the nose bridge."""

# Corners of the triangles, each in the same turn (clockwise on the screen, where y points down). A Delaunay
# triangulation of a symmetric face with slightly open mouth that keeps both lip contours; fixed, so that every corpus
# has the same mesh. The last six fill the mouth.
# fmt: off
TRIANGLES = np.array([
    (0, 46, 1), (1, 46, 2), (2, 46, 3), (3, 46, 48), (3, 48, 4), (4, 48, 5), (5, 26, 6), (5, 48, 26), (6, 26, 37),
    (6, 37, 7), (7, 36, 50), (7, 37, 36), (7, 50, 8), (8, 50, 9), (9, 33, 10), (9, 34, 33), (9, 50, 34), (10, 32, 11),
    (10, 33, 32), (11, 32, 49), (11, 49, 12), (12, 49, 13), (13, 47, 14), (13, 49, 47), (14, 47, 15), (15, 47, 16),
    (17, 18, 46), (17, 47, 18), (18, 19, 46), (18, 47, 19), (19, 20, 21), (19, 21, 46), (19, 25, 20), (19, 47, 25),
    (20, 22, 21), (20, 23, 22), (20, 24, 23), (20, 25, 24), (21, 22, 27), (21, 27, 48), (21, 48, 46), (22, 23, 28),
    (22, 28, 27), (23, 24, 30), (23, 29, 28), (23, 30, 29), (24, 25, 31), (24, 31, 30), (25, 47, 49), (25, 49, 31),
    (26, 27, 38), (26, 38, 37), (26, 48, 27), (27, 28, 39), (27, 39, 38), (28, 29, 39), (29, 30, 41), (29, 40, 39),
    (29, 41, 40), (30, 31, 41), (31, 32, 42), (31, 42, 41), (31, 49, 32), (32, 33, 42), (33, 34, 43), (33, 43, 42),
    (34, 35, 44), (34, 44, 43), (34, 50, 35), (35, 36, 44), (35, 50, 36), (36, 37, 45), (36, 45, 44), (37, 38, 45),
    (38, 39, 45), (39, 40, 45), (40, 41, 43), (40, 43, 44), (40, 44, 45), (41, 42, 43),
], dtype=np.int32)
# fmt: on


def _selection() -> np.ndarray:
    weights = np.zeros((POINTS, 68))
    weights[np.arange(len(TRACKED)), TRACKED] = 1
    for row, parents in enumerate(_MEANS, start=DERIVED.start):
        weights[row, list(parents)] = 1 / len(parents)
    return weights


SELECTION = _selection()
"""The linear map from the 68 tracked points to the 51 points, (51, 68); its rows sum to 1."""


def lower_face(points68: np.ndarray) -> np.ndarray:
    """The 51 lower-face points of tracked faces, (..., 68, 2) -> (..., 51, 2), in the units of the input.

    Linear, so it works alike on image points and on pose-normalised points, and commutes with every affine map.

    Raises
    ------
    DataError
        The input does not end in (68, 2).
    """
    points68 = np.asarray(points68)
    if points68.shape[-2:] != (68, 2):
        raise DataError(f"expected 68 points with x and y, shape (..., 68, 2), got {points68.shape}")
    return (SELECTION.astype(points68.dtype) @ points68).astype(points68.dtype)


def to_vector(points: np.ndarray) -> np.ndarray:
    """Points (..., N, 2) as shape vectors (x_1, ..., x_N, y_1, ..., y_N) (Fan 2015, Eq. 1), (..., 2N)."""
    points = np.asarray(points)
    return np.concatenate([points[..., 0], points[..., 1]], axis=-1)


def to_points(shape: np.ndarray) -> np.ndarray:
    """The inverse of :func:`to_vector`: (..., 2N) -> (..., N, 2)."""
    shape = np.asarray(shape)
    half = shape.shape[-1] // 2
    return np.stack([shape[..., :half], shape[..., half:]], axis=-1)
