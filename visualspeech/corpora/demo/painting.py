"""The painted parts of the demo speaker: lips, brows, irises and skin grain; neck, pullover and backdrop."""

from collections.abc import Callable

import numpy as np

from visualspeech.corpora.demo.characters import Look


def paint_face(colours: np.ndarray, points: np.ndarray, seam: Callable, scale: int, look: Look) -> np.ndarray:
    """The head image with painted lips, brows and irises, and with skin grain.

    Parameters
    ----------
    colours : (rows, columns, 3) float32 RGB, ``scale`` pixels per canonical pixel
    points : (68, 2) canonical points of the face with the mouth closed
    seam : canonical row of the line between the lips, as a function of the canonical column
    """
    import cv2

    random = np.random.default_rng(68)
    grain = random.standard_normal(colours.shape[:2], dtype=np.float32)
    grain = cv2.GaussianBlur(grain, (0, 0), 1.1) * 7 + cv2.GaussianBlur(grain, (0, 0), 5) * 18
    colours = colours + grain[..., None] * np.array([0.8, 0.9, 0.9], np.float32)
    colours = _softened_folds(cv2, colours, points, scale)
    colours = _lips(cv2, colours, points, seam, scale, look)
    colours = _brows(cv2, colours, points, scale, random, look)
    return _irises(cv2, colours, points, scale, look)


def _filled(cv2, shape: tuple, polygon: np.ndarray, scale: int, blur: float) -> np.ndarray:
    """Mask (rows, columns) from 0 to 1 of a canonical polygon, with blurred edges."""
    mask = np.zeros(shape[:2], np.uint8)
    corners = np.round((polygon * scale + (scale - 1) / 2) * 16).astype(np.int32)
    cv2.fillPoly(mask, [corners], 255, cv2.LINE_AA, 4)
    return cv2.GaussianBlur(mask.astype(np.float32) / 255, (0, 0), blur)


def smooth_curve(points: np.ndarray, number: int) -> np.ndarray:
    """A smooth curve (number, 2) through points (n, 2): a cubic spline over the chord length."""
    from scipy.interpolate import CubicSpline

    chord = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    return CubicSpline(chord, points)(np.linspace(0, chord[-1], number))


def _softened_folds(cv2, colours: np.ndarray, points: np.ndarray, scale: int) -> np.ndarray:
    """Colours with softer folds beside the mouth, which remain of the smile in the photograph."""
    centre = points[48:60].mean(axis=0)
    y, x = np.mgrid[: colours.shape[0], : colours.shape[1]].astype(np.float32) / scale
    around = np.exp(-(((np.abs(x - centre[0]) - 38) / 13) ** 2) - ((y - centre[1] + 20) / 24) ** 2)
    smooth = cv2.GaussianBlur(colours, (0, 0), 6 * scale)
    light = np.array([6, 4, 3], np.float32)
    return colours + 0.8 * around[..., None] * (smooth + light - colours)


def _lips(cv2, colours: np.ndarray, points: np.ndarray, seam: Callable, scale: int, look: Look) -> np.ndarray:
    x = np.linspace(points[48, 0], points[54, 0], 60)
    line = np.stack([x, seam(x)], axis=1)
    upper = np.concatenate([smooth_curve(points[48:55], 60), line[::-1]])
    lower = np.concatenate([smooth_curve(points[[54, 55, 56, 57, 58, 59, 48]], 60), line])
    grey = colours @ np.array([0.3, 0.59, 0.11], np.float32)
    detail = (grey - cv2.GaussianBlur(grey, (0, 0), 3 * scale))[..., None]
    y, _ = np.mgrid[: colours.shape[0], : colours.shape[1]].astype(np.float32) / scale
    rows = np.broadcast_to((y - points[57, 1] + 8) / 5, y.shape)
    shine = 20 * np.exp(-(rows**2))[..., None]
    for polygon, colour, light in ((upper, look.upper_lip, 0.0), (lower, look.lower_lip, 1.0)):
        mask = 0.88 * _filled(cv2, colours.shape, polygon, scale, 0.7 * scale)[..., None]
        paint = np.array(colour, np.float32) + 0.35 * detail + light * shine
        colours = colours + mask * (paint - colours)
    dark = np.zeros(colours.shape[:2], np.uint8)
    corners = np.round((line * scale + (scale - 1) / 2) * 16).astype(np.int32)
    cv2.polylines(dark, [corners], False, 255, 2, cv2.LINE_AA, 4)
    mask = 0.75 * cv2.GaussianBlur(dark.astype(np.float32) / 255, (0, 0), 0.9)[..., None]
    return colours + mask * (np.array([74, 34, 32], np.float32) - colours)


def _brows(
    cv2, colours: np.ndarray, points: np.ndarray, scale: int, random: np.random.Generator, look: Look
) -> np.ndarray:
    hairs = np.zeros(colours.shape[:2], np.uint8)
    for brow, outward in ((points[17:22], -1), (points[22:27][::-1], 1)):
        curve = smooth_curve(brow, 120)
        for i, point in enumerate(curve):
            thick = look.brow_width * np.sin(np.pi * (0.12 + 0.8 * i / len(curve)))
            for _ in range(3):
                start = point + random.normal(0, 0.42, 2) * [1, thick]
                end = start + [outward * random.uniform(2, 4.5), random.uniform(-2.2, 0.4)]
                ends = np.round((np.stack([start, end]) * scale) * 16).astype(np.int32)
                cv2.line(hairs, tuple(map(int, ends[0])), tuple(map(int, ends[1])), 150, 1, cv2.LINE_AA, 4)
    mask = 0.8 * cv2.GaussianBlur(hairs.astype(np.float32) / 255, (0, 0), 0.9)[..., None]
    return colours + mask * (np.array(look.brow, np.float32) - colours)


def _irises(cv2, colours: np.ndarray, points: np.ndarray, scale: int, look: Look) -> np.ndarray:
    y, x = np.mgrid[: colours.shape[0], : colours.shape[1]].astype(np.float32) / scale
    for eye in (points[36:42], points[42:48]):
        centre = eye.mean(axis=0)
        distance = np.hypot(x - centre[0], y - centre[1] + 0.5)
        ring = np.clip((6.0 - distance) / 1.2, 0, 1) * np.clip((distance - 2.2) / 1.0, 0, 1)
        inside = _filled(cv2, colours.shape, eye, scale, 0.8)
        mask = (0.5 * ring * inside)[..., None]
        colours = colours + mask * (np.array(look.iris, np.float32) - colours)
    return colours


def backdrop_and_body(width: int, height: int, look: Look) -> tuple[np.ndarray, np.ndarray]:
    """Backdrop (height, width, 3) and body (height, width, 4: RGB and coverage), uint8, for a head 150 pixels wide."""
    import cv2

    random = np.random.default_rng(360)
    y, x = np.mgrid[:height, :width].astype(np.float32)
    x -= (width - 1) / 2
    cloud = cv2.GaussianBlur(random.standard_normal((height, width), dtype=np.float32), (0, 0), 28)
    glow = np.exp(-(((x + 50) / 230) ** 2) - ((y - 120) / 220) ** 2)
    light = 0.55 + 0.5 * glow + 1.6 * cloud
    backdrop = light[..., None] * np.array(look.backdrop, np.float32)

    fine = random.standard_normal((height, width), dtype=np.float32)
    folds = cv2.GaussianBlur(random.standard_normal((height, width), dtype=np.float32), (0, 0), 14)
    neck_width = 45 + 9 * np.clip((y - 285) / 40, 0, 1) ** 2
    neck = np.clip((neck_width - np.abs(x)) / 2 + 0.5, 0, 1) * (y > 215)
    under_chin = np.exp(-((np.maximum(y - 250, 0) / 45) ** 2))
    round_light = 1.0 - 0.32 * (np.abs(x) / 50) ** 2.2 - 0.0011 * x
    skin = (
        np.array(look.body, np.float32) * (round_light * (0.98 - 0.42 * under_chin))[..., None]
        + 2.5 * cv2.GaussianBlur(fine, (0, 0), 1)[..., None]
    )

    shoulder = 316 + 30 * (np.abs(x) / 150) ** 1.6
    collar = 318 + 13 * np.sqrt(np.clip(1 - (x / 53) ** 2, 0, 1))
    edge = np.where(np.abs(x) < 53, collar, shoulder)
    cloth = np.clip((y - edge) / 1.5 + 0.5, 0, 1)
    knit = 5 * np.sin(x * 2.1) * np.sin(y * 1.05) + 3 * fine
    rib = np.clip(1 - np.abs(y - edge - 5) / 6, 0, 1)
    shade = 1 + 5.0 * folds - 0.10 * rib - 0.25 * np.exp(-np.maximum(y - edge, 0) / 2.5)
    wool = np.array(look.wool, np.float32) * shade[..., None] + knit[..., None]

    colours = skin + cloth[..., None] * (wool - skin)
    coverage = np.maximum(neck, cloth)
    body = np.dstack([colours, 255 * coverage])
    return tuple(np.clip(image + 0.5, 0, 255).astype(np.uint8) for image in (backdrop, body))
