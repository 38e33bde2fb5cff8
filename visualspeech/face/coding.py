"""Visual codings: the representation of faces that models predict.

A coding encodes the faces of an utterance as vectors (T, N), and decodes such vectors to points. Measures that need
only points can be computed for every coding. What it encodes depends on its kind: an ``aam`` has points and textures of
video (:meth:`visualspeech.face.aam.model.Aam.encode_faces`), ``markers`` has points alone, of video or of motion
capture (:meth:`visualspeech.face.marker_coding.MarkerCoding.encode`).
"""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from visualspeech.face.drift import FaceReference
from visualspeech.face.point_sets import PointSet


class CodedFaces(NamedTuple):
    """A coded utterance.

    Parameters
    ----------
    parameters : (T, N) float32, the target of the models
    offset : constant vectors that are added to decoded shapes and textures to restore the position and light of the
        recording
    details : further arrays of T rows that measures and figures need, by name
    """

    parameters: np.ndarray
    offset: FaceReference
    details: Mapping[str, np.ndarray]


class VisualCoding(Protocol):
    """A trained visual coding of N parameters per frame and P points of d coordinates."""

    @property
    def size(self) -> int:
        """N, the number of parameters per frame."""

    @property
    def points(self) -> PointSet | None:
        """The point set, of P points; None where the points are markers."""

    @property
    def regions(self) -> Mapping[str, tuple[int, ...]]:
        """Region of the face -> its columns among the parameters; empty where a parameter belongs to no region."""

    def decode_points(self, parameters: np.ndarray, speaker: str = "") -> np.ndarray:
        """Points (T, P, d) of parameters (T, N), without the utterance's offset.

        An ``aam`` gives pixels of the normalised face and takes no notice of the speaker; ``markers`` gives the unit of
        the recordings, from the mean and deviation of the speaker.
        """
