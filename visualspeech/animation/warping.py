"""How the surroundings of a mouth move when the mouth is put elsewhere: a smooth backward map.

Points of the recorded face are to lie at the target's places; what is between and around them follows smoothly and
comes to rest at a stated distance, so that there is one jaw, no hole below it, and no movement in the background. The
displacement is a sum of compactly supported radial functions (H. Wendland 1995, the positive definite one that is
twice continuously differentiable) and is exactly zero beyond their reach.
"""

import numpy as np


def wendland(distance: np.ndarray) -> np.ndarray:
    """Wendland's function of a distance in units of the reach: 1 at 0, smoothly 0 from 1 on."""
    inside = np.maximum(1 - distance, 0)
    inside *= inside
    return inside * inside * (4 * distance + 1)


def displacement(
    places: np.ndarray, points: np.ndarray, moves: np.ndarray, reach: float, stiffness: float
) -> np.ndarray:
    """The smooth displacement at some places that has given values at given points.

    Parameters
    ----------
    places : (n, 2) where it is wanted, in pixels
    points : (m, 2) where it is known, in pixels
    moves : (m, 2) its values there, in pixels
    reach : pixels from a point to where its influence ends
    stiffness : ridge on the coefficients; 0 meets the values exactly, more bends less between crowded points

    Returns
    -------
    (n, 2) float32
    """
    points = np.asarray(points, np.float64)
    gram = wendland(np.linalg.norm(points[:, None] - points[None], axis=2) / reach)
    coefficients = np.linalg.solve(gram + stiffness * np.eye(len(points)), moves).astype(np.float32)
    scaled = np.asarray(places, np.float32) / np.float32(reach)
    centres = (points / reach).astype(np.float32)
    x = scaled[:, None, 0] - centres[None, :, 0]
    y = scaled[:, None, 1] - centres[None, :, 1]
    return wendland(np.sqrt(x * x + y * y)) @ coefficients


def backward_map(
    origin: tuple[int, int],
    size: tuple[int, int],
    points: np.ndarray,
    moves: np.ndarray,
    reach: float,
    stiffness: float,
    step: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Where each pixel of a window comes from.

    The displacement is evaluated at every ``step``-th pixel and interpolated between: it is smooth over many pixels.

    Parameters
    ----------
    origin : (x, y) of the window's first pixel
    size : (width, height) of the window
    points, moves : ``points`` (m, 2) shall show what now is at ``points - moves``

    Returns
    -------
    x and y maps for ``cv2.remap``, each (height, width) float32
    """
    import cv2

    width, height = size
    columns, rows = -(-width // step) + 1, -(-height // step) + 1
    xs = origin[0] + step * np.arange(columns, dtype=np.float32)
    ys = origin[1] + step * np.arange(rows, dtype=np.float32)
    places = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    coarse = displacement(places, points, moves, reach, stiffness).reshape(rows, columns, 2)
    # An affine enlargement that puts coarse sample (i, j) at pixel (i step, j step).
    enlarge = np.array([[1 / step, 0, 0], [0, 1 / step, 0]])
    fine = cv2.warpAffine(coarse, enlarge, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    x = origin[0] + np.arange(width, dtype=np.float32)[None] - fine[..., 0]
    y = origin[1] + np.arange(height, dtype=np.float32)[:, None] - fine[..., 1]
    return x, y
