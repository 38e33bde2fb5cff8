"""Smooth displacements of the canonical face: the proportions of a speaker and the movements of an emotion."""

from collections.abc import Iterable, Mapping

import numpy as np

from visualspeech.corpora.demo.characters import MOVEMENTS, Bump
from visualspeech.corpora.demo.portrait import HEIGHT, MIDDLE, WIDTH

_CELL = 2.0  # canonical pixels between the nodes of a field
_STEPS = 14  # each halves the error of the inverse at least


def displacement(points: np.ndarray, bumps: Iterable[Bump]) -> np.ndarray:
    """Displacement (..., 2) of canonical points (..., 2), in pixels."""
    x, y = points[..., 0] - MIDDLE, points[..., 1]
    moved = np.zeros(points.shape)
    for bump in bumps:
        row = np.exp(-(((y - bump.y) / bump.height) ** 2))
        left, right = (row * np.exp(-(((x - side * bump.x) / bump.width) ** 2)) for side in (-1, 1))
        # In the middle of the face both Gaussians are one.
        share = 1.0 if bump.x else 0.5
        moved[..., 0] += share * bump.outward * (right - left)
        moved[..., 1] += share * bump.down * (right + left)
    return moved


def deformed(points: np.ndarray, proportions: tuple[Bump, ...], amounts: Mapping[str, float]) -> np.ndarray:
    """Canonical points (..., 2) on a face of other proportions with an expression.

    Parameters
    ----------
    amounts : movement, of :data:`MOVEMENTS` -> its amount
    """
    if not proportions and not amounts:
        return points
    moved = points + displacement(points, proportions)
    return moved + sum(amount * displacement(points, MOVEMENTS[name]) for name, amount in amounts.items())


class Inverse:
    """The inverse of :func:`deformed` for a renderer, from fields of the displacements that are computed once.

    Parameters
    ----------
    proportions : of the speaker
    """

    def __init__(self, proportions: tuple[Bump, ...]) -> None:
        x, y = np.arange(0, WIDTH + _CELL, _CELL), np.arange(0, HEIGHT + _CELL, _CELL)
        nodes = np.stack(np.meshgrid(x, y), axis=-1)
        self._proportions = displacement(nodes, proportions) if proportions else None
        self._movements = {name: displacement(nodes, bumps) for name, bumps in MOVEMENTS.items()}

    def __call__(self, points: np.ndarray, amounts: Mapping[str, float]) -> np.ndarray:
        """Canonical points (n, 2) at rest that :func:`deformed` moves to the given ones, by fixed-point iteration."""
        import cv2

        if self._proportions is None and not amounts:
            return points
        field = 0.0 if self._proportions is None else self._proportions
        field = field + sum(amount * self._movements[name] for name, amount in amounts.items())
        field = np.asarray(field, np.float32)
        found = points
        for _ in range(_STEPS):
            at = (found / _CELL).astype(np.float32)
            moved = cv2.remap(field, at[None, :, 0], at[None, :, 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            found = points - moved[0]
        return found
