"""``docs/data.md`` as data, and what a results folder has that it does not describe."""

import json
import re
from dataclasses import dataclass, field
from pathlib import Path

import h5py
from safetensors import safe_open

from tests.paths import REPOSITORY
from visualspeech.evaluation.articulation import ARTICULATION
from visualspeech.evaluation.metrics import METRICS

PAGE = REPOSITORY / "docs" / "data.md"
_NAME = r"[A-Za-z0-9_][A-Za-z0-9_.-]*"
#: What the names in angle brackets stand for.
HOLES = {
    "shard": r"\d+", "n": r"\d+", "number": r"\d+", "region": "upper|middle|lower",
    "class": "bilabial|labiodental|open", "name": r"[A-Za-z0-9_.]+",
    "measure": "|".join(map(re.escape, sorted([*METRICS, *ARTICULATION], key=len, reverse=True))),
}  # fmt: skip
_TYPES = {"F32": "float32", "F64": "float64", "I32": "int32", "I64": "int64", "I16": "int16", "I8": "int8",
          "U8": "uint8", "U16": "uint16", "BOOL": "bool"}  # fmt: skip


def pattern(text: str) -> re.Pattern:
    """The regular expression of a name with holes; ``**`` stands for any path."""
    parts = re.split(r"<(\w+)>|(\*\*/?)", text)
    made = ""
    for at, part in enumerate(parts):
        if part is None:
            continue
        if at % 3 == 1:
            made += f"(?:{HOLES.get(part, _NAME)})"
        elif at % 3 == 2:
            made += "(?:.*/)?" if part.endswith("/") else ".*"
        else:
            made += re.escape(part)
    return re.compile(made)


@dataclass
class Described:
    """Files of one form and what is in them.

    Parameters
    ----------
    path : with holes
    rows : name with holes -> the other cells of its line
    """

    path: str
    rows: dict[str, list[str]] = field(default_factory=dict)

    def row(self, name: str) -> list[str] | None:
        return next((cells for known, cells in self.rows.items() if pattern(known).fullmatch(name)), None)


def described() -> list[Described]:
    """All files that the page describes, the most exact names first."""
    found: list[Described] = []
    current: list[Described] = []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            current = [Described(path) for path in re.findall(r"`([^`]+)`", line)] if line.startswith("### ") else []
            found += current
        elif line.startswith("| `"):
            cells = [cell.strip() for cell in line.strip("|").split("|")]
            names = re.findall(r"`([^`]+)`", cells[0])
            if current:
                for one in current:
                    one.rows |= {name: cells[1:] for name in names}
            else:
                found += map(Described, names)
        elif line.startswith(("The same for people", "sound,", "with triphones")):
            found += map(Described, (name for name in re.findall(r"`([^`]+)`", line) if "/" in name))
    return sorted(found, key=lambda one: (one.path.count("**"), one.path.count("<")))


def undescribed(folder: Path) -> list[str]:
    """What a results folder holds that the page does not describe, or describes otherwise; a line for each."""
    known, found = described(), []
    for path in sorted(one for one in folder.rglob("*") if one.is_file()):
        name = path.relative_to(folder).as_posix()
        one = next((one for one in known if pattern(one.path).fullmatch(name)), None)
        found += [f"{name}: {said}" for said in (_content(path, one) if one else ["the file is not described"])]
    return found


def unused(*folders: Path) -> set[str]:
    """Descriptions that no file of these results folders has."""
    names = [path.relative_to(folder).as_posix() for folder in folders for path in folder.rglob("*") if path.is_file()]
    return {one.path for one in described() if not any(pattern(one.path).fullmatch(name) for name in names)}


def _content(path: Path, one: Described) -> list[str]:
    if path.suffix == ".h5":
        return _hdf5(path, one)
    if path.suffix == ".safetensors" and path.stem != "checkpoint":
        with safe_open(str(path), "numpy") as file:
            slices = {name: file.get_slice(name) for name in file.keys()}
            shapes = {name: (tuple(part.get_shape()), _TYPES[part.get_dtype()]) for name, part in slices.items()}
        return _arrays(shapes, one)
    if path.suffix == ".tsv":
        line = next((line for line in path.read_text().splitlines() if not line.startswith("#")), "")
        return [f"the column {name} is not described" for name in line.split("\t") if one.row(name) is None]
    if path.suffix == ".json":
        return [f"the key {name} is not described" for name in json.loads(path.read_text()) if one.row(name) is None]
    return []


def _hdf5(path: Path, one: Described) -> list[str]:
    found: list[str] = []
    with h5py.File(path) as file:
        attributes = set(file.attrs)
        for group in file.values():
            attributes |= set(group.attrs)
            found += _arrays({name: (data.shape, str(data.dtype)) for name, data in group.items()}, one)
            units = {key for data in group.values() for key in data.attrs} - {"units"}
            found += [f"the attribute {name} of an array is not described" for name in units]
    for name in sorted(attributes):
        cells = one.row(name)
        if cells is None or cells[0] != "attribute":
            found.append(f"the attribute {name} is not described")
    return list(dict.fromkeys(found))


def _arrays(arrays: dict, one: Described) -> list[str]:
    """What is wrong with the description of the arrays of one group: name -> shape and type."""
    found, sizes = [], {}
    for name, (shape, kind) in arrays.items():
        cells = one.row(name)
        if cells is None:
            found.append(f"the array {name} is not described")
        elif cells[0] != "any" and not _fits(shape, cells[0], sizes):
            found.append(f"the array {name} is {shape}, described as {cells[0]}")
        elif cells[1] != "any" and kind not in cells[1].split(" or "):
            found.append(f"the array {name} is {kind}, described as {cells[1]}")
    return found


def _fits(shape: tuple[int, ...], text: str, sizes: dict[str, int]) -> bool:
    """Whether a shape is the one that is described, with the symbols of the other arrays of its group."""
    wanted = [part.strip() for part in text.strip("()").split(",") if part.strip()]
    if len(wanted) != len(shape):
        return False
    for size, part in zip(shape, wanted, strict=True):
        factor, symbol = re.fullmatch(r"(\d*)([A-Za-z]?)", part).groups()
        if not symbol:
            if size != int(factor):
                return False
        elif size % int(factor or 1) or sizes.setdefault(symbol, size // int(factor or 1)) != size // int(factor or 1):
            return False
    return True
