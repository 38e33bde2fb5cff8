"""A talking head: a synthetic lower face stitched onto the recorded one, frame by frame.

The recording keeps its head, eyes, hair and background. In every frame its jaw and cheeks are warped to where the
target has them (:mod:`visualspeech.animation.warping`), and the target's texture is painted over mouth and chin by the
piecewise-affine warp of the appearance model. The painting fades out between the lips and the jaw line, and between
the upper lip and the nose; its colours are matched to those of the recording along that seam by an offset that varies
slowly over the face and is smoothed in time, for an offset found in each frame separately would flicker.

The point set of the texture grid defines which points control the warp, follow the target and outline the painting.
"""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, repeat

import numpy as np

from visualspeech.animation.warping import backward_map
from visualspeech.errors import DataError
from visualspeech.face.aam.reference import Reference, sample_texture, texture_image, triangle_map
from visualspeech.face.head import HeadModel
from visualspeech.face.landmarks import smooth
from visualspeech.face.point_sets import PointSet, to_points
from visualspeech.face.pose import Pose, to_frontal, to_image
from visualspeech.fields import Settings, setting


@dataclass(frozen=True)
class RenderSettings(Settings):
    """Blending of the synthetic lower face into the recorded frame."""

    section = "rendering"
    seam_width: float = setting(
        0.6,
        "Width of the seam in which the painted texture fades in, as a share of the distance from the border of the "
        "painted region to the lips.",
        minimum=0.001,
        maximum=1,
    )
    warp_reach: float = setting(
        0.45,
        "Distance around the lower face up to which the recorded frame is warped, as a share of the face's width.",
        minimum=0.2,
        maximum=2,
    )
    point_smoothing: float = setting(
        0.04,
        "Standard deviation, in seconds, of the Gaussian that smooths the recorded points and the target's jaw and "
        "cheeks (not its lips) over time; 0 for none.",
        minimum=0,
        maximum=10,
    )
    colour_smoothing: float = setting(
        0.08,
        "Standard deviation, in seconds, of the Gaussian that smooths the colour offset over time; 0 for none.",
        minimum=0,
        maximum=10,
    )
    max_colour_offset: float = setting(
        60.0, "Maximum colour offset between texture and recording, in grey levels.", minimum=0, maximum=255
    )


@dataclass(frozen=True)
class Placement:
    """Positions of the face in the frames of one utterance, in pixels of the recording.

    The N points of the point set come first, the H landmarks that it holds where they were recorded after them.

    Parameters
    ----------
    recorded : (T, N + H, 2) as recorded
    target : (T, N + H, 2) as rendered
    """

    recorded: np.ndarray
    target: np.ndarray

    def __len__(self) -> int:
        return len(self.recorded)


def place(
    landmarks: np.ndarray,
    shape: np.ndarray,
    pose: Pose,
    head: HeadModel,
    points: PointSet,
    settings: RenderSettings | None = None,
    *,
    rate: float,
) -> Placement:
    """Positions of the lower face in the recorded frames for frontal target shapes.

    Parameters
    ----------
    landmarks : (T, 68, 2) recorded landmarks in image pixels
    shape : (T, 2N) target shape vectors (Fan 2015, Eq. 1) in pixels of the normalised face, with the drift of the
        utterance put back
    pose : of these T frames
    points : the point set, of N points
    rate : frame rate in Hz

    Raises
    ------
    DataError
        Landmarks, shapes and poses are not of one length.
    """
    settings = settings or RenderSettings()
    if not len(landmarks) == len(shape) == len(pose):
        raise DataError(f"{len(landmarks)} frames of landmarks, {len(shape)} target shapes, {len(pose)} poses")
    depth = (points.warp_selection @ head.points3d)[:, 2]
    # Smoothed in the normalised face, where the head's own movement is not smoothed with it.
    frontal = to_frontal(points.select_for_warp(np.asarray(landmarks, np.float64)), pose, head, depth)
    recorded = smooth(frontal, settings.point_smoothing * rate)
    wanted = to_points(np.asarray(shape, np.float64))
    # The lips keep the target's own time course: they close for a frame or two only.
    wanted[:, points.slow] = smooth(wanted[:, points.slow], settings.point_smoothing * rate)
    target, modelled = recorded.copy(), recorded[:, : points.size]
    target[:, : points.size] = modelled + points.follows[:, None] * (wanted - modelled)
    return Placement(to_image(recorded, pose, head, depth), to_image(target, pose, head, depth))


@dataclass(frozen=True)
class Stitching:
    """Maps that all frames of a speaker share; made by :func:`prepare`.

    Parameters
    ----------
    opacity : (height, width) float32, of the texture grid: 1 on the lips, 0 at the border of the painted area
    basis : (U, 6) float32, slowly varying functions over the texture's pixels (a quadratic in x and y)
    fit : (6, U) float32, the least-squares fit of these functions to a texture along the seam
    """

    reference: Reference
    opacity: np.ndarray
    basis: np.ndarray
    fit: np.ndarray
    settings: RenderSettings


def prepare(reference: Reference, settings: RenderSettings | None = None) -> Stitching:
    """The maps in the texture grid that all frames of a speaker share."""
    import cv2

    settings = settings or RenderSettings()
    grid, points = reference.grid_shape, reference.points
    size = reference.nearest.shape

    def distance_from(polygon: np.ndarray, inside: bool) -> np.ndarray:
        filled = np.full(size, 0 if inside else 1, np.uint8)
        corners = np.rint(polygon * 16).astype(np.int32)
        cv2.fillPoly(filled, [corners], 1 if inside else 0, lineType=cv2.LINE_8, shift=4)
        return cv2.distanceTransform(filled, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)

    to_border = distance_from(grid[points.painted], inside=True)
    to_lips = distance_from(points.region(grid, "outer_lips"), inside=False)
    rise = np.clip(to_border / np.maximum(to_border + to_lips, 1e-6) / settings.seam_width, 0, 1)
    opacity = (rise * rise * (3 - 2 * rise)).astype(np.float32)
    rows, columns = reference.pixels.T
    x = 2 * columns / size[1] - 1
    y = 2 * rows / size[0] - 1
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=1)
    seam = opacity[rows, columns] * (1 - opacity[rows, columns])
    weighted = basis.T * seam
    ridge = seam.sum() * np.diag([0, 1e-3, 1e-3, 1e-2, 1e-2, 1e-2])
    fit = np.linalg.solve(weighted @ basis + ridge, weighted)
    return Stitching(reference, opacity, basis.astype(np.float32), fit.astype(np.float32), settings)


def colour_offset(frame: np.ndarray, recorded: np.ndarray, texture: np.ndarray, stitching: Stitching) -> np.ndarray:
    """Difference between the colours of the recording and of a texture along the seam, as coefficients (6, 3).

    Parameters
    ----------
    frame : (height, width, 3) uint8 RGB
    recorded : (N, 2) the recorded points in this frame, pixels; held landmarks after them are not used
    texture : (3U,) target texture in grey levels
    """
    reference = stitching.reference
    here = sample_texture(frame, recorded[: reference.points.size], reference).astype(np.float32)
    return stitching.fit @ (here - np.asarray(texture, np.float32)).reshape(3, -1).T


def stitch(
    frame: np.ndarray,
    recorded: np.ndarray,
    target: np.ndarray,
    texture: np.ndarray,
    stitching: Stitching,
    offset: np.ndarray | None = None,
) -> np.ndarray:
    """One frame with a synthetic lower face.

    Parameters
    ----------
    frame : (height, width, 3) uint8 RGB, as recorded
    recorded, target : (N + H, 2) points and held landmarks in this frame, as recorded and as rendered, pixels; see
        :class:`Placement`
    texture : (3U,) target texture in grey levels (Eq. 4), any number type
    offset : (6, 3) from :func:`colour_offset`, smoothed in time; by default that of this frame

    Returns
    -------
    (height, width, 3) uint8, a new frame
    """
    import cv2

    settings, points = stitching.settings, stitching.reference.points
    if offset is None:
        offset = colour_offset(frame, recorded, texture, stitching)
    first, last = points.face_width
    wide = np.linalg.norm(recorded[last] - recorded[first])
    reach = settings.warp_reach * wide
    result = frame.copy()
    low, high = _window(np.concatenate([recorded, target]), reach, frame.shape)
    if (high <= low).any():
        return result
    maps = backward_map(
        tuple(low.tolist()),
        tuple((high - low).tolist()),
        target[points.warp_controls],
        (target - recorded)[points.warp_controls],
        reach,
        stiffness=0.02,
        step=max(2, round(wide / 30)),
    )
    moved = cv2.remap(frame, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    result[low[1] : high[1], low[0] : high[0]] = moved
    face = target[: points.size]
    low, high = _window(face, 2, frame.shape)
    if (high <= low).any():
        return result
    region = result[low[1] : high[1], low[0] : high[0]]
    region[...] = _painted(region, face - low, texture, offset, stitching)
    return result


def talking_head(
    frames: Iterable[np.ndarray],
    placement: Placement,
    textures: Iterable[np.ndarray],
    reference: Reference,
    settings: RenderSettings | None = None,
    *,
    rate: float,
) -> Iterator[np.ndarray]:
    """The frames of an utterance with synthetic lower faces, one at a time.

    Memory does not grow with the length: only the frames that the smoothing of the colour offset looks ahead are held.

    Parameters
    ----------
    frames : T recorded frames, (height, width, 3) uint8 RGB
    placement : of these T frames
    textures : T target textures (3U,) in grey levels, with the drift of the utterance put back
    rate : frame rate in Hz

    Raises
    ------
    DataError
        The numbers of frames, textures and positions differ.
    """
    positions = zip(placement.recorded, placement.target, strict=True)
    yield from stitched(_paired(frames, positions, textures, len(placement)), reference, settings, rate=rate)


def stitched(
    parts: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]],
    reference: Reference,
    settings: RenderSettings | None = None,
    *,
    rate: float,
) -> Iterator[np.ndarray]:
    """Frames with synthetic lower faces, one at a time, of a stream whose length need not be known.

    Parameters
    ----------
    parts : per frame the recorded frame, the positions (N + H, 2) as recorded and as rendered, and the texture (3U,);
        see :func:`stitch`
    rate : frame rate in Hz
    """
    stitching = prepare(reference, settings)
    deviation = stitching.settings.colour_smoothing * rate
    ahead = int(np.ceil(2.5 * deviation))
    limit = stitching.settings.max_colour_offset
    waiting: deque = deque()
    offsets: deque = deque(maxlen=2 * ahead + 1)
    for index, part in enumerate(chain(parts, repeat(None))):
        if part is not None:
            frame, recorded, target, texture = part
            texture = np.asarray(texture, np.float32)
            waiting.append((index, frame, recorded, target, texture))
            offsets.append((index, colour_offset(frame, recorded, texture, stitching)))
        if waiting and index >= waiting[0][0] + ahead:
            now, frame, recorded, target, texture = waiting.popleft()
            offset = np.clip(_smoothed(offsets, now, deviation), -limit, limit)
            yield stitch(frame, recorded, target, texture, stitching, offset)
        if part is None and not waiting:
            return


def _paired(frames, positions, textures, count: int) -> Iterator[tuple]:
    """Each frame with its positions and texture; the lengths are checked as the streams end."""
    missing = object()
    frames, textures = iter(frames), iter(textures)
    for index, (recorded, target) in enumerate(positions):
        frame, texture = next(frames, missing), next(textures, missing)
        if frame is missing or texture is missing:
            what = "frames in the recording" if frame is missing else "target textures"
            raise DataError(
                f"{index} {what}, but the lower face has positions in {count} frames. Run the stages again."
            )
        yield frame, recorded, target, texture
    if next(frames, missing) is not missing:
        raise DataError(
            f"the recording has more than the {count} frames in which the lower face has positions. Run the stages "
            "again."
        )


def _smoothed(offsets, now: int, deviation: float) -> np.ndarray:
    if deviation == 0:
        return next(values for index, values in offsets if index == now)
    weights = np.array([np.exp(-0.5 * ((index - now) / deviation) ** 2) for index, _ in offsets], np.float32)
    return np.tensordot(weights / weights.sum(), np.stack([values for _, values in offsets]), axes=1)


def _window(points: np.ndarray, margin: float, shape) -> tuple[np.ndarray, np.ndarray]:
    """First and last (exclusive) pixel (x, y) of the bounding box of points with a margin, inside the frame."""
    size = np.array([shape[1], shape[0]])
    low = np.clip(np.floor(points.min(axis=0) - margin), 0, size).astype(int)
    high = np.clip(np.ceil(points.max(axis=0) + margin) + 1, 0, size).astype(int)
    return low, high


def _painted(region: np.ndarray, points: np.ndarray, texture, offset: np.ndarray, stitching: Stitching) -> np.ndarray:
    """A region of a frame with a texture painted at points (N, 2) with the opacity of the stitching."""
    import cv2

    reference = stitching.reference
    coloured = np.asarray(texture, np.float32).reshape(3, -1).T + stitching.basis @ offset.astype(np.float32)
    colours = texture_image(np.clip(coloured, 0, 255).T.reshape(-1), reference)
    layers = np.dstack([colours, stitching.opacity])
    x, y = _texture_positions(points, reference, *region.shape[:2])
    layers = cv2.remap(layers, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
    below = region.astype(np.float32)
    mixed = below + layers[..., 3:] * (layers[..., :3] - below)
    return np.clip(np.rint(mixed), 0, 255).astype(np.uint8)


def _texture_positions(
    points: np.ndarray, reference: Reference, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """The position of each pixel in the texture grid (x and y maps, float32); far outside where there is no face."""
    index, triangles = triangle_map(points, reference.points, height, width), reference.points.triangles
    a, b, c = np.moveaxis(np.asarray(points, np.float64)[triangles], 1, 0)
    edges = np.stack([b - a, c - a], axis=2)
    flat = np.abs(np.linalg.det(edges)) < 1e-6
    edges[flat] = np.eye(2)
    u, v, w = np.moveaxis(reference.grid_shape[triangles], 1, 0)
    linear = np.stack([v - u, w - u], axis=2) @ np.linalg.inv(edges)
    constant = u - np.einsum("nij,nj->ni", linear, a)
    # The last row is for pixels without a triangle (index -1).
    table = np.concatenate([linear, constant[:, :, None]], axis=2)
    table = np.concatenate([table, [[[0, 0, -9], [0, 0, -9]]]]).astype(np.float32)
    columns = np.arange(width, dtype=np.float32)[None]
    rows = np.arange(height, dtype=np.float32)[:, None]
    return tuple(
        table[:, axis, 0][index] * columns + table[:, axis, 1][index] * rows + table[:, axis, 2][index]
        for axis in (0, 1)
    )
