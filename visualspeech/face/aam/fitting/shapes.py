"""Shapes under a global similarity: s = R (s_0 + P p) + t, and their infinitesimal changes.

With P orthogonal to the four shapes that a similarity makes of s_0 (larger, turned, moved along x and y), similarity
and shape separate: both have a closed form for any given points (Matthews and Baker 2004, section 4.3).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from visualspeech.errors import DataError


@dataclass(frozen=True)
class ShapeSpace:
    """Mean and modes of a shape without similarity transforms.

    Parameters
    ----------
    mean : (N, 2) s_0 about its own middle
    centre : (2,) that middle
    modes : (n, N, 2) P, orthonormal, orthogonal to the similarities of the mean
    deviations : (n,) standard deviation of each parameter, in the units of the shape
    """

    mean: np.ndarray
    centre: np.ndarray
    modes: np.ndarray
    deviations: np.ndarray

    @classmethod
    def of(cls, mean: np.ndarray, components: np.ndarray, variances: np.ndarray) -> "ShapeSpace":
        """From a mean (N, 2) and components (n, N, 2) with variances; similarity transforms are removed from them."""
        if components.shape[1:] != mean.shape or len(components) != len(variances):
            raise DataError(
                f"shape components {components.shape} with {len(variances)} variances and a mean {mean.shape} "
                "do not belong together"
            )
        centre = np.asarray(mean, float).mean(axis=0)
        centred = np.asarray(mean, float) - centre
        rigid = _similarities(centred).reshape(4, -1)
        spread = np.asarray(components, float).reshape(len(components), mean.size) * np.sqrt(variances)[:, None]
        spread = spread - (spread @ rigid.T) @ rigid
        _, values, rows = np.linalg.svd(spread, full_matrices=False)
        kept = values > 1e-3 * max(values[0], 1e-12) if len(values) else []
        return cls(centred, centre, rows[kept].reshape(-1, *mean.shape), values[kept])

    @cached_property
    def similarities(self) -> np.ndarray:
        """Orthonormal changes (4, N, 2) of the mean: scaling, rotation, translation along x and along y."""
        return _similarities(self.mean)

    @cached_property
    def changes(self) -> np.ndarray:
        """The basis (4 + n, N, 2) of an incremental warp's parameters: similarity and shape components."""
        return np.concatenate([self.similarities, self.modes])

    def parameters(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Similarity (T, 4) and shape parameters (T, n) of points (T, N, 2), by least squares.

        The similarity is (a, b, x, y): R = [[a, -b], [b, a]], and t = (x, y) is the position of the mean's middle.
        """
        size = np.linalg.norm(self.mean)
        middle = points.mean(axis=1)
        pair = np.einsum("tni,kni->tk", points, self.similarities[:2]) / size
        turned = _turn(points - middle[:, None], pair * [1, -1]) / np.square(pair).sum(axis=1)[:, None, None]
        shape = np.einsum("tni,kni->tk", turned - self.mean, self.modes)
        return np.concatenate([pair, middle], axis=1), shape

    def points(self, similarity: np.ndarray, shape: np.ndarray) -> np.ndarray:
        """The points (T, N, 2) of similarity (T, 4) and shape parameters (T, n)."""
        local = self.mean + np.einsum("tk,kni->tni", shape, self.modes)
        return _turn(local, similarity[:, :2]) + similarity[:, None, 2:]


def _turn(points: np.ndarray, pair: np.ndarray) -> np.ndarray:
    a, b = pair[:, 0, None], pair[:, 1, None]
    x, y = points[..., 0], points[..., 1]
    return np.stack([a * x - b * y, b * x + a * y], axis=-1)


def _similarities(centred: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(centred)
    if not size > 0:
        raise DataError("all points of the mean shape coincide; there is no face to fit")
    along = np.full(len(centred), 1 / np.sqrt(len(centred)))
    still = np.zeros(len(centred))
    return np.stack(
        [
            centred / size,
            np.stack([-centred[:, 1], centred[:, 0]], axis=1) / size,
            np.stack([along, still], axis=1),
            np.stack([still, along], axis=1),
        ]
    )
