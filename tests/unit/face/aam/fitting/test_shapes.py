import numpy as np
import pytest

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting.shapes import ShapeSpace
from visualspeech.face.point_sets import to_points

from .scene import parts


def space() -> ShapeSpace:
    analysis = parts()[1]
    return ShapeSpace.of(to_points(analysis.mean), to_points(analysis.components), analysis.eigenvalues)


def test_changes_are_orthonormal():
    changes = space().changes.reshape(len(space().changes), -1)
    np.testing.assert_allclose(changes @ changes.T, np.eye(len(changes)), atol=1e-9)


def test_parameters_invert_points():
    generator = np.random.default_rng(0)
    shapes = space()
    similarity = generator.normal([1.3, 0.4, 90, 120], [0.2, 0.3, 20, 20], (7, 4))
    shape = generator.normal(0, 5, (7, len(shapes.modes)))
    found = shapes.parameters(shapes.points(similarity, shape))
    np.testing.assert_allclose(found[0], similarity, atol=1e-8)
    np.testing.assert_allclose(found[1], shape, atol=1e-8)


def test_changes_are_the_derivatives_of_the_points():
    shapes, step = space(), 1e-6
    size, root = np.linalg.norm(shapes.mean), np.sqrt(len(shapes.mean))
    still = np.array([[1.0, 0, 0, 0]]), np.zeros((1, len(shapes.modes)))
    units = [1 / size, 1 / size, 1 / root, 1 / root]
    for number, change in enumerate(shapes.changes):
        moved = still[0].copy(), still[1].copy()
        moved[number >= 4][0, number - 4 * (number >= 4)] += step * (units[number] if number < 4 else 1)
        difference = (shapes.points(*moved) - shapes.points(*still))[0] / step
        np.testing.assert_allclose(difference, change, atol=1e-6)


def test_similarity_in_the_components_is_taken_out():
    analysis = parts()[1]
    mean, modes = to_points(analysis.mean), to_points(analysis.components)
    moved = np.stack([np.full(51, 1.0), np.zeros(51)], axis=1)[None] / np.sqrt(51)
    mixed = ShapeSpace.of(mean, np.concatenate([modes, moved]), np.append(analysis.eigenvalues, 9.0))
    assert len(mixed.modes) == len(space().modes)


def test_a_face_in_one_place_is_refused():
    with pytest.raises(DataError, match="coincide"):
        ShapeSpace.of(np.ones((5, 2)), np.ones((1, 5, 2)), np.ones(1))
