"""Facial animation parameters (FAPs) of MPEG-4, and their text format 2.1.

A file begins with a line of version, name, frame rate and number of frames. Each frame is two lines: 68 masks, 1 where
the frame holds a value of the parameter, and the number of the frame followed by these values alone, as integers.
Parameters 1 (viseme) and 2 (expression) have several numbers and are never written here. ISO/IEC 14496-2, annex C.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError
from visualspeech.settings import read_yaml
from visualspeech.storage.files import write_text

PARAMETERS = 68
FOLDER = Path(__file__).parent / "standards"


@dataclass(frozen=True)
class Fap:
    """One parameter.

    Parameters
    ----------
    number : 1 to 68
    name, unit : as in the standard
    negative : whether it has negative values
    limit : largest absolute value
    range : what the range of an actor's motion is scaled to; 0 where no export writes the parameter
    """

    number: int
    name: str
    unit: str
    negative: bool
    limit: int
    range: float


@cache
def faps() -> Mapping[str, Fap]:
    """Name -> parameter, of the displacements and rotations 3 to 68."""
    rows = read_yaml(FOLDER / "faps.yaml")["parameters"]
    return {
        row["name"]: Fap(number, row["name"], row["unit"], row["negative"], row["limit"], float(row["range"]))
        for number, row in rows.items()
    }


def write_fap(path: str | Path, values: Mapping[str, np.ndarray], rate: float, name: str = "") -> None:
    """Write a FAP 2.1 text file.

    Parameters
    ----------
    values : name of a parameter -> (T,) in its unit; rounded, and limited to what the standard can code
    rate : frame rate in Hz; the format has whole numbers only
    name : of the animation, default that of the file; characters other than letters, digits, ``.``, ``-`` and ``_``
        become underscores

    Raises
    ------
    DataError
        A parameter is unknown, lengths differ, a value is not finite, or the rate is not a whole number.
    StorageError
        The file cannot be written.
    """
    known = faps()
    unknown = sorted(set(values) - set(known))
    lengths = {len(one) for one in values.values()}
    if unknown or len(lengths) != 1:
        raise DataError(f"FAP file {path}: unknown parameters {unknown}, lengths {sorted(lengths)}; one is needed.")
    if rate != round(rate) or rate < 1:
        raise DataError(f"FAP file {path}: the frame rate is {rate:g} Hz; the format has whole numbers only. Resample.")
    ordered = sorted(values, key=lambda one: known[one].number)
    table = np.stack([_coded(np.asarray(values[one], float), known[one], path) for one in ordered], axis=1)
    held = {known[one].number for one in ordered}
    mask = " ".join("1" if number in held else "0" for number in range(1, PARAMETERS + 1))
    title = re.sub(r"[^A-Za-z0-9._-]", "_", name or Path(path).stem)
    lines = [f"2.1 {title} {int(rate)} {len(table)}"]
    for index, row in enumerate(table):
        lines += [mask, " ".join(map(str, (index, *row)))]
    write_text(path, "\n".join(lines) + "\n")


def _coded(values: np.ndarray, fap: Fap, path) -> np.ndarray:
    if not np.isfinite(values).all():
        raise DataError(f"FAP file {path}: {fap.name} has values that are not finite.")
    return np.clip(np.rint(values), -fap.limit if fap.negative else 0, fap.limit).astype(int)
