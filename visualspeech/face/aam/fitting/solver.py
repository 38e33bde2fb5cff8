"""Inverse-compositional fitting of many frames at once (Matthews and Baker 2004; Papandreou and Maragos 2008).

In each step the images are sampled at the warped pixels, what the texture modes explain is projected out, and the small
warp that brings the *model* closest to the samples is computed; its inverse is composed with the warp of the image. The
Jacobian belongs to the model and not to the image, so it does not change. The frames of a batch are fitted together;
those that have converged leave it.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting.model import FittingModel, Level

_STRIP = 16384  # pixels that cv2.remap is given at a time; it takes no more than 32766 in a row


class View(Protocol):
    """A map between the shapes of a model and the images that is more general than a similarity."""

    def to_model(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Image points (t, N, 2) of some frames (t,) in the units of the model's shapes."""

    def to_image(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """The inverse."""


@dataclass(frozen=True)
class Fit:
    """Fitted faces of T frames.

    Parameters
    ----------
    points : (T, N, 2) image pixels; where a fit diverged, those that it started from
    similarity : (T, 4) a, b, x, y of the global warp (:meth:`ShapeSpace.parameters`)
    shape : (T, n) shape parameters; texture : (T, K) texture parameters at the finest scale
    error : (T,) root mean square in grey levels of what the texture modes do not explain, at the fitted points
    start_error : (T,) the same at the start
    diverged : (T,) bool
    iterations : (T,) steps taken, all scales together
    """

    points: np.ndarray
    similarity: np.ndarray
    shape: np.ndarray
    texture: np.ndarray
    error: np.ndarray
    start_error: np.ndarray
    diverged: np.ndarray
    iterations: np.ndarray


def fit(
    frames: Sequence[np.ndarray],
    start: np.ndarray,
    model: FittingModel,
    view: View | None = None,
    offset: np.ndarray | None = None,
) -> Fit:
    """Fit a model to frames from given points, all frames independently.

    Parameters
    ----------
    frames : T grey images (height, width), uint8 or float32, all of one size
    start : (T, N, 2) points to start from, image pixels (for example landmarks of a tracker)
    view : the map between image and model; by default a similarity
    offset : (U,) grey levels by which these images are lighter than the model, on the finest grid; None for none

    Raises
    ------
    DataError
        Frames, points and model do not fit together, or points are not finite.
    """
    expected = (len(frames), *model.shapes.mean.shape)
    if start.shape != expected or not np.isfinite(start).all():
        raise DataError(f"{len(frames)} frames are fitted from finite points {expected}, not {start.shape}")
    size = model.settings.batch_size
    batches = [np.arange(first, min(first + size, len(frames))) for first in range(0, len(frames), size)]
    return joined(_fit_batch([frames[t] for t in one], start[one], one, model, view, offset) for one in batches)


def follow(
    frames: Sequence[np.ndarray],
    start: np.ndarray,
    model: FittingModel,
    view: View | None = None,
    offset: np.ndarray | None = None,
    last: np.ndarray | None = None,
) -> Fit:
    """As :func:`fit`, but each frame starts from the fit of the frame before.

    Parameters
    ----------
    start : (N, 2) points of the first frame; or (T, N, 2): then a frame whose fit diverged is fitted again from its own
        points, which are also what is kept when that diverges too
    last : (N, 2) the fit of the frame before the first, where there is one
    """
    own = start if start.ndim == 3 else None
    at = last if last is not None else start if own is None else start[0]
    parts = []
    for number, frame in enumerate(frames):
        one = np.array([number])
        part = _fit_batch([frame], at[None], one, model, view, offset)
        if own is not None and part.diverged[0]:
            part = _fit_batch([frame], own[one], one, model, view, offset)
        parts.append(part)
        at = part.points[0]
    return joined(parts)


def joined(parts: Iterable[Fit]) -> Fit:
    """Fits of consecutive batches of frames as one.

    Raises
    ------
    DataError
        There are none.
    """
    parts = list(parts)
    if not parts:
        raise DataError("no frames to fit")
    return Fit(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Fit)))


def _fit_batch(frames, start, numbers, model: FittingModel, view, offset) -> Fit:
    settings, shapes = model.settings, model.shapes
    points = np.array(start, float)
    similarity, shape = shapes.parameters(points if view is None else view.to_model(points, numbers))
    limit = settings.shape_limit * shapes.deviations
    shape = np.clip(shape, -limit, limit)
    shrink = _image_scale(points, model)
    steps, lost = np.zeros(len(frames), int), np.zeros(len(frames), bool)
    finest = model.levels[-1]
    for level in model.levels:
        reduction = max(1, int(level.mesh.spacing * shrink))
        images = [_reduced(frame, reduction) for frame in frames]
        base = level.mean if offset is None else level.mean + level.averaging @ offset
        texture = None
        active = np.arange(len(frames))
        for _ in range(settings.iterations):
            left = _read(images, points, active, level, reduction) - base
            known = None if texture is None else texture[active]
            change, known = _step(left, level, model, shape[active], known)
            if known is not None:
                texture = np.zeros((len(frames), known.shape[1]), np.float32) if texture is None else texture
                texture[active] = known
            moves = -model.scale * np.einsum("ti,ina->tna", change, shapes.changes)
            moved = level.mesh.compose(points[active], moves)
            in_model = moved if view is None else view.to_model(moved, numbers[active])
            fine = np.isfinite(in_model).all(axis=(1, 2))
            lost[active[~fine]] = True  # such a fit stays where it was
            active, in_model, moves = active[fine], in_model[fine], moves[fine]
            steps[active] += 1
            similarity[active], free = shapes.parameters(in_model)
            shape[active] = np.clip(free, -limit, limit)
            placed = shapes.points(similarity[active], shape[active])
            points[active] = placed if view is None else view.to_image(placed, numbers[active])
            active = active[np.abs(moves).max(axis=(1, 2)) > settings.tolerance * level.mesh.spacing]
            if not len(active):
                break
    everything = np.arange(len(frames))
    both = [_read(images, where, everything, finest, reduction) - base for where in (points, start)]
    texture, error = _explained(both[0], finest)
    start_error = _explained(both[1], finest)[1]
    diverged = lost | _diverged(points, start, error, start_error, model)
    kept = np.where(diverged[:, None, None], start, points)
    return Fit(kept, similarity, shape, texture, error, start_error, diverged, steps)


def _step(left: np.ndarray, level: Level, model: FittingModel, shape: np.ndarray, texture: np.ndarray | None):
    """The small warps (t, 4 + n) that bring the model closest to what was read, and the textures carried on.

    left (t, U) is what was read less the mean; shape (t, n) the present shape parameters; texture (t, K) the present
    texture parameters of the simultaneous variant.
    """
    variant, size = model.settings.variant, len(model.shapes.changes)
    explained = left @ level.components.T
    if variant == "project_out":
        gradient = left @ level.jacobians[:size].T
        hessian = level.hessians[0].reshape(1, size, size)
    else:
        if variant == "alternating" or texture is None:
            texture = explained
        along = np.concatenate([np.ones((len(left), 1), np.float32), texture], axis=1)
        products = (left @ level.jacobians.T).reshape(len(left), -1, size)
        gradient = np.einsum("tk,tki->ti", along, products)
        first, second = level.pairs
        hessian = ((along[:, first] * along[:, second]) @ level.hessians).reshape(-1, size, size)
    gradient, hessian = gradient.astype(np.float64), hessian.astype(np.float64)
    if model.settings.prior_weight:
        # The noise is the current residual: far from the face shapes are constrained tightly, on it loosely.
        pull = (
            model.settings.prior_weight * _residual(left, explained)[:, None] ** 2 / np.square(model.shapes.deviations)
        )
        gradient[:, 4:] += pull * shape
        hessian = np.repeat(hessian, len(left) // len(hessian), axis=0)
        hessian[:, range(4, size), range(4, size)] += pull
    # A small ridge: without it, a direction in which the template has no gradient would make the system singular.
    hessian = hessian + (1e-6 * np.trace(hessian, axis1=1, axis2=2) / size + 1e-12)[:, None, None] * np.eye(size)
    change = np.linalg.solve(np.broadcast_to(hessian, (len(gradient), size, size)), gradient[..., None])[..., 0]
    if variant != "simultaneous":
        return change, None
    taken = np.einsum("tk,ti,kim->tm", along, change.astype(np.float32), level.overlap, optimize=True)
    return change, explained - taken


def _read(images, points: np.ndarray, active: np.ndarray, level: Level, reduction: int) -> np.ndarray:
    """Grey levels (t, U) of the active images at the warped pixels of a level."""
    import cv2

    corners = (points[active] + 0.5) / reduction - 0.5
    flat = np.ascontiguousarray(corners.transpose(0, 2, 1), np.float32).reshape(-1, corners.shape[1])
    positions = (flat @ level.mesh.weights.T).reshape(len(active), 2, -1)
    values = np.empty((len(active), positions.shape[2]), np.float32)
    for row, number in enumerate(active):
        for first in range(0, positions.shape[2], _STRIP):
            x, y = positions[row, :, None, first : first + _STRIP]
            part = cv2.remap(images[number], x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            values[row, first : first + _STRIP] = part[0]
    return values


def _reduced(frame: np.ndarray, reduction: int) -> np.ndarray:
    import cv2

    if reduction == 1:
        return frame
    height, width = (reduction * (side // reduction) for side in frame.shape)
    size = width // reduction, height // reduction
    return cv2.resize(frame[:height, :width], size, interpolation=cv2.INTER_AREA)


def _image_scale(points: np.ndarray, model: FittingModel) -> float:
    """Image pixels per grid pixel, the median over frames."""
    spread = points - points.mean(axis=1, keepdims=True)
    size = np.median(np.linalg.norm(spread, axis=(1, 2)))
    return float(size / (np.linalg.norm(model.shapes.mean) * model.scale))


def _explained(left: np.ndarray, level: Level) -> tuple[np.ndarray, np.ndarray]:
    texture = left @ level.components.T
    return texture, _residual(left, texture)


def _residual(left: np.ndarray, texture: np.ndarray) -> np.ndarray:
    """Root mean square (t,) of what was read less the mean (t, U), without what the texture parameters explain."""
    squares = np.einsum("tu,tu->t", left, left) - np.einsum("tk,tk->t", texture, texture)
    return np.sqrt(np.maximum(squares, 0) / left.shape[1])


def _diverged(points, start, error, start_error, model: FittingModel) -> np.ndarray:
    settings = model.settings
    spread = start - start.mean(axis=1, keepdims=True)
    size = np.sqrt(np.square(spread).sum(axis=2).mean(axis=1))
    far = np.linalg.norm(points - start, axis=2).mean(axis=1) > settings.max_displacement * size
    poor = (error > settings.max_error_ratio * max(model.noise, 1.0)) | (
        error > settings.max_error_growth * start_error
    )
    return far | poor | ~np.isfinite(points).all(axis=(1, 2)) | ~np.isfinite(error)
