"""Drawings of a face as points and lines, or of channels as bars."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.animation.markers.layouts import Frame, Layout

WIDTH, HEIGHT = 400, 440
BACKGROUND = (250, 250, 248)
TRUE, PREDICTED = (0, 92, 138), (196, 78, 0)  # blue and orange, which colour-blind readers tell apart
_FAINT = (168, 168, 168)
_MARGIN = 0.09  # of the panel, on each side
_TURN = np.radians(25.0)  # of a face in three dimensions, so that what moves forward is seen
_SHIFT = 4  # fractional bits of coordinates
_COLUMN = 21  # bars in a column


@dataclass(frozen=True)
class View:
    """How points become pixels: ``pixels = origin + scale * (points @ screen)``.

    Parameters
    ----------
    screen : (d, 2) directions of right and down on the screen
    origin : (2,) in pixels
    scale : pixels per unit of the points
    """

    screen: np.ndarray
    origin: np.ndarray
    scale: float

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Pixels (..., P, 2) of points (..., P, d)."""
        return self.origin + self.scale * (points @ self.screen)


def view_of(points: Sequence[np.ndarray], frame: Frame | None, width: int = WIDTH, height: int = HEIGHT) -> View:
    """One view of several streams (T, P, d), d at least 2, so that their drawings can be compared.

    The face looks at the reader, so that its left is on the right. Without a known layout, flat points are taken as
    pixels (y down), and points in space as x to the right and y up.
    """
    joined = np.concatenate([np.asarray(one, float).reshape(-1, one.shape[-1]) for one in points])
    screen = _screen(frame, joined.shape[1])
    flat = joined @ screen
    # A single wild point must not make the face tiny.
    low, high = np.percentile(flat, 0.1, axis=0), np.percentile(flat, 99.9, axis=0)
    room = (1 - 2 * _MARGIN) * np.array([width, height])
    scale = float(np.min(room / np.maximum(high - low, 1e-9)))
    return View(screen, np.array([width, height]) / 2 - scale * (low + high) / 2, scale)


def _screen(frame: Frame | None, dimensions: int) -> np.ndarray:
    if frame is None or not frame.axes:
        return np.eye(dimensions, 2) * ([1, 1] if dimensions == 2 else [1, -1])
    right = frame.axes["left"]
    if "forward" in frame.axes:
        right = np.cos(_TURN) * right + np.sin(_TURN) * frame.axes["forward"]
    return np.stack([right, -frame.axes["up"]], axis=1)


def drawn_points(
    points: np.ndarray,
    view: View,
    lines: Sequence[Sequence[int]],
    colour: tuple[int, int, int],
    beneath: np.ndarray | None = None,
    width: int = WIDTH,
    height: int = HEIGHT,
) -> Iterator[np.ndarray]:
    """Yield a frame (height, width, 3) uint8 RGB per frame of points (T, P, d).

    Parameters
    ----------
    lines : chains of rows of the points to join
    beneath : (T, P, d) another face to draw in grey beneath, for comparison
    """
    for index, face in enumerate(points):
        image = np.full((height, width, 3), BACKGROUND, np.uint8)
        if beneath is not None:
            _draw(image, view.pixels(beneath[index]), lines, _FAINT, 1, 0)
        _draw(image, view.pixels(face), lines, colour, 2, 3)
        yield image


def _draw(image: np.ndarray, pixels: np.ndarray, lines, colour, thickness: int, radius: int) -> None:
    """Draw one face into an image."""
    import cv2

    fixed = np.rint(np.clip(pixels, -4096, 4096) * (1 << _SHIFT)).astype(np.int32)
    for line in lines:
        cv2.polylines(image, [fixed[list(line)]], False, colour, thickness, cv2.LINE_AA, _SHIFT)
    for point in fixed if radius else ():
        cv2.circle(image, tuple(map(int, point)), radius << _SHIFT, colour, -1, cv2.LINE_AA, _SHIFT)


def rows_of_lines(layout: Layout | None, frame: Frame | None) -> list[list[int]]:
    """The lines of a layout as rows of the points; none without a layout."""
    return [[frame.index[name] for name in line] for line in layout.lines] if layout and frame else []


def drawn_bars(
    values: np.ndarray,
    names: Sequence[str],
    span: tuple[float, float],
    colour: tuple[int, int, int],
    beneath: np.ndarray | None = None,
    height: int = HEIGHT,
) -> Iterator[np.ndarray]:
    """Yield a frame (height, width, 3) uint8 RGB per frame of channels (T, P): a bar per channel, named.

    Parameters
    ----------
    span : least and largest value of a bar's scale
    beneath : (T, P) other values, marked by a grey line on each bar
    """
    import cv2

    columns = -(-len(names) // _COLUMN)
    rows = -(-len(names) // columns)
    wide, step = 200, height / (rows + 1)
    base = np.full((height, wide * columns, 3), BACKGROUND, np.uint8)
    boxes = []
    for number, name in enumerate(names):
        left, top = wide * (number // rows), (number % rows + 0.5) * step
        text = name.encode("ascii", "replace").decode()
        cv2.putText(base, text[:22], (left + 6, int(top + 0.62 * step)), 0, 0.32, (40, 40, 40), 1, cv2.LINE_AA)
        boxes.append((left + 122, int(top + 0.15 * step), wide - 134, max(2, int(0.7 * step))))
    low, high = min(span[0], 0.0), max(span[1], 1e-9)
    for index, frame in enumerate(values):
        image = base.copy()
        for number, (x, y, width, thick) in enumerate(boxes):
            zero, end = (x + width * (np.clip(value, low, high) - low) / (high - low) for value in (0.0, frame[number]))
            cv2.rectangle(image, (x, y), (x + width, y + thick), (226, 226, 226), -1)
            first, last = sorted((round(float(zero)), round(float(end))))
            cv2.rectangle(image, (first, y), (last, y + thick), colour, -1)
            if beneath is not None:
                at = round(float(x + width * (np.clip(beneath[index, number], low, high) - low) / (high - low)))
                cv2.line(image, (at, y), (at, y + thick), (90, 90, 90), 2)
        yield image
