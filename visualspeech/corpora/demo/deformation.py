"""Smooth displacements of the canonical face: the proportions of a speaker and the movements of an emotion."""

from collections.abc import Iterable, Mapping

import numpy as np

from visualspeech.corpora.demo.characters import MOVEMENTS, Bump
from visualspeech.corpora.demo.portrait import MIDDLE


def displacement(points: np.ndarray, bumps: Iterable[Bump], amount: float = 1.0) -> np.ndarray:
    """Displacement (..., 2) of canonical points (..., 2), in pixels."""
    x, y = points[..., 0] - MIDDLE, points[..., 1]
    moved = np.zeros(points.shape)
    for bump in bumps:
        row = np.exp(-(((y - bump.y) / bump.height) ** 2))
        left, right = (row * np.exp(-(((x - side * bump.x) / bump.width) ** 2)) for side in (-1, 1))
        # At x = 0 both Gaussians are one.
        share = amount if bump.x else amount / 2
        moved[..., 0] += share * bump.outward * (right - left)
        moved[..., 1] += share * bump.down * (right + left)
    return moved


def expressed(points: np.ndarray, amounts: Mapping[str, float]) -> np.ndarray:
    """Canonical points (..., 2) moved by an emotion: name of a movement -> amount."""
    return points + sum(displacement(points, MOVEMENTS[name], amount) for name, amount in amounts.items())


def deformed(points: np.ndarray, proportions: tuple[Bump, ...], amounts: Mapping[str, float]) -> np.ndarray:
    """Canonical points (..., 2) of another face with an expression."""
    moved = expressed(points, amounts) if amounts else points
    return moved + displacement(moved, proportions) if proportions else moved


def restored(points: np.ndarray, proportions: tuple[Bump, ...], amounts: Mapping[str, float]) -> np.ndarray:
    """The inverse of :func:`deformed`, by fixed-point iteration; the displacements are smooth enough to contract."""
    if proportions:
        points = _inverse(points, lambda at: displacement(at, proportions))
    if amounts:
        points = _inverse(points, lambda at: expressed(at, amounts) - at)
    return points


def _inverse(points: np.ndarray, moved, steps: int = 12) -> np.ndarray:
    found = points
    for _ in range(steps):
        found = points - moved(found)
    return found
