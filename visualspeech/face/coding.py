"""Visual codings: the representation of faces that models predict.

A coding encodes the faces of an utterance as vectors (T, N), and decodes such vectors to points. Measures that need
only points can be computed for every coding. What it encodes depends on its kind: an ``aam`` has points and textures of
video (:meth:`visualspeech.face.aam.model.Aam.encode_faces`), ``markers`` has points alone, of video or of motion
capture (:meth:`visualspeech.face.marker_coding.MarkerCoding.encode`).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from visualspeech.errors import DamagedFile
from visualspeech.face.drift import FaceReference
from visualspeech.face.point_sets import PointSet
from visualspeech.storage.layouts import TEXT, check_plain
from visualspeech.storage.models import read_model_settings

#: Kinds of visual codings.
KINDS = ("aam", "markers")


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


class CodingHeader(NamedTuple):
    """The header of a coding's file, which is read without the arrays.

    Parameters
    ----------
    kind : kind of the coding, one of :data:`KINDS`
    points : name of the point set, or of the marker set
    sizes : parameters per frame by name; those that models predict are ``appearance``
    """

    kind: str
    points: str
    sizes: Mapping[str, int]


def read_coding_header(path: str | Path) -> CodingHeader:
    """Kind, point set and sizes of a coding, without loading its arrays.

    Raises
    ------
    StorageError
        The file is missing, or no visual coding.
    """
    stored = read_model_settings(path)
    check_plain(path, stored, _HEADER)
    return CodingHeader(stored["kind"], stored["points"], stored["sizes"])


_HEADER = {
    "type": "object",
    "required": ["kind", "points", "sizes"],
    "properties": {
        "kind": TEXT,
        "points": TEXT,
        "sizes": {"type": "object", "additionalProperties": {"type": "integer", "minimum": 1}},
    },
}


def load_coding(path: str | Path) -> VisualCoding:
    """The visual coding in a file, of any kind.

    Raises
    ------
    StorageError
        The file is missing, no visual coding, or of an unknown kind.
    """
    kind = read_coding_header(path).kind
    if kind == "aam":
        from visualspeech.face.aam.model import Aam as Coding
    elif kind == "markers":
        from visualspeech.face.marker_coding import MarkerCoding as Coding
    else:
        raise DamagedFile(path, f"it is a visual coding of the unknown kind {kind!r:.40}; known are {', '.join(KINDS)}")
    return Coding.load(path)
