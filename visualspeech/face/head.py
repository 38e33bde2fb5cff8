"""The speaker's head in three dimensions, fitted to the speaker's landmarks.

A mean face explains a speaker's landmarks only to a few pixels. Here the positions of the 68 landmarks in head
coordinates are fitted to many frames with the mean face as prior, by bundle adjustment that alternates between the
poses (from the rigid landmarks) and the positions (from the poses).
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.face.camera import point_jacobian, rotation_matrices, solve_pose
from visualspeech.face.mean_face import MEAN_FACE
from visualspeech.face.tracker import POINTS, RIGID
from visualspeech.fields import Settings, restored, setting
from visualspeech.storage.layouts import Array, FileLayout
from visualspeech.storage.models import read_model_of, write_model


@dataclass(frozen=True)
class PoseSettings(Settings):
    """3-D head model and smoothing of the head pose.

    The focal length of recordings is not known. The default of 3 is a field of view of 19 degrees: head and shoulders
    from about two metres. The fitted depths compensate for nearly all of a wrong value (with 1, 2 and 4 on GRID, rigid
    points move by 0.42, 0.40 and 0.40 px).
    """

    section = "pose"
    focal_length: float = setting(
        3.0, "Assumed focal length of the camera, in units of the frame's longer side.", minimum=0.1, maximum=1000
    )
    max_frames: int = setting(
        600, "Maximum number of training frames that the head model is fitted to.", minimum=10, maximum=10_000
    )
    iterations: int = setting(12, "Iterations of the bundle adjustment.", minimum=1, maximum=1000)
    landmark_noise: float = setting(
        1.0,
        "Expected error of a rigid landmark, in pixels of a face that is 100 pixels wide.",
        minimum=0.001,
        maximum=100,
    )
    depth_deviation: float = setting(
        0.06,
        "Expected standard deviation of a speaker's landmarks from the mean face in depth, as a share of the face's "
        "width.",
        minimum=0.0001,
        maximum=10,
    )
    in_plane_deviation: float = setting(
        0.3,
        "Expected standard deviation of a speaker's landmarks from the mean face in the frontal plane (horizontal and "
        "vertical), as a share of the face's width.",
        minimum=0.0001,
        maximum=10,
    )
    rotation_smoothing: float = setting(
        0.08,
        "Standard deviation, in seconds, of the Gaussian that smooths the head's rotation and distance over time; 0 "
        "for none.",
        minimum=0,
        maximum=10,
    )
    translation_smoothing: float = setting(
        0.02,
        "Standard deviation, in seconds, of the Gaussian that smooths the head's position in the image over time; 0 "
        "for none.",
        minimum=0,
        maximum=10,
    )
    margin: float = setting(
        0.25,
        "Border around the mean landmarks in the normalised face, as a share of the face's width.",
        minimum=0,
        maximum=2,
    )


@dataclass(frozen=True)
class HeadModel:
    """A speaker's head and the camera of the recordings.

    Parameters
    ----------
    points3d : (68, 3) mean positions in head coordinates; their unit is a pixel of the normalised face, and at the mean
        distance from the camera also a pixel of the recording
    rigid : indices of the landmarks that give the pose
    weights : (rigid,) weight of each of these
    focal : focal length in pixels of the recording
    centre : (2,) principal point in pixels of the recording
    offset : (2,) position of the head's origin in the normalised image
    size : (width, height) of the normalised image
    settings : with which it was fitted
    """

    points3d: np.ndarray
    rigid: np.ndarray
    weights: np.ndarray
    focal: float
    centre: np.ndarray
    offset: np.ndarray
    size: tuple[int, int]
    settings: PoseSettings

    @property
    def mean_points(self) -> np.ndarray:
        """The mean points in the normalised image, (68, 2) pixels."""
        return self.points3d[:, :2] + self.offset

    def save(self, path) -> None:
        """Write the model as safetensors."""
        tensors = {
            name: np.asarray(getattr(self, name)) for name in ("points3d", "rigid", "weights", "centre", "offset")
        }
        write_model(
            path,
            tensors,
            {"kind": "head", "focal": self.focal, "size": list(self.size), "settings": asdict(self.settings)},
        )

    @classmethod
    def load(cls, path) -> "HeadModel":
        """Read what :meth:`save` wrote; raises as :func:`visualspeech.storage.models.read_model_of`."""
        tensors, stored = read_model_of(path, "head model", ["head"], LAYOUT)
        settings, size = restored(PoseSettings, stored["settings"], path), tuple(map(int, stored["size"]))
        head = cls(**tensors, focal=float(stored["focal"]), size=size, settings=settings)
        # The head fills the normalised image; far outside of it there is nothing to render.
        if not (np.abs(head.mean_points / size - 0.5) < 5).all():
            raise DamagedFile(path, "its points lie far outside the normalised image")
        return head


LAYOUT = FileLayout(
    {
        "points3d": Array("f", (POINTS, 3), -1e5, 1e5),
        "rigid": Array("iu", ("R",), 0, POINTS - 1),
        "weights": Array("f", ("R",), 0, 1e6),
        "centre": Array("f", (2,), -1e5, 1e5),
        "offset": Array("f", (2,), -1e5, 1e5),
    },
    {
        "focal": {"type": "number", "minimum": 1, "maximum": 1e7},
        "size": {
            "type": "array",
            "minItems": 2,
            "maxItems": 2,
            "items": {"type": "integer", "minimum": 2, "maximum": 20_000},
        },
        "settings": {"type": "object"},
    },
)


def load_heads(speakers: Sequence[str], paths: Sequence[str | Path]) -> dict[str, HeadModel]:
    """The heads of some speakers by the speaker's name, from one file per speaker, in the same order.

    Raises
    ------
    StorageError
        A file is missing or holds no head.
    """
    return {speaker: HeadModel.load(path) for speaker, path in zip(speakers, paths, strict=True)}


def fit_head(points: np.ndarray, image_size: tuple[int, int], settings: PoseSettings | None = None) -> HeadModel:
    """Fit the head of one speaker.

    Parameters
    ----------
    points : (n, 68, 2) landmarks in image pixels of n frames, ideally spread over all training utterances
    image_size : (width, height) of the frames in pixels

    Raises
    ------
    DataError
        The landmarks have another shape, or there are none.
    """
    settings = settings or PoseSettings()
    points = np.asarray(points, float)
    if points.ndim != 3 or points.shape[1:] != (POINTS, 2) or len(points) == 0:
        raise DataError(f"a head is fitted to landmarks (n, {POINTS}, 2), not {points.shape}.")
    if len(points) > settings.max_frames:
        points = points[np.linspace(0, len(points) - 1, settings.max_frames).round().astype(int)]
    centre = np.array([image_size[0] / 2, image_size[1] / 2])
    focal = settings.focal_length * max(image_size)
    # The unit of head coordinates is a pixel of the recording at the mean distance, which then is the focal length.
    prior = MEAN_FACE * _seen_size(points)
    width = np.ptp(prior[:, 0])
    deviation = width * np.array([settings.in_plane_deviation, settings.in_plane_deviation, settings.depth_deviation])
    noise = np.full(POINTS, settings.landmark_noise * width / 100)
    model = prior.copy()
    pose = None
    for _ in range(settings.iterations):
        weights = (noise[RIGID].mean() / noise[RIGID]) ** 2
        pose = solve_pose(points[:, RIGID], model[RIGID], focal, centre, weights, start=pose)
        # The common scale of head and distance is arbitrary; it is set so that the mean distance is the focal length.
        stretch = focal / pose[1][:, 2].mean()
        model, pose = model * stretch, (pose[0], pose[1] * stretch)
        model, residual = _fit_points(points, model, prior, pose, focal, centre, noise, deviation)
        noise = np.maximum(np.sqrt((np.median(residual**2, axis=0)) / 1.386), 0.2 * width / 100)
        model, pose = _upright(model, prior, pose)
    margin = settings.margin * width
    low = model[:, :2].min(0) - margin
    size = np.ceil(model[:, :2].max(0) + margin - low).astype(int)
    size += size % 2
    weights = (noise[RIGID].mean() / noise[RIGID]) ** 2
    return HeadModel(
        points3d=model,
        rigid=RIGID,
        weights=weights,
        focal=float(focal),
        centre=centre,
        offset=-np.floor(low),
        size=(int(size[0]), int(size[1])),
        settings=settings,
    )


def _seen_size(points: np.ndarray) -> float:
    """Pixels per unit of the mean face in the frames (n, 68, 2), on average."""
    face = MEAN_FACE[RIGID, :2]
    seen = points[:, RIGID]
    radius = np.sqrt(((seen - seen.mean(1, keepdims=True)) ** 2).sum(2).mean(1))
    return float(np.median(radius) / np.sqrt(((face - face.mean(0)) ** 2).sum(1).mean()))


def _fit_points(points, model, prior, pose, focal, centre, noise, deviation):
    """Points (68, 3) after one Gauss-Newton step per point, and the errors (n, 68) in pixels before the step."""
    matrix = rotation_matrices(pose[0])
    seen = model @ np.swapaxes(matrix, -1, -2) + pose[1][:, None]
    residual = points - (focal * seen[..., :2] / seen[..., 2:] + centre)
    size = np.linalg.norm(residual, axis=-1)
    robust = np.minimum(1, 3 * noise / np.maximum(size, 1e-9)) / noise**2
    jacobian = point_jacobian(seen, focal) @ matrix[:, None]
    normal = np.einsum("tnik,tnij,tn->nkj", jacobian, jacobian, robust) + np.diag(deviation**-2.0)
    pull = np.einsum("tnik,tni,tn->nk", jacobian, residual, robust) + (prior - model) / deviation**2
    return model + np.linalg.solve(normal, pull[..., None])[..., 0], size


def _upright(model, prior, pose):
    """Model and pose in head coordinates in which the rigid points are aligned with those of the mean face.

    The projections do not change.
    """
    to = model[RIGID].mean(0)
    goal = prior[RIGID].mean(0)
    left, _, right = np.linalg.svd((model[RIGID] - to).T @ (prior[RIGID] - goal))
    flip = np.diag([1, 1, np.sign(np.linalg.det(left @ right))])
    turn = (left @ flip @ right).T  # new = turn (old - to) + goal
    moved = (model - to) @ turn.T + goal
    from visualspeech.face.camera import rotation_vectors

    matrix = rotation_matrices(pose[0])
    new_matrix = matrix @ turn.T
    new_translation = pose[1] + matrix @ to - new_matrix @ goal
    return moved, (rotation_vectors(new_matrix), new_translation)
