"""Head pose, and the maps between the recorded frame and the normalised (frontal, aligned) face.

The pose of every frame is the rotation and translation under which the speaker's 3-D head explains the rigid landmarks
(perspective-n-point), smoothed in time. A landmark is normalised by intersecting its viewing ray with the plane of its
depth in head coordinates: its position in that plane is its position in the normalised face. That undoes turning,
nodding, leaning and perspective of the head, keeps the movement of mouth and jaw, and is undone exactly by projecting
the position with its depth back into the frame.
"""

from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError, RejectedUtterance
from visualspeech.face.camera import project, rotation_matrices, solve_pose, solve_translation
from visualspeech.face.head import HeadModel, PoseSettings
from visualspeech.face.landmarks import smooth


@dataclass(frozen=True)
class Pose:
    """Rotation and translation of the head in each of T frames.

    Parameters
    ----------
    rotation : (T, 3) Rodrigues vectors in radians
    translation : (T, 3) in units of the head (see :class:`HeadModel`)
    """

    rotation: np.ndarray
    translation: np.ndarray

    @classmethod
    def read(cls, arrays, utterance_id: str) -> "Pose":
        """The poses of one utterance from opened files."""
        return cls(arrays.array(utterance_id, "rotation"), arrays.array(utterance_id, "translation"))

    def __len__(self) -> int:
        return len(self.rotation)

    def __getitem__(self, frames) -> "Pose":
        """The poses of some frames (an index keeps the time axis)."""
        frames = slice(frames, frames + 1 or None) if isinstance(frames, int) else frames
        return Pose(self.rotation[frames], self.translation[frames])


def estimate(points: np.ndarray, head: HeadModel, settings: PoseSettings | None = None, *, rate: float) -> Pose:
    """The head's pose in every frame of one utterance.

    Rotation and distance are estimated from all rigid points and smoothed most, because their noise is largest and
    heads turn slowly. Given these, the translation across the image is estimated again and smoothed less.

    Parameters
    ----------
    points : (T, 68, 2) landmarks in image pixels
    settings : the smoothing; by default that with which the head was fitted
    rate : frame rate in Hz
    """
    settings = settings or head.settings
    if points.ndim != 3 or points.shape[1] <= head.rigid.max():
        raise DataError(f"a pose is estimated from landmarks (T, 68, 2), not {points.shape}.")
    seen = np.asarray(points, float)[:, head.rigid]
    model = head.points3d[head.rigid]
    rotation, translation = solve_pose(seen, model, head.focal, head.centre, head.weights)
    rotation = smooth(rotation, settings.rotation_smoothing * rate)
    # The logarithm of the distance is smoothed, because distance is a scale.
    origin = model.mean(0)
    turned = (rotation_matrices(rotation) @ origin)[:, 2]
    depth = np.exp(smooth(np.log(translation[:, 2] + turned), settings.rotation_smoothing * rate)) - turned
    translation = solve_translation(seen, model, rotation, depth, head.focal, head.centre, head.weights)
    middle = rotation_matrices(rotation) @ origin + translation
    beside = smooth(middle[:, :2] / middle[:, 2:], settings.translation_smoothing * rate)
    shift = beside * middle[:, 2:] - middle[:, :2]
    return Pose(rotation, translation + np.column_stack([shift, np.zeros(len(shift))]))


def normalise(points: np.ndarray, head: HeadModel, settings: PoseSettings, *, rate: float) -> tuple[Pose, np.ndarray]:
    """The head's pose in every frame of one utterance (:func:`estimate`), and its landmarks in the normalised face.

    Raises
    ------
    RejectedUtterance
        There is no pose under which the head shows these landmarks.
    """
    pose = estimate(points, head, settings, rate=rate)
    frontal = to_frontal(points, pose, head)
    if not all(np.isfinite(array).all() for array in (pose.rotation, pose.translation, frontal)):
        raise RejectedUtterance(
            "the landmarks are those of no head", "Check that the recording shows the speaker's face throughout."
        )
    return pose, frontal


def to_frontal(points: np.ndarray, pose: Pose, head: HeadModel, model: np.ndarray | None = None) -> np.ndarray:
    """Image points as points of the normalised face.

    Parameters
    ----------
    points : (T, n, 2) image pixels
    pose : of these T frames
    model : (n, 3) the points in head coordinates, of which only the depth is used; or (n,) depths; by default those
        of the 68 landmarks. Points that are linear combinations of landmarks take the same combinations of
        ``head.points3d``.

    Returns
    -------
    (T, n, 2) pixels of the normalised face
    """
    depth = _depths(head, model, points.shape[1])
    matrix = rotation_matrices(pose.rotation)
    rays = np.concatenate([(points - head.centre) / head.focal, np.ones((*points.shape[:2], 1))], axis=-1)
    # In head coordinates a ray point is R' (s ray - t); s is where its z is the depth.
    rays = rays @ matrix
    start = np.einsum("tji,tj->ti", matrix, pose.translation)[:, None]
    stretch = (depth + start[..., 2]) / rays[..., 2]
    return stretch[..., None] * rays[..., :2] - start[..., :2] + head.offset


def to_image(points: np.ndarray, pose: Pose, head: HeadModel, model: np.ndarray | None = None) -> np.ndarray:
    """Points (T, n, 2) of the normalised face as image points: the exact inverse of :func:`to_frontal`."""
    depth = np.broadcast_to(_depths(head, model, points.shape[1]), points.shape[:2])
    model3d = np.concatenate([points - head.offset, depth[..., None]], axis=-1)
    return project(model3d, pose.rotation, pose.translation, head.focal, head.centre)


def rigid_error(frontal: np.ndarray, head: HeadModel) -> float:
    """Residual movement of the rigid points in the normalised face: RMS distance in pixels to their means over time.

    Parameters
    ----------
    frontal : (T, 68, 2) landmarks in the normalised face
    """
    rigid = frontal[:, head.rigid]
    return float(np.sqrt(((rigid - rigid.mean(0)) ** 2).sum(2).mean()))


def depth_map(head: HeadModel) -> np.ndarray:
    """Depth of the head under every pixel of the normalised image, (height, width) in head coordinates.

    A thin-plate spline through the 68 points, kept between the shallowest and the deepest of them. It is made for
    display: landmarks have their own depths.
    """
    from scipy.interpolate import RBFInterpolator

    width, height = head.size
    across, down = np.meshgrid(np.arange(width), np.arange(height))
    positions = np.stack([across.ravel(), down.ravel()], axis=1) - head.offset
    # Inner and outer lips nearly coincide; without smoothing the surface would buckle between them.
    surface = RBFInterpolator(head.points3d[:, :2], head.points3d[:, 2], kernel="thin_plate_spline", smoothing=50.0)
    depth = head.points3d[:, 2]
    return np.clip(surface(positions), depth.min(), depth.max()).reshape(height, width)


def frontal_image(frame: np.ndarray, pose: Pose, head: HeadModel, depth: np.ndarray | None = None) -> np.ndarray:
    """The normalised face of one frame, for display.

    Parameters
    ----------
    frame : (height, width, 3) uint8
    pose : of this frame (one frame long)
    depth : of :func:`depth_map`, where many images are made

    Returns
    -------
    uint8 image of ``head.size``
    """
    import cv2

    depth = depth_map(head) if depth is None else depth
    down, across = np.indices(depth.shape)
    positions = np.stack([across.ravel(), down.ravel()], axis=1)[None]
    seen = to_image(positions, pose, head, depth.ravel()).astype(np.float32).reshape(*depth.shape, 2)
    return cv2.remap(frame, seen[..., 0], seen[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _depths(head: HeadModel, model: np.ndarray | None, count: int) -> np.ndarray:
    model = head.points3d if model is None else np.asarray(model, float)
    depth = model[:, 2] if model.ndim == 2 else model
    if len(depth) != count:
        raise DataError(f"{count} points per frame, but depths for {len(depth)}; pass the model of these points.")
    return depth
