import numpy as np

from visualspeech.face.aam.fitting.mesh import Mesh

from .scene import parts


def small_mesh(pixels=900):
    generator = np.random.default_rng(2)
    border = [[0, 0], [100, 0], [100, 80], [0, 80], [50, -10], [50, 90]]
    return Mesh.delaunay(np.concatenate([border, generator.uniform(12, 68, (9, 2))]), pixels)


def test_pixels_lie_where_their_weights_say():
    for mesh in (small_mesh(), Mesh.of_reference(parts()[0])):
        np.testing.assert_allclose(mesh.weights.sum(axis=1), 1, atol=1e-5)
        np.testing.assert_allclose(mesh.weights @ mesh.points, mesh.cells[:, ::-1], atol=1e-3)
    assert abs(small_mesh().size - 900) < 60


def test_joined_pixels_are_means_of_their_own():
    mesh = small_mesh()
    coarse, averaging = mesh.coarser(3)
    values = np.random.default_rng(0).normal(size=mesh.size)
    for number in (0, 17, coarse.size - 1):
        own = (mesh.cells // 3 == coarse.cells[number]).all(axis=1)
        assert np.isclose((averaging @ values)[number], values[own].mean(), atol=1e-6)
        np.testing.assert_allclose(
            (coarse.weights @ mesh.points)[number], mesh.cells[own].mean(axis=0)[::-1], atol=1e-3
        )
    assert coarse.size < mesh.size / 7


def test_gradients_are_exact_for_planes_and_for_parabolas_inside():
    mesh = small_mesh()
    for at in (mesh, mesh.coarser(2)[0]):
        y, x = (at.cells * at.spacing).T.astype(float)
        along, down = at.gradients(np.stack([3 * x - 2 * y + 1, 0.5 * x**2 + x * y]))
        inside = np.array([all(tuple(c + d) in set(map(tuple, at.cells)) for d in ((0, 1), (1, 0), (0, -1), (-1, 0)))
                           for c in at.cells[::7]])  # fmt: skip
        np.testing.assert_allclose(along[0], 3, atol=1e-3)
        np.testing.assert_allclose(down[0], -2, atol=1e-3)
        np.testing.assert_allclose(along[1][::7][inside], (x + y)[::7][inside], atol=1e-2)
        np.testing.assert_allclose(down[1][::7][inside], x[::7][inside], atol=1e-2)


def slowly_composed(mesh, warped, moves):
    """Each corner by each affine map around it, averaged by area; one triangle at a time."""
    result = np.zeros_like(warped)
    for corner in range(len(mesh.points)):
        total = 0.0
        for triangle in mesh.triangles:
            if corner not in triangle:
                continue
            source = np.column_stack([mesh.points[triangle], np.ones(3)])
            area = abs(np.linalg.det(source))
            affine = np.linalg.solve(source, warped[triangle])
            result[corner] += area * (np.append(mesh.points[corner] + moves[corner], 1) @ affine)
            total += area
        result[corner] /= total
    return result


def test_composition_is_the_mean_of_the_affine_maps_around_a_corner():
    generator = np.random.default_rng(4)
    mesh = small_mesh()
    warped = mesh.points * [1.2, 0.9] + generator.normal(0, 2, (3, *mesh.points.shape))
    moves = generator.normal(0, 1, warped.shape)
    composed = mesh.compose(warped, moves)
    for one in range(3):
        np.testing.assert_allclose(composed[one], slowly_composed(mesh, warped[one], moves[one]), atol=1e-9)


def test_composition_with_an_affine_warp_is_that_warp_of_the_moved_corners():
    mesh = Mesh.of_reference(parts()[0])
    moves = np.random.default_rng(1).normal(0, 1, (1, *mesh.points.shape))
    turn = np.array([[1.1, 0.3], [-0.2, 0.8]])
    composed = mesh.compose((mesh.points @ turn + [5, 7])[None], moves)
    np.testing.assert_allclose(composed, (mesh.points + moves) @ turn + [5, 7], atol=1e-8)
