"""The input blocks of a model inside the model's file, so that it can read new speech by itself."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile
from visualspeech.features.blocks.base import Block, for_new_speech, load_block, phones_of, restore
from visualspeech.storage.layouts import TEXT, Array
from visualspeech.storage.models import part_of


def load_blocks(paths: Mapping[str, str]) -> dict[str, Block]:
    """Fitted blocks by name, from their files."""
    return {name: load_block(path) for name, path in paths.items()}


def pack(blocks: Mapping[str, Block]) -> tuple[dict[str, np.ndarray], list[dict]]:
    """Arrays (named ``blocks.<number>.<name>``) and plain data of blocks, in their order, as new speech needs them."""
    arrays: dict[str, np.ndarray] = {}
    plain = []
    for number, (name, block) in enumerate(blocks.items()):
        own, state = for_new_speech(block).state()
        arrays |= {f"blocks.{number}.{key}": values for key, values in own.items()}
        plain.append({"name": name, "kind": block.kind, "state": state})
    return arrays, plain


#: What :func:`pack` gives, as a part of a model's layout: its arrays, and the schema of its plain data.
BLOCK_ARRAYS = {"blocks.*": Array("fiub", None)}
BLOCKS = {
    "type": "array",
    "maxItems": 100,
    "items": {
        "type": "object",
        "required": ["name", "kind", "state"],
        "additionalProperties": False,
        "properties": {"name": TEXT, "kind": TEXT, "state": {"type": "object"}},
    },
}


def unpack(arrays: Mapping[str, np.ndarray], plain: list[dict], path: str | Path = "") -> dict[str, Block]:
    """The inverse of :func:`pack`, for the content of the file ``path`` that fits :data:`BLOCKS`.

    Raises
    ------
    StorageError
        A block is of an unknown kind or damaged, or two blocks have different phones.
    """
    own = part_of(arrays, "blocks")
    if len({entry["name"] for entry in plain}) < len(plain) or any(
        name.partition(".")[0] not in map(str, range(len(plain))) for name in own
    ):
        raise DamagedFile(path, "its input blocks and their arrays do not fit each other")
    found = {
        entry["name"]: restore(entry["kind"], part_of(own, str(number)), entry["state"], path)
        for number, entry in enumerate(plain)
    }
    if len(set(map(phones_of, found.values())) - {()}) > 1:
        raise DamagedFile(path, "its input blocks have different phones")
    return found
