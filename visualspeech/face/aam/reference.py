"""The reference face: mean shape, mesh and texture grid; reading and painting of textures by piecewise-affine warps.

The texture of a face is sampled at the pixels inside the mean shape (Eq. 4): each pixel has fixed barycentric
coordinates in one triangle of the mesh, and so a position in every other face with the same points. It is sampled from
the recorded frame directly, by one interpolation: the warp removes the head pose as well, triangle by triangle.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.face.drift import DriftSettings, Faces
from visualspeech.face.point_sets import PointSet, stored_point_set, to_vector
from visualspeech.fields import Settings, restored, setting
from visualspeech.storage.layouts import TEXT, Array, FileLayout
from visualspeech.storage.models import read_model_of, write_model

KIND = "texture grid"


@dataclass(frozen=True)
class ReferenceSettings(Settings):
    """Grid of pixels at which textures are sampled.

    In a mean face the lips nearly touch, and teeth and mouth cavity would have no pixels: the chin of the grid is
    lowered until the mouth is open.
    """

    section = "texture"
    # OpenCV's remap reads at most 32766 positions at a time.
    texture_pixels: int = setting(
        6000,
        "Approximate number of pixels of a texture (U of Eq. 4), to which the grid is scaled.",
        minimum=100,
        maximum=30_000,
    )
    mouth_opening: float = setting(
        0.2,
        "Minimum height of the inner mouth in the grid, as a share of the mouth's width.",
        minimum=0.001,
        maximum=1,
    )


@dataclass(frozen=True)
class Reference:
    """Mean shape and texture grid of a corpus.

    Parameters
    ----------
    points : the point set, of N points
    mean_shape : (N, 2) pixels of the normalised face (s_0 of Eq. 2)
    grid_shape : (N, 2) the mean shape with opened mouth in pixels of the texture grid, (x, y)
    pixels : (U, 2) int32 row and column of each texture pixel in the grid, row by row
    triangle : (U,) int32 the triangle each pixel lies in
    barycentric : (U, 3) its barycentric coordinates in that triangle
    nearest : (height, width) int32 the texture pixel nearest to each pixel of the grid's bounding box
    settings : the settings it was made with
    """

    points: PointSet
    mean_shape: np.ndarray
    grid_shape: np.ndarray
    pixels: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray
    nearest: np.ndarray
    settings: ReferenceSettings = field(default_factory=ReferenceSettings)

    @property
    def size(self) -> int:
        """U, the number of texture pixels; a texture has 3U values."""
        return len(self.pixels)

    @cached_property
    def weights(self):
        """Sparse (U, N): position of each texture pixel = weights @ points."""
        from scipy.sparse import csr_array

        rows = np.repeat(np.arange(self.size), 3)
        corners = self.points.triangles[self.triangle].ravel()
        return csr_array((self.barycentric.ravel(), (rows, corners)), shape=(self.size, self.points.size))

    def save(self, path: str | Path) -> None:
        """Write the grid as safetensors, with the name of its point set."""
        metadata = {"kind": KIND, "points": self.points.name, "settings": asdict(self.settings)}
        write_model(path, {name: getattr(self, name) for name in _ARRAYS}, metadata)

    @classmethod
    def load(cls, path: str | Path) -> "Reference":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.models.read_model_of`."""
        tensors, stored = read_model_of(path, KIND, [KIND], LAYOUT)
        settings = restored(ReferenceSettings, stored["settings"], path)
        made = cls(stored_point_set(stored["points"], path), **tensors, settings=settings)
        _check_grid(path, made)
        return made


_ARRAYS = {
    "mean_shape": Array("f", ("P", 2), -1e5, 1e5),
    "grid_shape": Array("f", ("P", 2), 0, 1e5),
    "pixels": Array("iu", ("U", 2), 0, 1e5),
    "triangle": Array("iu", ("U",), 0, 1e5),
    "barycentric": Array("f", ("U", 3), -0.01, 1.01),
    "nearest": Array("iu", ("H", "W"), 0, 1e5),
}
#: P points, U texture pixels, H by W pixels of the grid's bounding box.
LAYOUT = FileLayout(_ARRAYS, {"points": TEXT, "settings": {"type": "object"}})
_MOST_PIXELS = 32_766  # of a texture: positions that OpenCV reads at a time


def _check_grid(path, grid: Reference) -> None:
    """Refuse indices that point beyond the grid and its mesh, and a mesh that is folded over."""
    points, height_width = grid.points, grid.nearest.shape
    if len(grid.grid_shape) != points.size:
        raise DamagedFile(path, f"it has {len(grid.grid_shape)} points, the point set {points.name} {points.size}")
    inside = (
        grid.size <= _MOST_PIXELS
        and (grid.pixels < height_width).all()
        and grid.triangle.max() < len(points.triangles)
        and grid.nearest.max() < grid.size
        and (grid.grid_shape < height_width[::-1]).all()
    )
    if not inside or (points.areas(grid.grid_shape) < 1e-3).any():
        raise DamagedFile(path, "its pixels, its mesh and its triangles do not fit each other")


def fit_reference(
    shapes: Iterable[np.ndarray], points: PointSet, settings: ReferenceSettings | None = None
) -> Reference:
    """Mean shape (Eq. 2) and texture grid.

    Parameters
    ----------
    shapes : (T, N, 2) arrays of pose-normalised points in pixels, for example one per training utterance; read once,
        memory does not grow with their number
    points : the point set, of N points

    Raises
    ------
    DataError
        There are no shapes, they have another form, or the mean is no face (a triangle of the mesh is folded over).
    """
    settings = settings or ReferenceSettings()
    total, count = np.zeros((points.size, 2)), 0
    for chunk in shapes:
        if chunk.shape[1:] != (points.size, 2):
            raise DataError(f"expected shapes (frames, {points.size}, 2), got {chunk.shape}")
        total += chunk.sum(axis=0, dtype=np.float64)
        count += len(chunk)
    if not count:
        raise DataError("no shapes to average: every training utterance was rejected or is empty")
    mean = total / count
    opened = points.open_mouth(mean, settings.mouth_opening)
    areas = points.areas(opened)
    if not np.all(areas > 0):
        raise DataError(
            "the mean of the landmarks is not a face: "
            f"{int((areas <= 0).sum())} triangles of its mesh are folded over. Look at the tracked landmarks."
        )
    scale = np.sqrt(settings.texture_pixels / areas.sum())
    grid = (opened - opened.min(axis=0)) * scale + 1
    width, height = np.ceil(grid.max(axis=0)).astype(int) + 2
    triangle, barycentric = _rasterise(grid[points.triangles], height, width)
    inside = triangle >= 0
    return Reference(
        points=points,
        mean_shape=mean,
        grid_shape=grid,
        pixels=np.argwhere(inside).astype(np.int32),
        triangle=triangle[inside],
        barycentric=barycentric[inside],
        nearest=_nearest(inside),
        settings=settings,
    )


def fit_reference_of(
    pose, ids: Iterable[str], points: PointSet, settings: ReferenceSettings | None = None
) -> Reference:
    """The mean shape and texture grid of training utterances; raises as :func:`fit_reference`.

    Parameters
    ----------
    pose : opened files with ``points`` (T, 68, 2) of each utterance, landmarks in pixels of the normalised face
    ids : the training utterances
    points : the point set of the grid
    """
    return fit_reference((points.select(pose.array(name, "points")) for name in ids), points, settings)


def sample_texture(frame: np.ndarray, image_points: np.ndarray, reference: Reference) -> np.ndarray:
    """The texture (r_1..r_U, g_1..g_U, b_1..b_U) of one face (Eq. 4), (3U,) uint8.

    Parameters
    ----------
    frame : (height, width, 3) uint8 RGB, as recorded
    image_points : (N, 2) the points in this frame, pixels; the colour at (x, y) is that of the pixel whose centre is
        there, between centres it is interpolated linearly, outside the frame the edge is continued. A face larger
        than the grid is smoothed first, so that what the grid cannot hold does not fold back as a pattern
    """
    import cv2

    image_points = np.asarray(image_points, np.float64)
    frame, corner = _prefiltered(frame, image_points, reference)
    positions = (reference.weights @ (image_points - corner)).astype(np.float32)
    # Positions in one row rather than one column: the numbers are the same, and OpenCV is faster.
    x, y = np.ascontiguousarray(positions.T)[:, None]
    colours = cv2.remap(frame, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(colours[0].T).reshape(-1)


def _prefiltered(frame: np.ndarray, points: np.ndarray, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """The part of a frame around a face, smoothed for the grid, and its corner (x, y); the frame where it need not be.

    With s pixels of the frame per pixel of the grid, the Gaussian has the standard deviation (s - 1) / 2, as that of
    :func:`skimage.transform.resize`.
    """
    import cv2

    areas = (np.abs(reference.points.areas(one)).sum() for one in (points, reference.grid_shape.astype(np.float64)))
    deviation = (np.sqrt(next(areas) / next(areas)) - 1) / 2
    # A narrower one does not change grey levels that are integers.
    if not deviation > 0.2:
        return frame, np.zeros(2)
    margin, size = np.ceil(4 * deviation) + 1, np.array(frame.shape[1::-1])
    low = np.clip(np.floor(points.min(axis=0) - margin), 0, size - 1).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + margin) + 1, low + 1, size).astype(int)
    part = frame[low[1] : high[1], low[0] : high[0]]
    return cv2.GaussianBlur(part, (0, 0), float(deviation), borderType=cv2.BORDER_REPLICATE), low


def sample_textures(frames: Iterable[np.ndarray], image_points: np.ndarray, reference: Reference) -> np.ndarray:
    """The textures of an utterance, (T, 3U) uint8: frames in order, image_points (T, N, 2).

    Raises
    ------
    DataError
        The numbers of frames and of faces differ.
    """
    textures = np.empty((len(image_points), 3 * reference.size), np.uint8)
    done = 0
    for frame in frames:
        if done < len(textures):
            textures[done] = sample_texture(frame, image_points[done], reference)
        done += 1
    if done != len(textures):
        raise DataError(f"{done} frames in the recording but landmarks for {len(textures)}")
    return textures


def sample_faces(
    frames: Iterable[np.ndarray],
    landmarks: np.ndarray,
    frontal: np.ndarray,
    reference: Reference,
    silent: np.ndarray | None = None,
    drift: DriftSettings | None = None,
    *,
    rate: float,
) -> Faces:
    """The faces of one utterance at the tracker's points: shapes, textures and the utterance's reference face.

    Parameters
    ----------
    frames : T frames of the recording in order, (height, width, 3) uint8 RGB
    landmarks : (T, 68, 2) in these frames, pixels
    frontal : (T, 68, 2) the same landmarks in the normalised face, pixels
    silent : (T,) bool, frames without speech; needed by the drift method ``silence`` only
    rate : frame rate in Hz

    Raises
    ------
    DataError
        The numbers of frames, landmarks and silent frames differ.
    """
    texture = sample_textures(frames, reference.points.select(landmarks), reference)
    return Faces.of(to_vector(reference.points.select(frontal)), texture, silent, drift, rate=rate)


def texture_image(texture: np.ndarray, reference: Reference) -> np.ndarray:
    """A texture (3U,) as an image of the grid, (height, width, 3), same type; around the face its edge is continued."""
    return texture.reshape(3, -1).T[reference.nearest]


def paint(texture: np.ndarray, points: np.ndarray, reference: Reference, canvas: np.ndarray) -> np.ndarray:
    """The image with a texture painted at the given points: the inverse of :func:`sample_texture`.

    Parameters
    ----------
    texture : (3U,) grey levels, any number type; rounded and clipped to 0..255
    points : (N, 2) pixels, where the points are in the image
    canvas : (height, width, 3) uint8; a painted copy is returned
    """
    import cv2

    colours, inside = render(texture, points, reference, *canvas.shape[:2])
    return cv2.copyTo(colours, inside.view(np.uint8), canvas.copy())


def render(
    texture: np.ndarray, points: np.ndarray, reference: Reference, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Colours (height, width, 3) uint8 and mask (height, width) bool of a texture at the given points.

    Every pixel of the face looks up its position in the texture grid, so there are no holes. A triangle that is folded
    over (lips pressed past each other) is left out; lips lie over skin, skin over the inside of the mouth.
    """
    import cv2

    colours = np.zeros((height, width, 3), np.uint8)
    index = triangle_map(points, reference.points, height, width)
    inside = index >= 0
    rows, columns = np.nonzero(inside)
    if not len(rows):
        return colours, inside
    maps = _affine_maps(np.asarray(points, np.float64), reference).astype(np.float32)[index[rows, columns]]
    positions = maps[..., 0] * columns[:, None] + maps[..., 1] * rows[:, None] + maps[..., 2]
    image = texture_image(np.asarray(texture, np.float32), reference)
    x, y = np.ascontiguousarray(positions.T, np.float32)[:, None]
    values = cv2.remap(image, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
    colours[rows, columns] = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return colours, inside


def triangle_map(points: np.ndarray, point_set: PointSet, height: int, width: int) -> np.ndarray:
    """Index of the triangle that is seen at each pixel of a face (N, 2), (height, width) int16; -1 outside the face."""
    import cv2

    drawn = np.zeros((height, width), np.uint8)
    corners = np.rint(np.asarray(points, np.float64)[point_set.triangles] * 16).astype(np.int32)
    folded = point_set.areas(np.asarray(points, np.float64)) <= 0
    for number in point_set.drawing_order:
        if not folded[number]:
            cv2.fillConvexPoly(drawn, corners[number], int(number) + 1, lineType=cv2.LINE_8, shift=4)
    return drawn.astype(np.int16) - 1


def _affine_maps(face: np.ndarray, reference: Reference) -> np.ndarray:
    """The affine map (M, 2, 3) of each triangle from a face (N, 2) to the grid; zero for a triangle without area."""
    triangles = reference.points.triangles
    corners = np.concatenate([face[triangles], np.ones((len(triangles), 3, 1))], axis=2)
    flat = np.abs(reference.points.areas(face)) < 1e-9
    corners[flat] = np.eye(3)
    maps = np.swapaxes(np.linalg.solve(corners, reference.grid_shape[triangles]), 1, 2)
    maps[flat] = 0
    return maps


def _rasterise(triangles: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Index of the triangle, of those with corners (M, 3, 2), that each pixel lies in, and barycentric coordinates.

    (height, width) int32, -1 outside; (height, width, 3).
    """
    triangle = np.full((height, width), -1, np.int32)
    barycentric = np.zeros((height, width, 3))
    for number, corners in enumerate(triangles):
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.ceil(corners.max(axis=0)).astype(int) + 1
        rows, columns = np.mgrid[low[1] : min(high[1], height), low[0] : min(high[0], width)]
        at = np.stack([columns, rows, np.ones_like(rows)], axis=-1).reshape(-1, 3)
        parts = at @ np.linalg.inv(np.column_stack([corners, np.ones(3)]))
        own = (parts >= -1e-9).all(axis=1) & (triangle[rows, columns].ravel() < 0)
        triangle[rows.ravel()[own], columns.ravel()[own]] = number
        barycentric[rows.ravel()[own], columns.ravel()[own]] = parts[own]
    return triangle, barycentric


def _nearest(inside: np.ndarray) -> np.ndarray:
    from scipy.ndimage import distance_transform_edt

    rows, columns = distance_transform_edt(~inside, return_distances=False, return_indices=True)
    numbers = np.cumsum(inside.ravel(), dtype=np.int32).reshape(inside.shape) - 1
    return numbers[rows, columns]
