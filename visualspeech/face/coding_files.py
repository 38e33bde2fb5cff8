"""Visual codings in files, of whatever kind: only the module of that kind is imported."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

from visualspeech.errors import DamagedFile
from visualspeech.face.coding import VisualCoding
from visualspeech.storage.layouts import TEXT, check_plain
from visualspeech.storage.models import read_model_settings

#: Kinds of visual codings.
KINDS = ("aam", "markers")

_HEADER = {
    "type": "object",
    "required": ["kind", "points", "sizes"],
    "properties": {
        "kind": TEXT,
        "points": TEXT,
        "sizes": {"type": "object", "additionalProperties": {"type": "integer", "minimum": 1}},
    },
}


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
