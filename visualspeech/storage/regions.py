"""The regions of the face in the file of a visual coding: which of its parameters belong to which.

They are plain data of the file, so that the training of models can read them without the code of codings.
"""

from collections.abc import Mapping
from pathlib import Path

from visualspeech.storage.layouts import check_plain
from visualspeech.storage.models import read_model_settings

#: Key of the plain data under which a coding with regions keeps their columns, and JSON Schema of what is below it.
COLUMNS = "columns"
LAYOUT = {
    "type": "object",
    "maxProperties": 100,
    "additionalProperties": {
        "type": "array",
        "minItems": 1,
        "maxItems": 10_000,
        "items": {"type": "integer", "minimum": 0, "maximum": 9_999},
    },
}


def coding_regions(path: str | Path) -> Mapping[str, tuple[int, ...]]:
    """Region -> its columns among the parameters of the visual coding in a file; empty for a coding without regions.

    Raises
    ------
    StorageError
        The file is missing or damaged.
    """
    found = read_model_settings(path).get(COLUMNS, {})
    check_plain(path, found, LAYOUT)
    return {region: tuple(columns) for region, columns in found.items()}
