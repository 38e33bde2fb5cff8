import numpy as np
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.face.aam.fitting import FittingSettings
from visualspeech.face.aam.fitting.model import steepest_descent
from visualspeech.face.aam.fitting.solver import _step

from .scene import model, parts


def test_steepest_descent_is_the_derivative_of_the_warped_template():
    """Against finite differences of a template that is known everywhere, for every parameter."""
    ready = model(scales=(1,))
    mesh, changes = ready.levels[0].mesh, ready.scale * ready.shapes.changes

    def template(places):
        x, y = places[:, 0], places[:, 1]
        return 0.02 * x**2 - 0.03 * x * y + 0.5 * y  # central differences are exact for it

    jacobian = steepest_descent(mesh, template(mesh.weights.astype(float) @ mesh.points)[None], changes)[0]
    cells = set(map(tuple, mesh.cells))
    inside = [all((r + a, c + b) in cells for a, b in ((0, 1), (1, 0), (0, -1), (-1, 0))) for r, c in mesh.cells]
    for row, change in zip(jacobian, changes, strict=True):
        step = 1e-4
        values = [template(mesh.weights.astype(float) @ (mesh.points + sign * step * change)) for sign in (1, -1)]
        difference = (values[0] - values[1]) / (2 * step)
        scale = np.abs(difference).max()
        np.testing.assert_allclose(row[inside], difference[inside], atol=2e-3 * scale)


def dense(ready, level, texture):
    """Jacobian (U, I) of a face with these texture parameters, made plainly."""
    images = np.concatenate([level.mean[None], level.components])
    every = steepest_descent(level.mesh, images, ready.scale * ready.shapes.changes).astype(float)
    return np.einsum("k,kiu->ui", np.append(1.0, texture), every)


@pytest.mark.parametrize("scale", [1, 2])
def test_steps_solve_the_plain_least_squares_problem(scale):
    generator = np.random.default_rng(8)
    for variant in ("alternating", "project_out", "simultaneous"):
        ready = model(variant=variant, prior_weight=0, scales=(scale,))
        level = ready.levels[0]
        left = generator.normal(0, 10, (3, level.mesh.size)).astype(np.float32)
        texture = generator.normal(0, 200, (3, len(level.components))).astype(np.float32)
        change, carried = _step(left, level, ready, np.zeros((3, 6)), texture if variant == "simultaneous" else None)
        modes = level.components.astype(float).T
        for one in range(3):
            now = {"alternating": modes.T @ left[one], "project_out": 0 * texture[one]}.get(variant, texture[one])
            jacobian = dense(ready, level, now)
            solved = np.linalg.lstsq(np.column_stack([jacobian, modes]), left[one].astype(float), rcond=None)[0]
            size = jacobian.shape[1]
            np.testing.assert_allclose(change[one], solved[:size], atol=2e-3 * np.abs(solved[:size]).max())
            if variant == "simultaneous":
                np.testing.assert_allclose(carried[one], solved[size:], atol=2e-3 * np.abs(solved[size:]).max())


def test_the_prior_pulls_to_the_mean_shape():
    ready = model(prior_weight=1e9, scales=(1,))
    level, shape = ready.levels[0], np.linspace(-3, 3, 6)[None]
    left = np.random.default_rng(0).normal(0, 5, (1, level.mesh.size)).astype(np.float32)
    change, _ = _step(left, level, ready, shape, None)
    np.testing.assert_allclose(change[0, 4:], shape[0], atol=0.01)


def test_unfitting_parts_are_refused():
    reference, analysis, mean, _ = parts()
    with pytest.raises(DataError, match="does not fit"):
        type(model()).build(model().levels[-1].mesh, (np.zeros((51, 2)),) * 3, (mean[:7], mean[None, :7]), 1.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"variant": "forward"},
        {"scales": (1, 1)},
        {"scales": ()},
        {"iterations": 0},
        {"tolerance": 0},
        {"prior_weight": -1},
    ],
)
def test_settings_out_of_range_are_refused(wrong):
    with pytest.raises(SettingError, match=next(iter(wrong))):
        FittingSettings(**wrong)
