"""The piecewise-affine warp of a fitting model: its mesh and pixels, gradients in it, composition of warps.

Everything here is linear and fixed, so that a batch of frames is warped by matrix products. In the grid of a model lies
a base mesh of N points with U pixels inside. A warp gives the positions of the N points in an image; the position of a
pixel follows from its barycentric coordinates.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from visualspeech.errors import DataError


@dataclass(frozen=True)
class Mesh:
    """A base mesh and its pixels.

    Parameters
    ----------
    points : (N, 2) corners of the base mesh in grid pixels, (x, y)
    triangles : (M, 3) indices of corners
    cells : (U, 2) int, row and column of each pixel, in cells of ``spacing`` grid pixels
    weights : (U, N) float32, the position of each pixel is ``weights @ points``; rows sum to 1
    spacing : side of a pixel, in grid pixels
    """

    points: np.ndarray
    triangles: np.ndarray
    cells: np.ndarray
    weights: np.ndarray
    spacing: int = 1

    @classmethod
    def of_reference(cls, reference) -> "Mesh":
        """The mesh of the texture grid of a :class:`~visualspeech.face.aam.reference.Reference`."""
        weights = reference.weights.toarray().astype(np.float32)
        return cls(reference.grid_shape, reference.points.triangles, reference.pixels, weights)

    @classmethod
    def delaunay(cls, shape: np.ndarray, pixels: int) -> "Mesh":
        """The Delaunay triangulation of a shape (N, 2), with about the given number of pixels inside."""
        from scipy.spatial import ConvexHull, Delaunay

        scale = np.sqrt(pixels / ConvexHull(shape).volume)
        points = (shape - shape.min(axis=0)) * scale + 1
        mesh = Delaunay(points)
        width, height = np.ceil(points.max(axis=0)).astype(int) + 2
        rows, columns = (axis.ravel() for axis in np.mgrid[:height, :width])
        home = mesh.find_simplex(np.stack([columns, rows], axis=1).astype(float))
        inside = home >= 0
        home, places = home[inside], np.stack([columns[inside], rows[inside]], axis=1)
        affine = mesh.transform[home]
        two = np.einsum("uij,uj->ui", affine[:, :2], places - affine[:, 2])
        weights = np.zeros((len(home), len(points)), np.float32)
        corners = np.column_stack([two, 1 - two.sum(axis=1)])
        np.put_along_axis(weights, mesh.simplices[home].astype(np.int64), corners.astype(np.float32), axis=1)
        return cls(points, mesh.simplices, np.stack([rows[inside], columns[inside]], axis=1), weights)

    @property
    def size(self) -> int:
        """U, the number of pixels."""
        return len(self.cells)

    def coarser(self, factor: int):
        """The mesh with ``factor`` x ``factor`` pixels merged into one, and the sparse averaging matrix (U', U).

        A merged pixel lies at the mean position of those of its pixels that are inside, and has their mean value.
        """
        from scipy.sparse import csr_array

        if factor == 1:
            one = np.ones(self.size, np.float32)
            return self, csr_array((one, (np.arange(self.size),) * 2), shape=(self.size,) * 2)
        cells, home, counts = np.unique(self.cells // factor, axis=0, return_inverse=True, return_counts=True)
        home = home.ravel()
        share = (1 / counts[home]).astype(np.float32)
        mean = csr_array((share, (home, np.arange(self.size))), shape=(len(cells), self.size))
        return Mesh(self.points, self.triangles, cells, mean @ self.weights, self.spacing * factor), mean

    def gradients(self, images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives along x and y of images (K, U) in the grid, per grid pixel, (K, U) each.

        Central differences; one-sided at the border of the mesh, zero across a single pixel.
        """
        return tuple(np.ascontiguousarray((operator @ images.T).T) for operator in self._derivatives)

    @cached_property
    def _derivatives(self):
        from scipy.sparse import csr_array

        place = np.full(self.cells.max(axis=0) + 3, -1)
        rows, columns = self.cells.T + 1
        own = place[rows, columns] = np.arange(self.size)
        operators = []
        for down, right in ((0, 1), (1, 0)):
            before, after = place[rows - down, columns - right], place[rows + down, columns + right]
            left, ahead = np.where(before < 0, own, before), np.where(after < 0, own, after)
            steps = ((before >= 0) + (after >= 0).astype(np.float32)) * self.spacing
            value = np.divide(1, steps, out=np.zeros(self.size, np.float32), where=steps > 0, dtype=np.float32)
            entries = np.concatenate([value, -value]), (np.tile(own, 2), np.concatenate([ahead, left]))
            operators.append(csr_array(entries, shape=(self.size,) * 2))
        return operators

    @cached_property
    def turns(self) -> tuple[np.ndarray, np.ndarray]:
        """The derivative of a warp at the corners: ``turns[0] @ X`` along x, ``turns[1] @ X`` along y, (N, N) each.

        X (N, 2) are the warped corners. A warp is affine in each triangle; at a corner the derivatives of the triangles
        around it are averaged, by their areas in the base mesh.
        """
        along = np.zeros((2, len(self.points), len(self.points)))
        total = np.zeros(len(self.points))
        for corners in self.triangles:
            matrix = np.column_stack([self.points[corners], np.ones(3)])
            area = abs(np.linalg.det(matrix)) / 2
            if area < 1e-9:
                continue
            slopes = np.linalg.inv(matrix)[:2]  # derivatives of the three barycentric coordinates along x and y
            for corner in corners:
                along[:, corner, corners] += area * slopes
                total[corner] += area
        if not np.all(total > 0):
            raise DataError("a point of the mesh belongs to no triangle; there is no warp for it")
        along /= total[:, None]
        return along[0], along[1]

    def compose(self, warped: np.ndarray, moves: np.ndarray) -> np.ndarray:
        """Warps after small warps: where T warps put the base mesh once its corners are moved.

        Parameters
        ----------
        warped : (T, N, 2) the corners in each image
        moves : (T, N, 2) displacements of the corners of the base mesh, in grid pixels

        Returns
        -------
        (T, N, 2): each moved corner mapped by the affine warps of the triangles around that corner, averaged
        (Matthews and Baker 2004, section 4.1.2)
        """
        return warped + moves[..., :1] * (self.turns[0] @ warped) + moves[..., 1:] * (self.turns[1] @ warped)
