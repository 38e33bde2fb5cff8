"""Finished models inside the file of a model that is made of them, so that one file is complete."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.streams import Stream
from visualspeech.models.combined_settings import MAX_DEPTH, MAX_MEMBERS
from visualspeech.models.task import Model, check_streams
from visualspeech.storage.models import part_of, read_model


@dataclass(frozen=True)
class Member:
    """A finished model and the content of its file.

    Parameters
    ----------
    model : of any family
    arrays, settings : as they are in its own file
    """

    model: Model
    arrays: Mapping[str, np.ndarray] = field(repr=False)
    settings: Mapping = field(repr=False)


def read_member(path: str | Path) -> Member:
    """A finished model of any family; raises as :func:`visualspeech.models.registry.load_model`."""
    return _member(*read_model(path), path)


def _member(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> Member:
    # By name: the registry knows all families, and importing it would put a change of its list into the code of a row.
    registry = import_module("visualspeech.models.registry")
    return Member(registry.restore_model(arrays, settings, path), arrays, settings)


#: Plain data of :func:`pack` in a model's layout. Its arrays are checked as those of the members' own families.
MEMBERS = {"type": "array", "minItems": 1, "maxItems": MAX_MEMBERS, "items": {"type": "object"}}


def pack(members: Sequence[Member]) -> tuple[dict[str, np.ndarray], list[dict]]:
    """Arrays (named ``members.<number>.<name>``) and settings of members, in their order."""
    arrays = {
        f"members.{number}.{name}": values
        for number, member in enumerate(members)
        for name, values in member.arrays.items()
    }
    return arrays, [dict(member.settings) for member in members]


def without_members(arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays of a file that are not those of its members."""
    return {name: values for name, values in arrays.items() if not name.startswith("members.")}


def unpack(arrays: Mapping[str, np.ndarray], plain: Sequence[Mapping], path: str | Path) -> tuple[Member, ...]:
    """The inverse of :func:`pack`, for content of the file ``path`` whose plain data fit :data:`MEMBERS`.

    Raises
    ------
    StorageError
        A member is no model, or members do not fit each other.
    """
    level, depth = list(plain), 1
    while level:
        depth += 1
        if depth > MAX_DEPTH:
            raise DamagedFile(path, f"it is made of models that are made of models, more than {MAX_DEPTH} deep")
        inner = [one["members"] for one in level if isinstance(one.get("members"), list)]
        level = [one for part in inner for one in part if isinstance(one, Mapping)]
    own = part_of(arrays, "members")
    if {name.partition(".")[0] for name in own} - {str(number) for number in range(len(plain))}:
        raise DamagedFile(path, "its members and their arrays do not fit each other")
    members = tuple(_member(part_of(own, str(number)), one, path) for number, one in enumerate(plain))
    try:
        check_alike([member.model for member in members])
    except DataError as error:
        raise DamagedFile(path, f"its members do not fit each other: {error}") from error
    return members


def check_alike(models: Sequence[Model]) -> None:
    """Check that models predict the same parameters at the same rate, and mean the same by an input block's name.

    Raises
    ------
    DataError
        They do not.
    """
    for name, found in (
        ("frame rates", {model.rate for model in models}),
        ("numbers of parameters", {model.outputs for model in models}),
        ("visual codings", {model.coding for model in models}),
    ):
        if len(found) > 1:
            raise DataError(f"they have different {name} ({', '.join(sorted(map(str, found)))[:200]}).")
    known: dict[str, Block] = {}
    for model in models:
        for name, block in model.blocks.items():
            if not _same(known.setdefault(name, block), block):
                raise DataError(f"they read different input blocks named {name}.")


def _same(one: Block, other: Block) -> bool:
    (arrays, plain), (others, other_plain) = one.state(), other.state()
    same = (one.kind, plain, set(arrays)) == (other.kind, other_plain, set(others))
    return same and all(np.array_equal(values, others[name]) for name, values in arrays.items())


def blocks_of(models: Sequence[Model]) -> dict[str, Block]:
    """All input blocks that models read, by name, in the order in which they come first."""
    found: dict[str, Block] = {}
    for model in models:
        found |= {name: block for name, block in model.blocks.items() if name not in found}
    return found


def predictions(
    models: Sequence[Model], blocks: Mapping[str, Block], streams: Sequence[Stream], frames: int, rate: float
):
    """What each model predicts of one utterance, (frames, N) each, from the streams of all ``blocks``.

    Raises
    ------
    DataError
        A stream does not fit its block, or as the models' ``predict``.
    """
    check_streams(streams, blocks)
    by_name = dict(zip(blocks, streams, strict=True))
    for model in models:
        yield model.predict([by_name[name] for name in model.blocks], frames, rate)
