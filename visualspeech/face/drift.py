"""Slow drift between recordings (light, seat, camera): removal from shapes and textures, and restoration for rendering.

The speaker's position and the light change between utterances. These changes make up a large part of the variance of
raw faces, but they are unrelated to what is said and cannot be predicted from speech. Each utterance therefore has a
reference face and is shifted so that this reference coincides with that of the corpus::

    normalised = observed - reference of the utterance + reference of the corpus

The shift is one constant vector per utterance, so movement over time is unchanged. :func:`restore` undoes it exactly,
so a rendered mouth has the light of its recording.

Methods (``DriftSettings.method``):

``clip_mean`` (the default)
    the reference is the mean over all frames of the utterance. This is the most stable method. It also removes the mean
    mouth of the words, which matters for single words more than for whole sentences.
``silence``
    the reference is the mean over the utterance's silent frames (pauses of the alignment). This removes nothing of the
    speech, but needs pauses in every utterance, and the mouth at rest differs between pauses.
``none``
    nothing is removed.

The variance that remains on real recordings is in ``docs/aam.md``.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DataError
from visualspeech.fields import Settings, setting

METHODS = ("clip_mean", "silence", "none")


@dataclass(frozen=True)
class DriftSettings(Settings):
    """Removal of slow drift between recordings (light, seat, camera)."""

    section = "drift"
    method: str = setting(
        "clip_mean",
        "Reference face of an utterance: its mean face, the mean of its silent frames, or none (drift is kept).",
        choices=METHODS,
    )
    min_silent_seconds: float = setting(
        0.2,
        "Method `silence`: an utterance with less silence than this, in seconds, falls back to its clip mean.",
        minimum=0,
        maximum=3600,
    )


class FaceReference(NamedTuple):
    """A reference face: shape (2N,) in pixels of the normalised face, texture (3U,) in grey levels; float32."""

    shape: np.ndarray
    texture: np.ndarray


@dataclass(frozen=True)
class Faces:
    """The faces of an utterance: what a visual coding encodes.

    Parameters
    ----------
    shape : (T, 2N) shape vectors in pixels of the normalised face (Fan 2015, Eq. 1)
    texture : (T, 3U) uint8 textures in grey levels (Eq. 4)
    reference : the utterance's reference face
    """

    shape: np.ndarray
    texture: np.ndarray
    reference: FaceReference

    @classmethod
    def of(
        cls,
        shape: np.ndarray,
        texture: np.ndarray,
        silent: np.ndarray | None = None,
        settings: DriftSettings | None = None,
        *,
        rate: float,
    ) -> "Faces":
        """Shapes and textures with their reference face; parameters and errors as :func:`reference_of`."""
        return cls(shape, texture, reference_of(shape, texture, silent, settings, rate=rate))

    @classmethod
    def read(cls, arrays, utterance_id: str) -> "Faces":
        """The faces of one utterance from opened files that hold what :meth:`arrays` gives."""
        shape, texture = (arrays.array(utterance_id, name) for name in ("shape", "texture"))
        return cls(shape, texture, reference_face(arrays, utterance_id))

    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays that files keep of an utterance."""
        return {
            "shape": self.shape,
            "texture": self.texture,
            "reference_shape": self.reference.shape,
            "reference_texture": self.reference.texture,
        }


def reference_face(arrays, utterance_id: str) -> FaceReference:
    """The reference face of one utterance, from opened files that hold what :meth:`Faces.arrays` gives."""
    return FaceReference(
        arrays.array(utterance_id, "reference_shape", ...), arrays.array(utterance_id, "reference_texture", ...)
    )


def reference_of(
    shape: np.ndarray,
    texture: np.ndarray,
    silent: np.ndarray | None = None,
    settings: DriftSettings | None = None,
    *,
    rate: float,
) -> FaceReference:
    """The reference face of one utterance.

    Parameters
    ----------
    shape : (T, 2N) shape vectors in pixels of the normalised face
    texture : (T, 3U) textures in grey levels, any number type
    silent : (T,) bool, frames without speech; needed by the method ``silence`` only
    rate : frame rate in Hz

    Raises
    ------
    DataError
        Lengths differ, there are no frames, or ``silence`` was asked for without ``silent``.
    """
    settings = settings or DriftSettings()
    if not (0 < len(shape) == len(texture)):
        raise DataError(f"an utterance has {len(shape)} shapes and {len(texture)} textures")
    if settings.method == "none":
        return FaceReference(np.zeros(shape.shape[1], np.float32), np.zeros(texture.shape[1], np.float32))
    chosen = np.ones(len(shape), bool)
    if settings.method == "silence":
        if silent is None or len(silent) != len(shape):
            raise DataError(
                f"the silent frames ({None if silent is None else len(silent)}) do not fit {len(shape)} shapes"
            )
        if np.count_nonzero(silent) >= max(settings.min_silent_seconds * rate, 1):
            chosen = np.asarray(silent, bool)
    return FaceReference(
        shape[chosen].mean(axis=0, dtype=np.float64).astype(np.float32),
        texture[chosen].mean(axis=0, dtype=np.float64).astype(np.float32),
    )


def corpus_reference(references: Iterable[FaceReference]) -> FaceReference:
    """The mean of the training utterances' references, each counted once; read in one pass.

    Raises
    ------
    DataError
        There are none.
    """
    shape, texture, count = 0.0, 0.0, 0
    for reference in references:
        shape = shape + np.asarray(reference.shape, np.float64)
        texture = texture + np.asarray(reference.texture, np.float64)
        count += 1
    if not count:
        raise DataError("no training utterances to take a reference of")
    return FaceReference((shape / count).astype(np.float32), (texture / count).astype(np.float32))


def remove_shape(shape: np.ndarray, utterance: FaceReference, corpus: FaceReference) -> np.ndarray:
    """Shapes (T, 2N) without the utterance's drift, float32."""
    return np.asarray(shape, np.float32) + (corpus.shape - utterance.shape)


def remove(
    shape: np.ndarray, texture: np.ndarray, utterance: FaceReference, corpus: FaceReference
) -> tuple[np.ndarray, np.ndarray]:
    """Shapes (T, 2N) and textures (T, 3U) without the utterance's drift, float32."""
    moved = np.asarray(texture, np.float32) + (corpus.texture - utterance.texture)
    return remove_shape(shape, utterance, corpus), moved


def restore(
    shape: np.ndarray, texture: np.ndarray, utterance: FaceReference, corpus: FaceReference
) -> tuple[np.ndarray, np.ndarray]:
    """The inverse of :func:`remove`: faces with the position and light of the utterance, float32 and not clipped."""
    return remove(shape, texture, corpus, utterance)
