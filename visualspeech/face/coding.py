"""Visual codings: the representation of faces that models predict.

A coding encodes the faces of an utterance as vectors (T, N), and decodes such vectors to points of the normalised face
and, if it models texture, to textures. Measures that need only points can be computed for every coding.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from visualspeech.errors import DamagedFile
from visualspeech.face.drift import FaceReference, Faces
from visualspeech.face.point_sets import PointSet
from visualspeech.storage.layouts import TEXT, check_plain
from visualspeech.storage.models import read_model_settings


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
    """A trained visual coding of N parameters per frame and P points."""

    @property
    def points(self) -> PointSet:
        """The point set, of P points."""

    @property
    def size(self) -> int:
        """N, the number of parameters per frame."""

    def encode_faces(self, faces: Faces) -> CodedFaces:
        """Code the faces of one utterance."""

    def decode_points(self, parameters: np.ndarray) -> np.ndarray:
        """Points (T, P, 2) of the normalised face in pixels for parameters (T, N), without the utterance's offset."""

    def decode_texture(self, parameters: np.ndarray) -> np.ndarray | None:
        """Textures (T, 3U) in grey levels for parameters (T, N), without the offset; None where none is modelled."""


class CodingHeader(NamedTuple):
    """The header of a coding's file, which is read without the arrays.

    Parameters
    ----------
    kind : kind of the coding, ``aam``
    points : name of the point set
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
    from visualspeech.face.aam.model import Aam

    kinds = {"aam": Aam}
    kind = read_coding_header(path).kind
    if kind not in kinds:
        raise DamagedFile(path, f"it is a visual coding of the unknown kind {kind!r:.40}; known are {', '.join(kinds)}")
    return kinds[kind].load(path)
