"""Thin-plate splines (Bookstein 1989): smooth warps that map given points to given values."""

import numpy as np


def thin_plate(centres: np.ndarray, values: np.ndarray, stiffness: float = 0.0) -> np.ndarray:
    """Coefficients (n + 3, k) of the thin-plate spline with ``values`` (n, k) at ``centres`` (n, 2).

    A ``stiffness`` above 0 smooths instead of interpolating exactly.
    """
    n = len(centres)
    system = np.zeros((n + 3, n + 3))
    system[:n, :n] = _kernel(centres, centres) + stiffness * np.eye(n)
    system[:n, n] = system[n, :n] = 1.0
    system[:n, n + 1 :] = centres
    system[n + 1 :, :n] = centres.T
    right = np.zeros((n + 3, values.shape[1]))
    right[:n] = values
    return np.linalg.solve(system, right)


def evaluate(coefficients: np.ndarray, centres: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Values (m, k) of a spline at ``points`` (m, 2)."""
    n = len(centres)
    return _kernel(points, centres) @ coefficients[:n] + coefficients[n] + points @ coefficients[n + 1 :]


def _kernel(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    squared = np.maximum(((a**2).sum(1)[:, None] + (b**2).sum(1)[None] - 2.0 * (a @ b.T)), 0.0)
    return squared * np.log(squared + 1e-6)


def grid(left: float, top: float, right: float, bottom: float, step: float) -> tuple[np.ndarray, int, int]:
    """Points (rows * columns, 2) of a regular grid, and its numbers of rows and columns."""
    x = np.arange(left, right + 1e-9, step)
    y = np.arange(top, bottom + 1e-9, step)
    columns, rows = len(x), len(y)
    return np.stack([np.tile(x, rows), np.repeat(y, columns)], axis=1), rows, columns
