"""The rows that a system's ``models:`` asks for, and models of any family from their files. Imports no model."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, replace
from importlib import import_module
from math import prod
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, SettingError
from visualspeech.models.combined_rows import members_of, named_rows, reads_of, ready
from visualspeech.models.entries import combinations, family_settings, grid_of, inherited, model_mistakes
from visualspeech.models.families import FAMILIES, Family
from visualspeech.models.reads import read_names, read_windows
from visualspeech.models.rows import ModelRow
from visualspeech.models.training_settings import BATCHERS, FRAME_BATCHERS, training_settings
from visualspeech.storage.models import read_model

MOST_ROWS = 1000  # of a system; planning takes some seconds for so many
#: Rows that every system has: what a prediction must beat, and the error that none can fall below.
ALWAYS = {"training_mean": {"family": "mean"}, "reconstruction": {"family": "reconstruction"}}


def expand(models: Mapping, blocks: Collection, training: Mapping, seeds: Sequence[int], where: str) -> list[ModelRow]:
    """The rows of a system, in the order of the result tables, all settings filled in.

    Parameters
    ----------
    models : the system's ``models:``: key -> entry, or None to leave an inherited entry out
    blocks : names of its input blocks
    training : the system's settings of training, which an entry's own change
    seeds : of repetitions; the first one is not part of a row's name
    where : place of ``models`` in the settings, for messages

    Raises
    ------
    SettingError
        Entries are mistaken, a line for each mistake, or two rows have one name.
    """
    found = model_mistakes(models, blocks, where)
    if found:
        raise SettingError("\n".join(found))
    given = {key: dict(entry) for key, entry in models.items() if entry is not None}
    merged = {key: inherited(key, given) for key in given}
    merged |= {key: entry for key, entry in ALWAYS.items() if key not in merged}
    made: dict[str, list[ModelRow]] = {}
    while chosen := ready(merged, made, where):
        for key in chosen:
            _check_number(sum(map(len, made.values())) + _count(merged[key], seeds), where)
            made[key] = _rows_of(key, merged[key], training, seeds, made, f"{where}.{key}")
    rows: dict[str, ModelRow] = {}
    for key in merged:
        for row in made[key]:
            # Names are folders, and some file systems take names that differ in case only for one.
            if row.name.lower() in map(str.lower, rows):
                raise SettingError(
                    f"`{where}.{key}`: two rows are named {row.name} (capitals do not count); give one a `suffix`."
                )
            rows[row.name] = row
    _check_number(len(rows), where)
    order = {"model": 0, "baseline": 1, "floor": 2}
    return sorted(rows.values(), key=lambda row: order[row.role])


def _check_number(rows: int, where: str) -> None:
    if rows > MOST_ROWS:
        raise SettingError(f"`{where}` asks for more than {MOST_ROWS} rows; give fewer `letters`, `nodes` or `seeds`.")


def _count(entry: Mapping, seeds: Sequence[int]) -> int:
    """Number of rows that an entry asks for, or more."""
    family = FAMILIES[entry["family"]]
    return len(entry.get("seeds", seeds)) * prod(len(entry[name]) for name in grid_of(family, entry))


def _rows_of(
    key: str,
    entry: Mapping,
    training: Mapping,
    seeds: Sequence[int],
    made: Mapping[str, Sequence[ModelRow]],
    where: str,
) -> list[ModelRow]:
    """The rows of an entry, whose references all have theirs."""
    family = FAMILIES[entry["family"]]
    if family.made_of:
        known = {row.name: row for group in made.values() for row in group}
        rows = []
        for number, members in enumerate(members_of(entry, made, known, where)):
            # A row for each seed of the one that it is made from; an ensemble has its seeds inside.
            seed, own = (members[0].seed if family.made_of == "from" else seeds[0]), next(combinations(family, entry))
            row = _row(key, entry, own, training, seed, where, repeated=number > 0)
            rows.append(replace(row, reads=reads_of(members), parents=tuple(one.name for one in members)))
        return rows
    seeded = list(entry.get("seeds", seeds)) if family.trained else list(seeds)[:1]
    parents = (named_rows(entry["from"], made)[0].name,) if "from" in entry else ()
    return [
        replace(_row(key, entry, own, training, seed, where, repeated=number > 0), parents=parents)
        for number, seed in enumerate(seeded)
        for own in combinations(family, entry)
    ]


def _row(key: str, entry: Mapping, own: Mapping, training: Mapping, seed: int, where: str, repeated: bool) -> ModelRow:
    """A row with its own settings; ``repeated`` says that a row of an earlier seed has the name without the seed."""
    family = FAMILIES[entry["family"]]
    settings, reads = family_settings(family, own, where, entry), entry.get("reads", ())
    cell = family.cell(settings) if grid_of(family, entry) else key
    cell += f"-{entry['suffix']}" if entry.get("suffix") else ""
    return ModelRow(
        name=f"{cell}-s{seed}" if repeated else cell,
        title=entry.get("title") or family.title(cell, settings),
        family=entry["family"],
        settings=settings,
        reads=tuple(read_names(reads)),
        training=_training(family, {**training, **entry.get("training", {})}, where) if family.trained else {},
        seed=seed,
        group=key,
        cell=cell,
        role=family.role,
        windows=read_windows(reads),
    )


def _training(family: Family, given: Mapping, where: str) -> dict:
    settings = asdict(training_settings(given))
    if settings["batcher"] in FRAME_BATCHERS and not family.by_frame:
        raise SettingError(
            f"`{where}.training.batcher: {settings['batcher']}` is for models that predict each frame by itself, such "
            f"as the family dnn; give this entry `training: {{batcher: {BATCHERS[0]}}}`."
        )
    return {name: value for name, value in settings.items() if name != "seed"}


def code_modules(row: ModelRow, rows: Sequence[ModelRow]) -> list[str]:
    """Modules that are imported by name where a row is trained or predicts: its family's, and those of its parents."""
    by_name, found, waiting = {one.name: one for one in rows}, [], [row]
    while waiting:
        one = waiting.pop()
        found.append(FAMILIES[one.family].module)
        waiting += [by_name[name] for name in one.parents]
    return sorted(set(found))


def load_model(path: str | Path):
    """Read a trained model of any family; raises :class:`StorageError` where the file holds none."""
    return restore_model(*read_model(path), path)


def restore_model(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path):
    """A trained model of any family from its arrays and settings, which are in the file ``path``.

    Raises
    ------
    StorageError
        They are of no trained model.
    """
    if settings.get("kind") != "model":
        raise DamagedFile(path, "it holds no trained model")
    name = settings.get("family")
    if name not in [known for known, family in FAMILIES.items() if family.module]:
        raise DamagedFile(path, f"it is a model of the unknown family {name!r:.40}")
    return import_module(FAMILIES[name].module).restore(arrays, settings, path)
