"""Settings as frozen dataclasses: the default, the bounds and the description of a field stand in one place, beside it.

The library checks a value when the dataclass is built; the workflow derives its schema from the same fields
(:func:`section_schema`) and reports every mistake before a job starts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, asdict, field, fields, is_dataclass
from importlib import import_module
from types import UnionType
from typing import ClassVar, get_args, get_origin, get_type_hints

from visualspeech.errors import SettingError

#: Keyword of :func:`setting` -> keyword of JSON Schema, the test, and how a message says it.
_BOUNDS = {
    "minimum": ("minimum", lambda value, bound: value >= bound, "at least {}"),
    "maximum": ("maximum", lambda value, bound: value <= bound, "at most {}"),
    "above": ("exclusiveMinimum", lambda value, bound: value > bound, "above {}"),
    "below": ("exclusiveMaximum", lambda value, bound: value < bound, "below {}"),
}
_TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}


def setting(default, description: str, *, choices: Sequence = (), item: Mapping | None = None, **bounds):
    """A field of a settings dataclass.

    Parameters
    ----------
    default : value where none is given; a mutable one is copied
    description : one sentence with the unit, shown in messages and in the schema
    choices : the values that are allowed; any where empty
    item : for a list, JSON Schema keywords of its entries (``minimum``, ``enum``, ...)
    bounds : ``minimum``, ``maximum``, ``above``, ``below``; ``min_items`` and ``unique`` of a list
    """
    metadata = {"description": description, "choices": tuple(choices), "item": dict(item or {}), **bounds}
    if isinstance(default, dict | list):
        return field(default_factory=lambda: type(default)(default), metadata=metadata)
    return field(default=default, metadata=metadata)


class Settings:
    """Base of settings dataclasses: every field is checked when one is built.

    Raises
    ------
    SettingError
        A value is out of bounds, no allowed choice, or of the wrong type.
    """

    #: Section of the run's settings that messages name, for example ``pose``.
    section: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for one in fields(self):
            if one.metadata:
                _check(self.section, one, getattr(self, one.name), type(self))


def _check(section: str, one, value, cls) -> None:
    kind = get_type_hints(cls)[one.name]
    rule = ""
    if kind in (int, float) and not _is_number(value, kind):
        rule = "a whole number" if kind is int else "a finite number"
    elif kind in (bool, str) and not isinstance(value, kind):
        rule = "true or false" if kind is bool else "text"
    elif one.metadata["choices"] and value not in one.metadata["choices"]:
        rule = f"one of {', '.join(map(str, one.metadata['choices']))}"
    else:
        for name, (_, holds, words) in _BOUNDS.items():
            if name in one.metadata and isinstance(value, int | float) and not holds(value, one.metadata[name]):
                rule = words.format(one.metadata[name])
    if rule:
        key = f"{section}.{one.name}" if section else one.name
        raise SettingError(f"`{key}: {value}` must be {rule}. {one.metadata['description']}")


def _is_number(value, kind) -> bool:
    allowed = int if kind is int else int | float
    return isinstance(value, allowed) and not isinstance(value, bool) and math.isfinite(value)


def section_schema(cls, description: str = "", hidden: Sequence[str] = ()) -> dict:
    """JSON Schema (2020-12) of a settings dataclass; unknown keys are errors.

    Parameters
    ----------
    cls : subclass of :class:`Settings`
    description : of the section; default: first line of the class's docstring
    hidden : fields that a run sets itself, such as ``seed``
    """
    hints = get_type_hints(cls)
    properties = {
        one.name: _field_schema(hints[one.name], one.metadata)
        for one in fields(cls)
        if one.metadata and one.name not in hidden
    }
    first = (cls.__doc__ or "").strip().split("\n")[0]
    return {
        "description": description or first,
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _field_schema(kind, metadata: Mapping) -> dict:
    schema = {"description": metadata["description"]}
    if is_dataclass(kind):
        return section_schema(kind, metadata["description"])
    origin = get_origin(kind)
    if metadata["choices"]:
        schema["enum"] = list(metadata["choices"])
    elif kind in _TYPES:
        schema["type"] = _TYPES[kind]
    elif origin is UnionType:
        schema["type"] = [_TYPES[one] for one in get_args(kind)]
    elif origin in (tuple, list):
        schema |= {"type": "array", "items": {"type": _TYPES[get_args(kind)[0]], **metadata["item"]}}
        schema |= {"minItems": metadata["min_items"]} if "min_items" in metadata else {}
        schema |= {"uniqueItems": True} if metadata.get("unique") else {}
    else:  # a mapping: its own schema is given
        schema |= metadata["item"] or {"type": "object"}
    for name, (keyword, _, _) in _BOUNDS.items():
        if name in metadata:
            schema[keyword] = metadata[name]
    return schema


def with_defaults(cls, given: Mapping, hidden: Sequence[str] = ()) -> dict:
    """All fields of a section as plain data: what is given, and the defaults of what is not.

    Raises
    ------
    SettingError
        As :class:`Settings`.
    """
    filled = asdict(cls(**given))
    return {name: value for name, value in filled.items() if name not in hidden}


def default_of(one):
    """Default of a dataclass field."""
    return one.default if one.default is not MISSING else one.default_factory()


def class_named(reference: str):
    """The class that ``module:Class`` names, inside this package.

    Raises
    ------
    ValueError
        The module is outside the package.
    """
    module, _, name = reference.partition(":")
    if module.partition(".")[0] != __name__.partition(".")[0]:
        raise ValueError(f"{reference} is outside the package")
    return getattr(import_module(module), name)
