"""The rows that a system's ``models:`` asks for, and models of any family from their files. Imports no model."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from importlib import import_module
from math import prod
from pathlib import Path

from visualspeech.errors import DamagedFile, SettingError
from visualspeech.models.entries import combinations, family_settings, grid_of, inherited, model_mistakes
from visualspeech.models.families import FAMILIES
from visualspeech.models.rows import ModelRow
from visualspeech.models.training_settings import training_settings
from visualspeech.storage.models import read_model_settings

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
    rows: dict[str, ModelRow] = {}
    for key, entry in {**merged, **{key: entry for key, entry in ALWAYS.items() if key not in merged}}.items():
        if len(rows) + _count(entry, seeds) > MOST_ROWS:
            raise SettingError(
                f"`{where}` asks for more than {MOST_ROWS} rows; give fewer `letters`, `nodes` or `seeds`."
            )
        for row in _rows_of(key, entry, training, seeds, f"{where}.{key}"):
            # Names are folders, and some file systems take names that differ in case only for one.
            if row.name.lower() in map(str.lower, rows):
                raise SettingError(
                    f"`{where}.{key}`: two rows are named {row.name} (capitals do not count); give one a `suffix`."
                )
            rows[row.name] = row
    order = {"model": 0, "baseline": 1, "floor": 2}
    return sorted(rows.values(), key=lambda row: order[row.role])


def _count(entry: Mapping, seeds: Sequence[int]) -> int:
    """Number of rows that an entry asks for, or more."""
    family = FAMILIES[entry["family"]]
    return len(entry.get("seeds", seeds)) * prod(len(entry[name]) for name in grid_of(family, entry))


def _rows_of(key: str, entry: Mapping, training: Mapping, seeds: Sequence[int], where: str) -> list[ModelRow]:
    family = FAMILIES[entry["family"]]
    seeded = list(entry.get("seeds", seeds)) if family.trained else list(seeds)[:1]
    rows = []
    for number, seed in enumerate(seeded):
        for own in combinations(family, entry):
            settings = family_settings(family, own, where, entry)
            cell = family.cell(settings) if grid_of(family, entry) else key
            cell += f"-{entry['suffix']}" if entry.get("suffix") else ""
            rows.append(
                ModelRow(
                    name=cell if number == 0 else f"{cell}-s{seed}",
                    title=entry.get("title") or family.title(cell, settings),
                    family=entry["family"],
                    settings=settings,
                    reads=tuple(entry.get("reads", ())),
                    training=_training({**training, **entry.get("training", {})}) if family.trained else {},
                    seed=seed,
                    group=key,
                    cell=cell,
                    parent=entry.get("from", ""),
                    role=family.role,
                )
            )
    return rows


def _training(given: Mapping) -> dict:
    settings = asdict(training_settings(given))
    return {name: value for name, value in settings.items() if name != "seed"}


def load_model(path: str | Path):
    """Read a trained model of any family; raises :class:`StorageError` where the file holds none."""
    settings = read_model_settings(path)
    if settings.get("kind") != "model":
        raise DamagedFile(path, "it holds no trained model")
    name = settings.get("family")
    if name not in [known for known, family in FAMILIES.items() if family.module]:
        raise DamagedFile(path, f"it is a model of the unknown family {name!r:.40}")
    return import_module(FAMILIES[name].module).load(path)
