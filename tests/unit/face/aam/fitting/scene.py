"""A small appearance model of made-up faces, and pictures of faces drawn with it."""

from functools import cache

import numpy as np

from tests.unit.face.aam.faces import POINTS, moving_faces, smooth_picture
from visualspeech.face.aam.empca import pca
from visualspeech.face.aam.fitting import FittingModel, FittingSettings
from visualspeech.face.aam.fitting.mesh import Mesh
from visualspeech.face.aam.fitting.model import grey
from visualspeech.face.aam.reference import ReferenceSettings, fit_reference, paint
from visualspeech.face.point_sets import to_points, to_vector

MODES = 4


@cache
def parts():
    """Reference, shape analysis, mean texture (3U,) and texture modes (MODES, 3U) of 6 grey levels each."""
    shapes = POINTS.select(moving_faces(120, seed=3))
    reference = fit_reference([shapes], POINTS, ReferenceSettings(texture_pixels=2500))
    analysis = pca(to_vector(shapes), components=6)
    x, y = reference.pixels[:, 1], reference.pixels[:, 0]
    mean = 128 + 50 * np.sin(0.13 * x + 0.05 * y) + 30 * np.cos(0.15 * y - 0.06 * x)
    mouth = np.isin(POINTS.triangles, POINTS.regions["lips"])
    mean -= 40 * mouth.all(axis=1)[reference.triangle]
    modes = [6 * np.sin(0.09 * (k + 1) * x + 0.07 * (MODES - k) * y + k) for k in range(MODES)]
    return reference, analysis, np.tile(mean, 3), np.tile(np.array(modes), (1, 3))


def model(**settings) -> FittingModel:
    """The fitting model of the scene."""
    reference, analysis, mean, modes = parts()
    shape = to_points(analysis.mean), to_points(analysis.components), analysis.eigenvalues
    basis = np.linalg.qr(grey(modes).T)[0].T
    chosen = FittingSettings(**{"tolerance": 0.01, **settings})
    return FittingModel.build(Mesh.of_reference(reference), shape, (grey(mean), basis), 1.0, chosen)


def pictures(count: int, seed: int = 5, noise: float = 1.0) -> tuple[list[np.ndarray], np.ndarray]:
    """Grey frames of 200 x 220 pixels with a face in each, and where its points are (count, 51, 2).

    The faces are turned by up to 6 degrees, larger or smaller by a twentieth, and have textures of their own.
    """
    reference, analysis, mean, modes = parts()
    generator = np.random.default_rng(seed)
    frames, places = [], []
    backdrop = smooth_picture(200, 220, seed)
    for _ in range(count):
        weights = generator.normal(0, 0.8, len(analysis.components)) * np.sqrt(analysis.eigenvalues)
        points = to_points(analysis.mean + weights @ analysis.components)
        angle, size = generator.uniform(-0.1, 0.1), generator.uniform(0.95, 1.05)
        turn = size * np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        points = (points - points.mean(axis=0)) @ turn + [110, 100] + generator.uniform(-5, 5, 2)
        texture = mean + generator.normal(0, 0.7, MODES) @ modes
        frame = paint(texture, points, reference, backdrop)[..., 0]
        frames.append(np.clip(np.rint(frame + generator.normal(0, noise, frame.shape)), 0, 255).astype(np.uint8))
        places.append(points)
    return frames, np.array(places)
