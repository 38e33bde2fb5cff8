"""A pinhole camera in front of a head: projection, its derivatives, and estimation of the pose from image points.

Coordinates: image x right, y down in pixels from the image's top left corner; camera x right, y down, z away from
the camera; a head point X (in head coordinates) lies at ``R X + t`` and is seen at ``focal (x, y) / z + centre``.
Rotations are Rodrigues vectors (axis times angle in radians). All functions work on a batch of T frames at once.
"""

import numpy as np


def rotation_matrices(vectors: np.ndarray) -> np.ndarray:
    """Rotation matrices (..., 3, 3) of Rodrigues vectors (..., 3)."""
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    cross = skew(vectors)
    # sin(a)/a and (1 - cos(a))/a^2, both smooth at 0
    first = np.sinc(angle / np.pi)
    second = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + first * cross + second * (cross @ cross)


def rotation_vectors(matrices: np.ndarray) -> np.ndarray:
    """Rodrigues vectors (T, 3) of rotation matrices (T, 3, 3); the inverse of :func:`rotation_matrices`."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(matrices).as_rotvec()


def skew(vectors: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) whose product with a vector is the cross product with ``vectors`` (..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def project(model: np.ndarray, rotation: np.ndarray, translation: np.ndarray, focal: float, centre) -> np.ndarray:
    """Image points (T, n, 2) of head points ``model`` (n, 3) or (T, n, 3) under poses (T, 3), (T, 3)."""
    seen = model @ np.swapaxes(rotation_matrices(rotation), -1, -2) + translation[:, None]
    return focal * seen[..., :2] / seen[..., 2:] + np.asarray(centre)


def point_jacobian(seen: np.ndarray, focal: float) -> np.ndarray:
    """Derivative (..., 2, 3) of the image point with respect to the camera coordinates ``seen`` (..., 3)."""
    x, y, z = np.moveaxis(seen, -1, 0)
    zero = np.zeros_like(x)
    return focal * np.stack(
        [np.stack([1 / z, zero, -x / z**2], -1), np.stack([zero, 1 / z, -y / z**2], -1)],
        axis=-2,
    )


def solve_pose(
    points: np.ndarray,
    model: np.ndarray,
    focal: float,
    centre,
    weights: np.ndarray | None = None,
    start: tuple[np.ndarray, np.ndarray] | None = None,
    iterations: int = 15,
    robust: float = 3.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Perspective-n-point by damped Gauss-Newton steps, for T frames at once.

    Parameters
    ----------
    points : (T, n, 2) image pixels
    model : (n, 3) the same points in head coordinates
    weights : (n,) weight of each point in the squared error
    start : rotation (T, 3) and translation (T, 3) to start from; by default facing the camera, with the translation
        that fits
    robust : errors beyond this many median absolute errors of the frame get less weight (Huber); 0 for least squares

    Returns
    -------
    rotation (T, 3), translation (T, 3)
    """
    centre = np.asarray(centre, float)
    weights = np.ones(len(model)) if weights is None else np.asarray(weights, float)
    rotation, translation = start if start is not None else facing(points, model, focal, centre)
    matrix = rotation_matrices(rotation)
    damping = np.full(len(points), 1e-3)
    for _ in range(iterations):
        turned = model @ np.swapaxes(matrix, -1, -2)
        seen = turned + translation[:, None]
        residual = points - (focal * seen[..., :2] / seen[..., 2:] + centre)
        limit = _limit(residual, robust)
        factor, error = _huber(residual, weights, limit)
        # A small rotation w applied after R moves a point by w x (R X) = -skew(R X) w.
        by_point = point_jacobian(seen, focal)
        jacobian = np.concatenate([-by_point @ skew(turned), by_point], axis=-1)
        weighted = jacobian * factor[..., None, None]
        normal = np.einsum("tnij,tnik->tjk", weighted, jacobian)
        gradient = np.einsum("tnij,tni->tj", weighted, residual)
        diagonal = np.einsum("tjj->tj", normal)
        step = np.linalg.solve(normal + damping[:, None, None] * _diagonals(diagonal), gradient[..., None])[..., 0]
        new_matrix = rotation_matrices(step[:, :3]) @ matrix
        new_translation = translation + step[:, 3:]
        new_seen = model @ np.swapaxes(new_matrix, -1, -2) + new_translation[:, None]
        new_residual = points - (focal * new_seen[..., :2] / new_seen[..., 2:] + centre)
        _, new_error = _huber(new_residual, weights, limit)
        better = (new_error <= error) & (new_seen[..., 2].min(-1) > 0)
        matrix = np.where(better[:, None, None], new_matrix, matrix)
        translation = np.where(better[:, None], new_translation, translation)
        damping = np.clip(np.where(better, damping / 10, damping * 10), 1e-9, 1e9)
        if np.abs(step).max(initial=0) < 1e-9:
            break
    return rotation_vectors(matrix), translation


def facing(points: np.ndarray, model: np.ndarray, focal: float, centre) -> tuple[np.ndarray, np.ndarray]:
    """A first guess of the pose: no rotation, and the translation that gives the points' centre and size."""
    middle = model.mean(0)
    size = np.sqrt(((model - middle)[:, :2] ** 2).sum(1).mean())
    there = points.mean(1)
    spread = np.sqrt(((points - there[:, None]) ** 2).sum(2).mean(1))
    depth = focal * size / np.maximum(spread, 1e-6)
    beside = (there - np.asarray(centre)) * depth[:, None] / focal
    return np.zeros((len(points), 3)), np.column_stack([beside, depth]) - middle


def solve_translation(
    points: np.ndarray, model: np.ndarray, rotation: np.ndarray, depth: np.ndarray, focal: float, centre, weights
) -> np.ndarray:
    """Translations (T, 3) that fit the points best when rotation (T, 3) and depth (T,) are given (least squares)."""
    turned = model @ np.swapaxes(rotation_matrices(rotation), -1, -2)
    away = turned[..., 2] + depth[:, None]
    wanted = (points - np.asarray(centre)) * away[..., None] / focal - turned[..., :2]
    # The error is measured in image pixels, so distant points get less weight.
    share = weights / away**2
    beside = (wanted * share[..., None]).sum(1) / share.sum(1, keepdims=True)
    return np.column_stack([beside, depth])


def _limit(residual: np.ndarray, robust: float) -> np.ndarray:
    """Error in pixels (T, 1) beyond which a point is an outlier of its frame."""
    if robust <= 0:
        return np.full((len(residual), 1), np.inf)
    # Below half a pixel, rounding of the landmarks would decide which points are outliers.
    return np.maximum(robust * np.median(np.linalg.norm(residual, axis=-1), axis=1), 0.5)[:, None]


def _huber(residual: np.ndarray, weights: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights (T, n) of a re-weighted least-squares step, and the cost (T,) that the step must not increase."""
    size = np.linalg.norm(residual, axis=-1)
    factor = np.minimum(1, limit / np.maximum(size, 1e-12))
    with np.errstate(invalid="ignore"):
        cost = np.where(size <= limit, size**2, 2 * limit * size - limit**2)
    return weights * factor, (weights * cost).sum(1)


def _diagonals(values: np.ndarray) -> np.ndarray:
    return values[:, :, None] * np.eye(values.shape[1])
