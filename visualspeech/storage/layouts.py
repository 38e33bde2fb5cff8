"""What a file must hold: names, types, shapes and values of its arrays, and a JSON Schema of its plain data.

A file may come from a stranger. One check of the whole file, right after it is read, stands for all checks of the code
that uses it::

    FileLayout(
        arrays={"points": Array("f", (68, 3)), "rigid": Array("iu", ("R",), low=0, high=67)},
        plain={"focal": {"type": "number", "exclusiveMinimum": 0}},
    )
"""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from visualspeech.errors import DamagedFile

#: Largest value of a real array unless its layout says otherwise: products of some of them stay finite numbers.
MAGNITUDE = 1e12
_NO_TYPES = (np.dtype(np.float16), np.dtype(np.longdouble))  # real types that not every library here reads
#: JSON Schemas that several kinds of files share.
TEXT = {"type": "string", "maxLength": 100_000}
RATE = {"type": "number", "minimum": 0.01, "maximum": 10_000}
PHONES = {
    "type": "array",
    "minItems": 1,
    "maxItems": 1000,
    "uniqueItems": True,
    "items": {"type": "string", "minLength": 1, "maxLength": 100},
    "contains": {"const": "sil"},
}


@dataclass(frozen=True)
class Array:
    """One array of a file; real values must be finite.

    Parameters
    ----------
    kinds : allowed kinds of numpy types: ``f`` real, ``i`` and ``u`` integer, ``b`` truth values
    shape : sizes; a name such as ``N`` or ``3U`` stands for a size, or a multiple of one, that is the same in all
        arrays of the file; one that ends in ``?`` may be 0. None: any shape without an empty dimension
    low, high : bounds of the values
    """

    kinds: str
    shape: tuple[int | str, ...] | None
    low: float = -MAGNITUDE
    high: float = MAGNITUDE


@dataclass(frozen=True)
class FileLayout:
    """The content of one kind of files.

    Parameters
    ----------
    arrays : by name; ``weights.*`` stands for all names that begin so. An array that is not named here is refused
    plain : JSON Schema of each key of the plain data; every key is required, others are refused
    """

    arrays: Mapping[str, Array] = field(default_factory=dict)
    plain: Mapping[str, Mapping] = field(default_factory=dict)

    def check(self, path, arrays: Mapping[str, np.ndarray], plain: Mapping) -> dict[str, int]:
        """Check the content of the file ``path``; returns the sizes by name.

        Raises
        ------
        DamagedFile
            It is not of this layout; the message names the array or the key.
        """
        schema = {"type": "object", "required": list(self.plain), "additionalProperties": False}
        check_plain(path, plain, {**schema, "properties": dict(self.plain)})
        return check_arrays(path, arrays, self.arrays)


def check_arrays(
    path, arrays: Mapping[str, np.ndarray], layout: Mapping[str, Array], sizes: Mapping[str, int] | None = None
) -> dict[str, int]:
    """Check arrays against their layout; returns the sizes by name.

    Parameters
    ----------
    path : of their file, for messages
    sizes : those that are known beforehand

    Raises
    ------
    DamagedFile
        An array is missing, unknown, or of another type or shape, or a value is not finite or out of bounds.
    """
    known = dict(sizes or {})
    for name in layout:
        if name not in arrays and not name.endswith("*"):
            raise DamagedFile(path, f"the array {name!r} is missing")
    for name, values in arrays.items():
        found = layout.get(name) or layout.get(f"{name.partition('.')[0]}.*")
        if found is None:
            raise DamagedFile(path, f"the array {name!r} is unknown")
        if values.dtype.kind not in found.kinds or values.dtype in _NO_TYPES:
            raise DamagedFile(path, f"the array {name!r} is of the type {values.dtype}")
        wanted = found.shape
        if not (0 not in values.shape if wanted is None else _fits(values.shape, wanted, known)):
            expected = ", ".join(_shown(size, known) for size in wanted or ())
            raise DamagedFile(path, f"the array {name!r} has the shape {values.shape}, not ({expected})")
        if values.size and not _within(values, found):
            raise DamagedFile(
                path, f"the array {name!r} has a value that is no number from {found.low:g} to {found.high:g}"
            )
    return known


def parse_plain(text: str):
    """What a JSON text holds; numbers that are not finite or take more than 64 bits are None.

    Raises
    ------
    ValueError, RecursionError
        It is no JSON, or nested too deeply.
    """

    def real(digits: str) -> float | None:
        value = float(digits)
        return value if math.isfinite(value) else None

    def whole(digits: str) -> int | None:
        value = int(digits)
        return value if abs(value) < 2**63 else None

    return json.loads(text, parse_constant=lambda _: None, parse_float=real, parse_int=whole)


def check_plain(path, plain, schema: Mapping) -> None:
    """Check plain data, as JSON holds it, against a JSON Schema.

    Raises
    ------
    DamagedFile
        The data break a rule; the message names the key.
    """
    from jsonschema import Draft202012Validator

    try:
        error = next(Draft202012Validator(schema).iter_errors(plain), None)
    except RecursionError:
        raise DamagedFile(path, "its settings are nested too deeply") from None
    if error is not None:
        key = ".".join(map(str, error.absolute_path))
        said = error.message if len(error.message) <= 200 else f"{error.message[:200]} ..."
        raise DamagedFile(path, f"`{key}` in its settings: {said}" if key else f"its settings: {said}")


def _fits(shape: tuple[int, ...], wanted: tuple, known: dict[str, int]) -> bool:
    """Whether a shape is the wanted one; sizes that were not known are entered."""
    if len(shape) != len(wanted):
        return False
    for size, want in zip(shape, wanted, strict=True):
        if isinstance(want, int):
            if size != want:
                return False
            continue
        factor, name = _factor(want)
        whole, rest = divmod(size, factor)
        if rest or known.setdefault(name, whole) != whole or not (whole or name.endswith("?")):
            return False
    return True


def _factor(want: str) -> tuple[int, str]:
    """The factor and the name of ``3U``."""
    digits = want[: len(want) - len(want.lstrip("0123456789"))]
    return int(digits or 1), want[len(digits) :]


def _shown(want: int | str, known: Mapping[str, int]) -> str:
    if isinstance(want, int):
        return str(want)
    factor, name = _factor(want)
    return str(factor * known[name]) if known.get(name) else want


def _within(values: np.ndarray, layout: Array) -> bool:
    if values.dtype.kind == "b":
        return True
    # A minimum of values of which one is NaN is NaN, and no comparison with it holds.
    return float(values.min()) >= layout.low and float(values.max()) <= layout.high
