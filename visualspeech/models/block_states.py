"""The input blocks of a model inside the model's file, so that it can read new speech by itself."""

from collections.abc import Mapping

import numpy as np

from visualspeech.features.blocks.base import Block, load_block, restore
from visualspeech.storage.models import part_of


def load_blocks(paths: Mapping[str, str]) -> dict[str, Block]:
    """Fitted blocks by name, from their files."""
    return {name: load_block(path) for name, path in paths.items()}


def pack(blocks: Mapping[str, Block]) -> tuple[dict[str, np.ndarray], list[dict]]:
    """Arrays (named ``blocks.<number>.<name>``) and plain data of blocks, in their order."""
    arrays: dict[str, np.ndarray] = {}
    plain = []
    for number, (name, block) in enumerate(blocks.items()):
        own, state = block.state()
        arrays |= {f"blocks.{number}.{key}": values for key, values in own.items()}
        plain.append({"name": name, "kind": block.kind, "state": state})
    return arrays, plain


def unpack(arrays: Mapping[str, np.ndarray], plain: list[dict]) -> dict[str, Block]:
    """The inverse of :func:`pack`.

    Raises
    ------
    StorageError
        A block is of an unknown kind or damaged.
    """
    own = part_of(arrays, "blocks")
    return {
        entry["name"]: restore(entry["kind"], part_of(own, str(number)), entry["state"])
        for number, entry in enumerate(plain)
    }
