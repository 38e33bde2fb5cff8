"""Smooth warp of the lower face and its surroundings, as a backward map.

Points of the recorded face are moved to the positions of the target. The frame between and around them follows smoothly
and is unchanged beyond a given distance, so that there is one jaw, no hole below it, and no movement in the background.
The displacement is a sum of compactly supported radial functions (H. Wendland 1995, the positive definite one that is
twice continuously differentiable) and is exactly zero beyond their reach.
"""

import numpy as np


def wendland(distance: np.ndarray) -> np.ndarray:
    """Wendland's function of a distance in units of the reach: 1 at distance 0, 0 from distance 1 on."""
    inside = np.maximum(1 - distance, 0)
    inside *= inside
    return inside * inside * (4 * distance + 1)


def displacement(
    positions: np.ndarray, points: np.ndarray, moves: np.ndarray, reach: float, stiffness: float
) -> np.ndarray:
    """Smooth displacement at positions, interpolated from given displacements at points.

    Parameters
    ----------
    positions : (n, 2) in pixels
    points : (m, 2) in pixels
    moves : (m, 2) displacements at the points, in pixels
    reach : distance in pixels at which the influence of a point ends
    stiffness : ridge penalty on the coefficients; with 0 the displacements are met exactly, larger values are smoother
        between close points

    Returns
    -------
    (n, 2) float32
    """
    points = np.asarray(points, np.float64)
    gram = wendland(np.linalg.norm(points[:, None] - points[None], axis=2) / reach)
    coefficients = np.linalg.solve(gram + stiffness * np.eye(len(points)), moves).astype(np.float32)
    scaled = np.asarray(positions, np.float32) / np.float32(reach)
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
    """Source position of each pixel of a window.

    The displacement is smooth, so it is evaluated at every ``step``-th pixel and interpolated in between.

    Parameters
    ----------
    origin : (x, y) of the window's first pixel
    size : (width, height) of the window
    points, moves : (m, 2) each; what is at ``points - moves`` moves to ``points``
    reach, stiffness : see :func:`displacement`

    Returns
    -------
    x and y maps for ``cv2.remap``, each (height, width) float32
    """
    import cv2

    width, height = size
    columns, rows = -(-width // step) + 1, -(-height // step) + 1
    xs = origin[0] + step * np.arange(columns, dtype=np.float32)
    ys = origin[1] + step * np.arange(rows, dtype=np.float32)
    nodes = np.stack(np.meshgrid(xs, ys), axis=-1).reshape(-1, 2)
    coarse = displacement(nodes, points, moves, reach, stiffness).reshape(rows, columns, 2)
    # This affine map places coarse sample (i, j) at pixel (i step, j step).
    enlarge = np.array([[1 / step, 0, 0], [0, 1 / step, 0]])
    fine = cv2.warpAffine(coarse, enlarge, (width, height), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    x = origin[0] + np.arange(width, dtype=np.float32)[None] - fine[..., 0]
    y = origin[1] + np.arange(height, dtype=np.float32)[:, None] - fine[..., 1]
    return x, y
