"""Fitting of an utterance: where its lower face is in every frame, and the shapes and textures read there."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from visualspeech.errors import DataError
from visualspeech.face.aam.fitting.model import FittingModel, grey
from visualspeech.face.aam.fitting.solver import fit, follow, joined
from visualspeech.face.aam.points import SELECTION, TRACKED, lower_face, to_points, to_vector
from visualspeech.face.aam.reference import Reference, sample_texture
from visualspeech.face.drift import FaceReference
from visualspeech.face.pose import HeadModel, Pose, to_frontal, to_image

_COMPLETED = SELECTION[:, TRACKED]  # the 51 points from the tracked ones among them


@dataclass(frozen=True)
class FittedFaces:
    """The fitted lower faces of T frames; where a fit diverged, those at the tracker's points.

    Parameters
    ----------
    points : (T, 51, 2) float32 image pixels
    shape : (T, 102) float32 shape vectors in pixels of the frontal face (Eq. 1)
    texture : (T, 3U) uint8 textures (Eq. 4)
    error : (T,) float32, root mean square in grey levels of what the model leaves of the fitted face
    diverged : (T,) bool
    """

    points: np.ndarray
    shape: np.ndarray
    texture: np.ndarray
    error: np.ndarray
    diverged: np.ndarray


class PoseView:
    """A head's pose as the view between frontal shapes and pictures; what fitting adds is a small similarity.

    The five derived points are means of tracked ones here as there: in perspective, a mean of points that lie at
    different depths is not seen where the mean of their places is.

    Parameters
    ----------
    shift : (51, 2) what the shapes of this recording lie beside the model's (its drift), frontal pixels
    """

    def __init__(self, pose: Pose, head: HeadModel, shift: np.ndarray) -> None:
        self.pose, self.head, self.shift = pose, head, shift
        self.model = head.points3d[TRACKED]

    def to_model(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        tracked = points[:, : len(TRACKED)]
        return _COMPLETED @ to_frontal(tracked, self.pose[frames], self.head, self.model) - self.shift

    def to_image(self, points: np.ndarray, frames: np.ndarray) -> np.ndarray:
        tracked = (points + self.shift)[:, : len(TRACKED)]
        return _COMPLETED @ to_image(tracked, self.pose[frames], self.head, self.model)


def fit_faces(
    frames: Iterable[np.ndarray],
    landmarks: np.ndarray,
    pose: Pose,
    head: HeadModel,
    model: FittingModel,
    reference: Reference,
    drift: tuple[FaceReference, FaceReference],
) -> FittedFaces:
    """Fit a model of the lower face to the frames of an utterance.

    Light and seat of the recording are taken from its reference face, so that the model need not have learnt them.
    Memory holds a batch of frames at a time.

    Parameters
    ----------
    frames : T RGB pictures (height, width, 3) uint8, in order
    landmarks : (T, 68, 2) of the tracker, image pixels: where fitting starts, and what is kept where it diverges
    pose : of the head in these frames
    model : :meth:`FittingModel.of_aam`
    drift : reference faces of the utterance and of the corpus

    Raises
    ------
    DataError
        Not as many frames as landmarks and poses.
    """
    own, corpus = drift
    shift = to_points(np.asarray(own.shape, float) - corpus.shape)
    offset = grey(own.texture - corpus.texture)
    start = lower_face(np.asarray(landmarks, float))
    if len(pose) != len(start):
        raise DataError(f"landmarks of {len(start)} frames but poses of {len(pose)}")
    fits, textures, last, done = [], [], None, 0
    for batch in _batches(frames, model.settings.batch_size):
        rows = np.arange(done, done + len(batch))
        done += len(batch)
        if done > len(start):
            raise DataError(f"more frames in the recording than landmarks, which are {len(start)}")
        view, pictures = PoseView(pose[rows], head, shift), [_grey_picture(frame) for frame in batch]
        if model.settings.start == "last_frame":
            part = follow(pictures, start[rows], model, view, offset, last)
        else:
            part = fit(pictures, start[rows], model, view, offset)
        last = part.points[-1]
        fits.append(part)
        textures += [sample_texture(frame, at, reference) for frame, at in zip(batch, part.points, strict=True)]
    if done != len(start):
        raise DataError(f"{done} frames in the recording but landmarks for {len(start)}")
    every = joined(fits)
    frontal = PoseView(pose, head, np.zeros_like(shift)).to_model(every.points, np.arange(done))
    shape = to_vector(frontal).astype(np.float32)
    return FittedFaces(
        every.points.astype(np.float32), shape, np.stack(textures), every.error.astype(np.float32), every.diverged
    )


def _batches(frames: Iterable[np.ndarray], size: int) -> Iterator[list[np.ndarray]]:
    frames = iter(frames)
    while batch := list(islice(frames, size)):
        yield batch


def _grey_picture(frame: np.ndarray) -> np.ndarray:
    import cv2

    return cv2.cvtColor(np.ascontiguousarray(frame), cv2.COLOR_RGB2GRAY)
