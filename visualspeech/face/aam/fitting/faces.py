"""Fitting of an utterance: the shape of the face in every frame, and the textures sampled there."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting.model import FittingModel, grey
from visualspeech.face.aam.fitting.solver import fit, follow, joined
from visualspeech.face.aam.reference import Reference, sample_texture
from visualspeech.face.drift import DriftSettings, FaceReference, Faces
from visualspeech.face.head import HeadModel
from visualspeech.face.point_sets import PointSet, to_points, to_vector
from visualspeech.face.pose import Pose, to_frontal, to_image


@dataclass(frozen=True)
class FittedFaces:
    """The fitted faces of T frames; if a fit diverged, those at the tracker's points.

    Parameters
    ----------
    points : (T, N, 2) float32 image pixels
    shape : (T, 2N) float32 shape vectors in pixels of the normalised face (Eq. 1)
    texture : (T, 3U) uint8 textures (Eq. 4)
    error : (T,) float32, root mean square in grey levels of what the model leaves of the fitted face
    diverged : (T,) bool
    """

    points: np.ndarray
    shape: np.ndarray
    texture: np.ndarray
    error: np.ndarray
    diverged: np.ndarray

    def faces(self, silent: np.ndarray | None = None, drift: DriftSettings | None = None, *, rate: float) -> Faces:
        """Shapes and textures with their reference face, as :meth:`visualspeech.face.drift.Faces.of`."""
        return Faces.of(self.shape, self.texture, silent, drift, rate=rate)


class PoseView:
    """A head's pose as the view between normalised shapes and frames; what fitting adds is a small similarity.

    Points that are means of others are means of them in both views: in perspective, the mean of points at different
    depths is not seen at the image of their mean.

    Parameters
    ----------
    points : the point set, of N points
    shift : (N, 2) offset of the shapes of this recording from the model's (its drift), pixels of the normalised face
    """

    def __init__(self, pose: Pose, head: HeadModel, points: PointSet, shift: np.ndarray) -> None:
        self.pose, self.head, self.points, self.shift = pose, head, points, shift
        self.model = points.selection[points.free] @ head.points3d

    def to_model(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Image points (T, N, 2) as points of the model's shapes."""
        free = np.take(points, self.points.free, axis=1)
        return self.points.completion @ to_frontal(free, self.pose[frames], self.head, self.model) - self.shift

    def to_image(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """Points (T, N, 2) of the model's shapes as image points: the inverse of :meth:`to_model`."""
        free = np.take(points + self.shift, self.points.free, axis=1)
        return self.points.completion @ to_image(free, self.pose[frames], self.head, self.model)


def fit_faces(
    frames: Iterable[np.ndarray],
    landmarks: np.ndarray,
    pose: Pose,
    head: HeadModel,
    model: FittingModel,
    reference: Reference,
    drift: tuple[FaceReference, FaceReference],
) -> FittedFaces:
    """Fit a model of the face to the frames of an utterance.

    The light and position of the recording are taken from its reference face, so the model need not explain them.
    One batch of frames at a time is in memory.

    Parameters
    ----------
    frames : T RGB frames (height, width, 3) uint8, in order
    landmarks : (T, 68, 2) of the tracker, image pixels: where fitting starts, and what is kept where it diverges
    pose : of the head in these frames
    model : :meth:`FittingModel.of_aam`
    drift : reference faces of the utterance and of the corpus

    Raises
    ------
    DataError
        The numbers of frames, landmarks and poses differ.
    """
    own, corpus = drift
    shift = to_points(np.asarray(own.shape, float) - corpus.shape)
    offset = grey(own.texture - corpus.texture)
    start = reference.points.select(np.asarray(landmarks, float))
    if len(pose) != len(start):
        raise DataError(f"landmarks of {len(start)} frames but poses of {len(pose)}")
    fits, textures, last, done = [], [], None, 0
    for batch in _batches(frames, model.settings.batch_size):
        rows = np.arange(done, done + len(batch))
        done += len(batch)
        if done > len(start):
            raise DataError(f"more frames in the recording than landmarks, which are {len(start)}")
        view, images = PoseView(pose[rows], head, reference.points, shift), [_grey_image(frame) for frame in batch]
        if model.settings.start == "last_frame":
            part = follow(images, start[rows], model, view, offset, last)
        else:
            part = fit(images, start[rows], model, view, offset)
        last = part.points[-1]
        fits.append(part)
        textures += [sample_texture(frame, at, reference) for frame, at in zip(batch, part.points, strict=True)]
    if done != len(start):
        raise DataError(f"{done} frames in the recording but landmarks for {len(start)}")
    every = joined(fits)
    frontal = PoseView(pose, head, reference.points, np.zeros_like(shift)).to_model(every.points, np.arange(done))
    shape = to_vector(frontal).astype(np.float32)
    return FittedFaces(
        every.points.astype(np.float32), shape, np.stack(textures), every.error.astype(np.float32), every.diverged
    )


def _batches(frames: Iterable[np.ndarray], size: int) -> Iterator[list[np.ndarray]]:
    frames = iter(frames)
    while batch := list(islice(frames, size)):
        yield batch


def _grey_image(frame: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2GRAY)
