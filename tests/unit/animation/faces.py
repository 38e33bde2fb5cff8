"""A face drawn in flat colours where its landmarks are, for tests and benchmarks of rendering."""

import cv2
import numpy as np

from visualspeech.face.aam.reference import Reference, ReferenceSettings, fit_reference
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.point_sets import read_point_set

POINTS = read_point_set("lower_face_51")

BACKGROUND = (40, 90, 200)
SKIN = (200, 160, 130)
LIP = (200, 30, 30)
CAVITY = (60, 0, 0)
WIDTH, HEIGHT = 360, 288


def points68(opening: float = 0.0, drop: float = 0.0, scale: float = 75.0, centre=(180.0, 140.0)) -> np.ndarray:
    """Landmarks (68, 2) of a face with its mouth open by some pixels and its jaw down by some."""
    points = MEAN_FACE[:, :2] * scale + np.asarray(centre)
    points[[66, 57]] += (0, opening)
    points[[65, 67, 56, 58]] += (0, 0.9 * opening)
    points[[55, 59]] += (0, 0.4 * opening)
    points[[7, 8, 9]] += (0, drop)
    points[[6, 10]] += (0, 0.8 * drop)
    points[[5, 11]] += (0, 0.5 * drop)
    return points


def draw(points: np.ndarray, lip=LIP, skin=SKIN, size=(WIDTH, HEIGHT)) -> np.ndarray:
    """The picture of a face (68, 2), (height, width, 3) uint8: neck, head, eyes and a mouth."""
    picture = np.full((size[1], size[0], 3), BACKGROUND, np.uint8)
    face = POINTS.select(points)
    wide = np.linalg.norm(face[16] - face[0])

    def fill(corners, colour):
        cv2.fillPoly(picture, [np.rint(np.asarray(corners) * 16).astype(np.int32)], colour, cv2.LINE_AA, shift=4)

    forehead = np.stack([face[16], face[16] - (0, 0.6 * wide), face[0] - (0, 0.6 * wide), face[0]])
    fill(np.concatenate([POINTS.region(face, "jaw"), forehead]), skin)
    for eye in (slice(36, 42), slice(42, 48)):
        fill(points[eye], (20, 20, 20))
    fill(POINTS.region(face, "outer_lips"), lip)
    fill(POINTS.region(face, "inner_lips"), CAVITY)
    return picture


def reference(pixels: int = 3000) -> Reference:
    """A texture grid on the drawn face."""
    return fit_reference([POINTS.select(points68())[None]], POINTS, ReferenceSettings(texture_pixels=pixels))
