"""Parts of an active appearance model that fitting needs, computed once: templates, Jacobians, Hessians per scale.

Notation: N points, U grid pixels of a scale, K texture modes, n shape modes; i runs over the 4 + n changes of a warp
(larger, turned, moved along x and y, then the shape modes), k over the texture modes with the mean as k = 0. Textures
are grey: of three channels the luminance is fitted, at a third of the cost, for fitting is for the shapes.

The Jacobian of a face with texture parameters c is linear in c (c_0 = 1 stands for the mean)::

    J(c)_i = sum_k c_k J_ki,    J_ki = grad t_k . dW/dp_i

Once all J_ki are projected onto what no texture mode explains, both sides of the normal equations of a frame are
polynomials in c with fixed coefficients: the right side is linear, the Hessian quadratic. So the variants whose
Jacobian follows the texture (simultaneous, alternating) compute no Jacobian per frame; they cost one matrix product per
batch.
"""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting.mesh import Mesh
from visualspeech.face.aam.fitting.shapes import ShapeSpace
from visualspeech.face.point_sets import to_points
from visualspeech.fields import Settings, setting

VARIANTS = ("alternating", "simultaneous", "project_out")
STARTS = ("landmarks", "last_frame")
LUMA = np.array([0.299, 0.587, 0.114], np.float32)
"""Weights of red, green and blue in grey (ITU-R BT.601), those of OpenCV's conversion."""


@dataclass(frozen=True)
class FittingSettings(Settings):
    """Fitting of the active appearance model to frames.

    ``alternating`` solves for the texture at every step (Wiberg's algorithm), ``simultaneous`` changes texture and warp
    together, ``project_out`` ignores the texture by projection, with the Jacobian of the mean face: fastest, and least
    exact where faces differ from the mean.

    Raises
    ------
    SettingError
        A value is out of bounds.
    """

    section = "fitting"
    variant: str = setting(
        "alternating",
        "Inverse-compositional algorithm: texture solved for at every step (Wiberg), optimised together with the warp, "
        "or projected out (fastest, least exact).",
        choices=VARIANTS,
    )
    start: str = setting(
        "landmarks",
        "Where the fit of a frame starts: at the tracked landmarks, or at the fit of the previous frame (slower; at "
        "the landmarks where that one diverged).",
        choices=STARTS,
    )
    scales: tuple[int, ...] = setting(
        (2, 1),
        "Scales of the pyramid, fitted coarse to fine: how many texture pixels each way are averaged into one.",
        item={"description": "Texture pixels each way that are averaged into one.", "minimum": 1, "maximum": 16},
        min_items=1,
        max_items=8,
        unique=True,
    )
    iterations: int = setting(15, "Maximum number of iterations at each scale.", minimum=1, maximum=1000)
    tolerance: float = setting(
        0.03,
        "A frame has converged at a scale once no point moves farther than this in an iteration, in texture pixels.",
        minimum=0.00001,
        maximum=100,
    )
    shape_modes: int = setting(
        24, "Maximum number of shape components that are fitted, the leading ones.", minimum=0, maximum=10_000
    )
    texture_modes: int = setting(
        40, "Maximum number of texture components that are fitted, the leading ones.", minimum=0, maximum=10_000
    )
    prior_weight: float = setting(
        10.0,
        "Weight of the Gaussian prior on the shape parameters, 1 being right for independent pixel noise (neighbouring "
        "pixels are correlated, so it is larger); 0 for no prior.",
        minimum=0,
        maximum=1e12,
    )
    shape_limit: float = setting(
        4.0,
        "Shape parameters are clipped to this many standard deviations.",
        minimum=0.01,
        maximum=1000,
    )
    batch_size: int = setting(75, "Number of frames fitted at a time.", minimum=1, maximum=1000)
    max_error_ratio: float = setting(
        3.0,
        "A fit has diverged if its residual exceeds this multiple of the residual that the model leaves of training "
        "faces.",
        minimum=0.01,
        maximum=1000,
    )
    max_error_growth: float = setting(
        1.1,
        "A fit has diverged if its residual exceeds this multiple of the residual at its start.",
        minimum=0.01,
        maximum=1000,
    )
    max_displacement: float = setting(
        0.25,
        "A fit has diverged if its points lie farther from the start than this on average, as a share of the face's "
        "size (root mean square distance of the points from their centre).",
        minimum=0.001,
        maximum=100,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "scales", tuple(sorted(self.scales, reverse=True)))


@dataclass(frozen=True)
class Level:
    """One scale of a fitting model.

    Parameters
    ----------
    mesh : the mesh with the pixels of this scale
    averaging : sparse (U, U of the grid): textures of this scale from those of the grid
    mean : (U,) mean texture in grey levels; components (K, U) orthonormal
    jacobians : ((K + 1) (4 + n), U) J_ki without what the components explain, k slowest
    overlap : (K + 1, 4 + n, K) what they do explain of each J_ki
    pairs : two index arrays (P,), the products c_k c_l with k <= l
    hessians : (P, (4 + n)^2) the Hessian's coefficient of each product
    """

    mesh: Mesh
    averaging: object
    mean: np.ndarray
    components: np.ndarray
    jacobians: np.ndarray
    overlap: np.ndarray
    pairs: tuple[np.ndarray, np.ndarray]
    hessians: np.ndarray


@dataclass(frozen=True)
class FittingModel:
    """An active appearance model prepared for fitting with given settings.

    Parameters
    ----------
    shapes : the shape space, in the units of the shapes it was made from
    scale : grid pixels to one such unit
    levels : one :class:`Level` a scale, coarse to fine
    noise : root mean square in grey levels of what the texture modes leave of a training face
    settings : the settings
    """

    shapes: ShapeSpace
    scale: float
    levels: tuple[Level, ...]
    noise: float
    settings: FittingSettings

    @classmethod
    def build(
        cls,
        mesh: Mesh,
        shape: tuple[np.ndarray, np.ndarray, np.ndarray],
        texture: tuple[np.ndarray, np.ndarray],
        noise: float,
        settings: FittingSettings | None = None,
    ) -> "FittingModel":
        """From the analyses of shapes and grey textures.

        Parameters
        ----------
        mesh : with U pixels, its base mesh a scaled (and perhaps moved or opened) mean shape
        shape : mean (N, 2), components (n, N, 2), variances (n,)
        texture : mean (U,), components (K, U), in grey levels
        noise : see the class

        Raises
        ------
        DataError
            Mesh, shapes and textures do not belong together.
        """
        settings = settings or FittingSettings()
        mean, components = (np.asarray(part, np.float32) for part in texture)
        if mean.shape != (mesh.size,) or components.shape[1:] != mean.shape or len(shape[0]) != len(mesh.points):
            raise DataError(
                f"a mesh of {len(mesh.points)} points and {mesh.size} pixels does not fit shapes of {len(shape[0])} "
                f"points and textures {mean.shape} with components {components.shape}"
            )
        kept = settings.shape_modes
        space = ShapeSpace.of(shape[0], shape[1][:kept], shape[2][:kept])
        grid = mesh.points - mesh.points.mean(axis=0)
        scale = float((grid * space.mean).sum() / np.square(space.mean).sum())
        modes = components[: settings.texture_modes]
        levels = tuple(_level(*mesh.coarser(factor), mean, modes, scale * space.changes) for factor in settings.scales)
        return cls(space, scale, levels, float(noise), settings)

    @classmethod
    def of_aam(cls, aam, reference, settings: FittingSettings | None = None) -> "FittingModel":
        """From a trained :class:`~visualspeech.face.aam.model.Aam` and its texture grid.

        Raises
        ------
        DataError
            They are not of one run.
        """
        if len(aam.texture_mean) != 3 * reference.size:
            raise DataError(
                f"the AAM has textures of {len(aam.texture_mean)} values, the reference one of {3 * reference.size}; "
                "they are not of one run"
            )
        settings = settings or FittingSettings()
        modes = grey(aam.texture_components[: settings.texture_modes])
        left = max(float(aam.totals[1] - aam.texture_variances[: settings.texture_modes].sum()), 0)
        shape = to_points(aam.shape_mean), to_points(aam.shape_components), aam.shape_variances
        noise = np.sqrt(left / len(aam.texture_mean))
        return cls.build(Mesh.of_reference(reference), shape, (grey(aam.texture_mean), modes), noise, settings)


def grey(textures: np.ndarray) -> np.ndarray:
    """Luminance (..., U) of textures (..., 3U)."""
    textures = np.asarray(textures, np.float32)
    return np.einsum("...cu,c->...u", textures.reshape(*textures.shape[:-1], 3, -1), LUMA)


def _level(mesh: Mesh, averaging, mean: np.ndarray, modes: np.ndarray, changes: np.ndarray) -> Level:
    mean = np.asarray(averaging @ mean, np.float32)
    components = _orthonormal(np.asarray(averaging @ modes.T, np.float32).T)
    every = steepest_descent(mesh, np.concatenate([mean[None], components]), changes)
    overlap = every @ components.T
    free = every - overlap @ components
    first, second = np.triu_indices(len(every))
    count, size, pixels = free.shape
    flat = free.reshape(-1, pixels)
    gram = (flat @ flat.T).reshape(count, size, count, size).transpose(0, 2, 1, 3)
    hessians = gram[first, second] + np.where((first == second)[:, None, None], 0, gram[second, first])
    flat_hessians = np.ascontiguousarray(hessians.reshape(len(first), -1))
    return Level(mesh, averaging, mean, components, flat, overlap, (first, second), flat_hessians)


def steepest_descent(mesh: Mesh, images: np.ndarray, changes: np.ndarray) -> np.ndarray:
    """J_ki (K, I, U): derivatives of images (K, U) of the grid with respect to the warp of their pixels.

    Parameters
    ----------
    changes : (I, N, 2) displacement of the base mesh's corners, in grid pixels, for a unit of each parameter
    """
    along, down = mesh.gradients(np.asarray(images, np.float32))
    moves = np.einsum("un,ina->aiu", mesh.weights, changes.astype(np.float32), optimize=True)
    return along[:, None] * moves[0] + down[:, None] * moves[1]


def _orthonormal(rows: np.ndarray) -> np.ndarray:
    if not len(rows):
        return rows
    _, values, basis = np.linalg.svd(rows, full_matrices=False)
    return np.ascontiguousarray(basis[values > 1e-4 * values[0]])
