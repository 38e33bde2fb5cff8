"""Data frames of records and tables of a results folder, and what is said where something is missing in one."""

import io
from collections.abc import Collection, Iterable, Mapping
from dataclasses import fields
from pathlib import Path

from visualspeech.errors import DataError
from visualspeech.storage.arrays import ArrayCollection

UNFINISHED = "Run the workflow's target `all` to its end, with the same settings."


def frame_of(records: Iterable, cls: type, left_out: Collection[str] = ()):
    """Records of a dataclass as a data frame, which has its columns also where there is no record."""
    import pandas

    columns = [field.name for field in fields(cls) if field.name not in left_out]
    return pandas.DataFrame([[getattr(one, name) for name in columns] for one in records], columns=columns)


def table_of(folder: Path, name: str):
    """A result table, whose first lines are ``# key: value``."""
    import pandas

    path = folder / "tables" / f"{name}.tsv"
    if not path.is_file():
        known = sorted(one.stem for one in path.parent.glob("*.tsv"))
        raise DataError(f"{folder} has no table {name!r}; it has {listed(known)}.")
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    notes = [line[1:].strip() for line in lines if line.startswith("#")]
    text = "".join(line for line in lines if not line.startswith("#"))
    frame = pandas.read_csv(io.StringIO(text), sep="\t")
    frame.attrs.update(dict(note.partition(": ")[::2] for note in notes))
    return frame


def known_in(arrays: ArrayCollection, utterance: str, folder: Path) -> str:
    if utterance not in arrays:
        raise DataError(f"{folder} has no utterance {utterance!r}; it has {listed(arrays.ids)}.")
    return utterance


def found_in(found: Mapping, utterance: str, folder: Path):
    if utterance not in found:
        raise DataError(f"{folder} has no utterance {utterance!r}; it has {listed(sorted(found))}.")
    return found[utterance]


def listed(names, most: int = 8) -> str:
    names = list(names)
    shown = ", ".join(names[:most]) or "none"
    return f"{shown}, ... ({len(names)})" if len(names) > most else shown
