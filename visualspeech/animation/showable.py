"""What can be shown of a speaker: a folder may come from a stranger, and its numbers may stand for no face.

Every file of it has been checked by itself. Here the parts are tried together: the face at rest, the head in the
recorded frames, and every prediction of the model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.animation.background import Background
from visualspeech.animation.video import Speaker
from visualspeech.errors import DataError, StorageError
from visualspeech.face.camera import project
from visualspeech.face.pose import to_frontal
from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Stream
from visualspeech.models.task import Model

MAX_DEVIATIONS = 1000  # standard deviations of the training faces, of all parameters together
_FAR = 5.0  # distance from the middle of an image, in units of its size, beyond which no point of a face lies
_GREY_LEVELS = (-2000.0, 2255.0)  # of a texture, which is clipped to 0..255 when it is rendered


@dataclass(frozen=True)
class BoundedModel:
    """The model of a speaker, of any family; a prediction that cannot be a face is an error instead of a video.

    Parameters
    ----------
    model : from speech to the parameters of the visual coding
    speaker : whose appearance model decodes them
    path : of the model, for messages
    """

    model: Model
    speaker: Speaker
    path: str

    @property
    def blocks(self) -> Mapping[str, Block]:
        return self.model.blocks

    @property
    def rate(self) -> float:
        return self.model.rate

    @property
    def coding(self) -> str:
        return self.model.coding

    @property
    def outputs(self) -> int:
        return self.model.outputs

    def predict(self, streams: Sequence[Stream], frames: int, rate: float) -> np.ndarray:
        """As the model predicts.

        Raises
        ------
        StorageError
            A value is not finite, or the face is far from all that the model can have been trained on.
        """
        try:
            predicted = self.model.predict(streams, frames, rate)
        except np.linalg.LinAlgError as error:
            raise self._error() from error
        if not _is_face(predicted, self.speaker):
            raise self._error()
        return predicted

    def save(self, path: str | Path) -> None:
        self.model.save(path)

    def _error(self) -> StorageError:
        return StorageError(
            f"the model {self.path} predicts what cannot be a face of its appearance model. Build the speaker again, "
            "or ask for the folder again where it was received."
        )


def check_showable(folder: Path, speaker: Speaker, background: Background, rest: np.ndarray) -> None:
    """Check that the face at rest can be shown on the background.

    Raises
    ------
    DataError
        The face at rest is no face, or the head does not lie where the landmarks of the background do.
    """
    if not _is_face(rest[None], speaker):
        raise _no_face(folder, "the face at rest")
    shape, texture = speaker.aam.decode(rest[None])
    shape = shape + background.shapes - speaker.aam.drift.shape
    texture = texture + background.textures - speaker.aam.drift.texture
    if not _within(shape.reshape(len(shape), 2, -1).swapaxes(1, 2), speaker.head.size):
        raise _no_face(folder, "the face at rest")
    if texture.min() < _GREY_LEVELS[0] or texture.max() > _GREY_LEVELS[1]:
        raise _no_face(folder, "the texture of the face at rest")
    head, pose = speaker.head, background.pose
    with np.errstate(all="ignore"):  # what is not finite is refused
        seen = project(head.points3d, pose.rotation, pose.translation, head.focal, head.centre)
        frontal = to_frontal(background.landmarks.astype(np.float64), pose, head)
    if not (_within(seen, background.size) and _within(frontal, head.size)):
        raise _no_face(folder, "the head in the background recordings")


def _is_face(appearance: np.ndarray, speaker: Speaker) -> bool:
    """Whether parameters (T, N) are finite and not far outside what the appearance model was trained on."""
    aam = speaker.aam
    values = np.asarray(appearance, np.float64)
    most = MAX_DEVIATIONS * np.sqrt(max(float(aam.appearance_variances.sum()), 0.0))
    # Written so that NaN is refused too.
    if not (np.abs(values) <= most).all():
        return False
    return _within(aam.decode_points(np.asarray(appearance, np.float32)), speaker.head.size)


def _within(points: np.ndarray, size: tuple[int, int]) -> bool:
    """Whether points (..., 2) are finite and not far outside an image of a size (width, height)."""
    return bool((np.abs(points / np.asarray(size, np.float64) - 0.5) < _FAR).all())


def _no_face(folder: Path, what: str) -> DataError:
    return DataError(
        f"the speaker {folder} cannot be shown: {what} lies far outside its image. Build the speaker again, or ask for "
        "the folder again where it was received."
    )
