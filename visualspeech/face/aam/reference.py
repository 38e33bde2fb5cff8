"""The reference face: mean shape, mesh, texture grid; textures in and out by piecewise-affine warps (Fan 2015, 3.2).

The texture of a face is read at the pixels inside the mean shape (Eq. 4): each pixel has fixed barycentric coordinates
in one triangle of the mesh, and so a place in any other face that has the same points. It is read from the recorded
picture directly, by one interpolation: the warp takes the head pose out as well, triangle by triangle.
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.points import INNER_LIPS, LIPS, LOWERED, POINTS, TRIANGLES
from visualspeech.fields import Settings, restored, setting
from visualspeech.storage import read_model_of, write_model

_INNER = range(INNER_LIPS.start, INNER_LIPS.stop)
_UPPER, _LOWER = INNER_LIPS.start + 2, INNER_LIPS.start + 6  # middle of the upper and of the lower inner lip
_CORNERS = INNER_LIPS.start, INNER_LIPS.start + 4


@dataclass(frozen=True)
class ReferenceSettings(Settings):
    """Grid of pixels at which textures are sampled.

    In a mean face the lips nearly touch, and teeth and mouth cavity would have no pixels: the chin of the grid is
    lowered until the mouth is open.
    """

    section = "texture"
    # OpenCV reads no more than 32766 places at a time.
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
    mean_shape : (51, 2) pixels of the normalised face (s_0 of Eq. 2)
    grid_shape : (51, 2) the mean shape with opened mouth in pixels of the texture grid, (x, y)
    pixels : (U, 2) int32 row and column of each texture pixel in the grid, row by row
    triangle : (U,) int32 the triangle each pixel lies in
    barycentric : (U, 3) its barycentric coordinates in that triangle
    nearest : (height, width) int32 the texture pixel nearest to each place of the grid's bounding box
    settings : the settings it was made with
    """

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
        """Sparse (U, 51): place of each texture pixel = weights @ points."""
        from scipy.sparse import csr_array

        rows = np.repeat(np.arange(self.size), 3)
        corners = TRIANGLES[self.triangle].ravel()
        return csr_array((self.barycentric.ravel(), (rows, corners)), shape=(self.size, POINTS))

    def save(self, path: str | Path) -> None:
        write_model(path, {name: getattr(self, name) for name in _ARRAYS}, asdict(self.settings))

    @classmethod
    def load(cls, path: str | Path) -> "Reference":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.read_model_of`."""
        tensors, settings = read_model_of(path, "texture grid", [None], _ARRAYS)
        return cls(settings=restored(ReferenceSettings, settings, path), **tensors)


_ARRAYS = ("mean_shape", "grid_shape", "pixels", "triangle", "barycentric", "nearest")


def fit_reference(shapes: Iterable[np.ndarray], settings: ReferenceSettings | None = None) -> Reference:
    """Mean shape (Eq. 2) and texture grid.

    Parameters
    ----------
    shapes : (T, 51, 2) arrays of pose-normalised points in pixels, one for instance for each training utterance; read
        once, memory does not grow with their number

    Raises
    ------
    DataError
        There are no shapes, they have another form, or the mean is no face (a triangle of the mesh is folded over).
    """
    settings = settings or ReferenceSettings()
    total, count = np.zeros((POINTS, 2)), 0
    for chunk in shapes:
        if chunk.shape[1:] != (POINTS, 2):
            raise DataError(f"expected shapes (frames, {POINTS}, 2), got {chunk.shape}")
        total += chunk.sum(axis=0, dtype=np.float64)
        count += len(chunk)
    if not count:
        raise DataError("no shapes to take a mean of: every training utterance was rejected or empty")
    mean = total / count
    opened = open_mouth(mean, settings.mouth_opening)
    areas = _areas(opened)
    if not np.all(areas > 0):
        raise DataError(
            "the mean of the landmarks is not a face: "
            f"{int((areas <= 0).sum())} triangles of its mesh are folded over. Look at the tracked landmarks."
        )
    scale = np.sqrt(settings.texture_pixels / areas.sum())
    grid = (opened - opened.min(axis=0)) * scale + 1
    width, height = np.ceil(grid.max(axis=0)).astype(int) + 2
    triangle, barycentric = _rasterise(grid, height, width)
    inside = triangle >= 0
    return Reference(
        mean_shape=mean,
        grid_shape=grid,
        pixels=np.argwhere(inside).astype(np.int32),
        triangle=triangle[inside],
        barycentric=barycentric[inside],
        nearest=_nearest(inside),
        settings=settings,
    )


def open_mouth(shape: np.ndarray, opening: float) -> np.ndarray:
    """Lower the chin of a shape (51, 2) until the inner mouth is at least ``opening`` of its width high."""
    width = np.linalg.norm(shape[_CORNERS[1]] - shape[_CORNERS[0]])
    down = max(0.0, opening * width - (shape[_LOWER, 1] - shape[_UPPER, 1]))
    return shape + np.stack([np.zeros(POINTS), LOWERED * down], axis=1)


def sample_texture(frame: np.ndarray, image_points: np.ndarray, reference: Reference) -> np.ndarray:
    """The texture (r_1..r_U, g_1..g_U, b_1..b_U) of one face (Eq. 4), (3U,) uint8.

    Parameters
    ----------
    frame : (height, width, 3) uint8 RGB, as recorded
    image_points : (51, 2) the lower-face points in this frame, pixels; the colour at (x, y) is that of the pixel whose
        centre is there, between centres it is interpolated linearly, outside the frame the edge is continued
    """
    import cv2

    places = (reference.weights @ np.asarray(image_points, np.float64)).astype(np.float32)
    # Places in one row: OpenCV gives the same numbers as for one column, and sooner.
    x, y = np.ascontiguousarray(places.T)[:, None]
    colours = cv2.remap(frame, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.ascontiguousarray(colours[0].T).reshape(-1)


def sample_textures(frames: Iterable[np.ndarray], image_points: np.ndarray, reference: Reference) -> np.ndarray:
    """The textures of an utterance, (T, 3U) uint8: frames in order, image_points (T, 51, 2).

    Raises
    ------
    DataError
        There are not as many frames as points.
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


def texture_picture(texture: np.ndarray, reference: Reference) -> np.ndarray:
    """A texture (3U,) as a picture of the grid, (height, width, 3), same type; around the face its edge goes on."""
    return texture.reshape(3, -1).T[reference.nearest]


def paint(texture: np.ndarray, points: np.ndarray, reference: Reference, canvas: np.ndarray) -> np.ndarray:
    """The picture with a texture painted at the given points: the inverse of :func:`sample_texture`.

    Parameters
    ----------
    texture : (3U,) grey levels, any number type; rounded and clipped to 0..255
    points : (51, 2) where the points are in the picture
    canvas : (height, width, 3) uint8; a painted copy is returned
    """
    import cv2

    colours, inside = render(texture, points, reference, *canvas.shape[:2])
    return cv2.copyTo(colours, inside.view(np.uint8), canvas.copy())


def render(
    texture: np.ndarray, points: np.ndarray, reference: Reference, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """Colours (height, width, 3) uint8 and mask (height, width) bool of a texture at the given points.

    Every pixel of the face looks up its place in the texture grid, so there are no holes. A triangle that is folded
    over (lips pressed past each other) is left out; lips lie over skin, skin over the mouth's inside.
    """
    import cv2

    colours = np.zeros((height, width, 3), np.uint8)
    index = triangle_map(points, height, width)
    inside = index >= 0
    rows, columns = np.nonzero(inside)
    if not len(rows):
        return colours, inside
    maps = _affine_maps(np.asarray(points, np.float64), reference.grid_shape).astype(np.float32)[index[rows, columns]]
    places = maps[..., 0] * columns[:, None] + maps[..., 1] * rows[:, None] + maps[..., 2]
    picture = texture_picture(np.asarray(texture, np.float32), reference)
    x, y = np.ascontiguousarray(places.T, np.float32)[:, None]
    values = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
    colours[rows, columns] = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return colours, inside


def triangle_map(points: np.ndarray, height: int, width: int) -> np.ndarray:
    """Which triangle of the mesh is seen at each pixel, (height, width) int16; -1 outside the face."""
    import cv2

    drawn = np.zeros((height, width), np.uint8)
    corners = np.rint(np.asarray(points, np.float64)[TRIANGLES] * 16).astype(np.int32)
    folded = _areas(np.asarray(points, np.float64)) <= 0
    for number in _drawing_order():
        if not folded[number]:
            cv2.fillConvexPoly(drawn, corners[number], int(number) + 1, lineType=cv2.LINE_8, shift=4)
    return drawn.astype(np.int16) - 1


def _drawing_order() -> np.ndarray:
    lips = ((TRIANGLES >= LIPS.start) & (TRIANGLES < LIPS.stop)).all(axis=1)
    mouth = np.isin(TRIANGLES, _INNER).all(axis=1)
    return np.concatenate([np.nonzero(mouth)[0], np.nonzero(~lips)[0], np.nonzero(lips & ~mouth)[0]])


def _areas(points: np.ndarray) -> np.ndarray:
    """Signed areas of the triangles, positive where a triangle has its proper turn."""
    a, b, c = np.moveaxis(points[TRIANGLES], 1, 0)
    ab, ac = b - a, c - a
    return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2


def _affine_maps(source: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Of each triangle the affine map source -> target as (n, 2, 3); of a triangle without area, no use and zero."""
    corners = np.concatenate([source[TRIANGLES], np.ones((len(TRIANGLES), 3, 1))], axis=2)
    flat = np.abs(_areas(source)) < 1e-9
    corners[flat] = np.eye(3)
    maps = np.swapaxes(np.linalg.solve(corners, target[TRIANGLES]), 1, 2)
    maps[flat] = 0
    return maps


def _rasterise(points: np.ndarray, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangle (height, width) int32, -1 outside, and barycentric coordinates (height, width, 3) of each pixel."""
    triangle = np.full((height, width), -1, np.int32)
    barycentric = np.zeros((height, width, 3))
    for number, corners in enumerate(points[TRIANGLES]):
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
