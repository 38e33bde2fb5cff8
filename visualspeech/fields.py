"""Settings as frozen dataclasses whose fields state their own default, bounds and description.

The library checks a value when the dataclass is built; the workflow derives its schema from the same fields
(:func:`section_schema`) and reports every error before a job starts. A settings class is defined beside the functions
that read it. If their module imports a heavy library (video, networks), the class has its own module, named
``<module>_settings``, so that planning a run stays fast.
"""

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING, asdict, field, fields, is_dataclass
from functools import cache
from types import UnionType
from typing import ClassVar, get_args, get_origin, get_type_hints

from visualspeech.errors import SettingError, StorageError

#: Keyword of :func:`setting` -> keyword of JSON Schema, test of a value, wording in messages.
_BOUNDS = {
    "minimum": ("minimum", lambda value, bound: value >= bound, "at least {}"),
    "above": ("exclusiveMinimum", lambda value, bound: value > bound, "above {}"),
    "maximum": ("maximum", lambda value, bound: value <= bound, "at most {}"),
    "below": ("exclusiveMaximum", lambda value, bound: value < bound, "below {}"),
}
#: Largest seed, within the range of every random number generator in use.
MAX_SEED = 999_999_999
#: Rule of a text that does not match its pattern, which the description that follows says in words.
FORM = "of this form"
_TYPES = {bool: "boolean", int: "integer", float: "number", str: "string"}


def setting(default, description: str, *, choices: Collection = (), item: Mapping | None = None, **bounds):
    """A field of a settings dataclass.

    Parameters
    ----------
    default : value if none is given; a mutable one is copied
    description : one sentence with the unit, shown in messages and in the schema
    choices : allowed values; empty for any. A registry (a mapping by name) is read at each check
    item : for a list, the rules of its entries as keywords of this function (``minimum``, ``choices``, ...) with their
        ``description``; for a mapping, its JSON Schema
    bounds : ``minimum``, ``maximum``, ``above``, ``below`` of a number; ``min_items``, ``unique`` and
        ``max_items`` of a list; ``min_length`` and ``max_length`` of a text, and ``pattern``: a regular expression that
        all of it matches

    Raises
    ------
    TypeError
        A bound is unknown.
    """
    unknown = set(bounds) - {*_BOUNDS, "min_items", "max_items", "unique", "min_length", "max_length", "pattern"}
    if unknown:
        raise TypeError(f"unknown bounds of a setting: {', '.join(sorted(unknown))}")
    metadata = {"description": description, "choices": choices, "item": dict(item or {}), **bounds}
    if isinstance(default, dict | list):
        return field(default_factory=lambda: type(default)(default), metadata=metadata)
    return field(default=default, metadata=metadata)


class Settings:
    """Base of settings dataclasses; all fields are checked when an instance is built.

    A list given for a tuple becomes one, and a mapping given for a nested settings dataclass builds it.

    Raises
    ------
    SettingError
        A value is out of bounds, not among the choices, or of the wrong type.
    """

    #: Section of the run's settings that messages name, for example ``pose``.
    section: ClassVar[str] = ""

    def __post_init__(self) -> None:
        for name, kind, metadata in described_fields(type(self)):
            value = getattr(self, name)
            if get_origin(kind) is tuple and isinstance(value, list):
                object.__setattr__(self, name, value := tuple(value))
            if is_dataclass(kind) and isinstance(value, Mapping):
                object.__setattr__(self, name, value := _built(kind, value))
            rule = _broken_rule(value, kind, metadata)
            if rule:
                raise setting_error(type(self), name, value, rule)


class FieldError(SettingError):
    """An invalid value of a field of a settings dataclass.

    Parameters
    ----------
    key : of the value, beginning with the section of its class, for example ``aam.shape.components``
    rest : the message after the key
    """

    def __init__(self, key: str, rest: str) -> None:
        super().__init__(key, rest)
        self.key, self.rest = key, rest

    def __str__(self) -> str:
        return f"`{self.key}{self.rest}"

    def at(self, section: str, where: str) -> "FieldError":
        """The same error with the key as in a run's settings, where the section has the path ``where``."""
        inner = self.key.removeprefix(section).removeprefix(".")
        return FieldError(f"{where}.{inner}" if inner else where, self.rest)


def setting_error(cls, name: str, value, rule: str) -> FieldError:
    """The error for an invalid value of a field: `` `pose.noise: 0` must be <rule>. <description>``."""
    key = f"{cls.section}.{name}" if cls.section else name
    shown = list(value) if isinstance(value, tuple) else value
    description = next((metadata["description"] for one, _, metadata in described_fields(cls) if one == name), "")
    return FieldError(key, f": {shortened(shown)}` must be {rule}{':' if rule == FORM else '.'} {description}".rstrip())


@cache
def described_fields(cls) -> tuple[tuple[str, type, Mapping], ...]:
    """Name, type and metadata of each field of a settings dataclass that :func:`setting` made."""
    hints = get_type_hints(cls)
    return tuple((one.name, hints[one.name], one.metadata) for one in fields(cls) if one.metadata)


def _broken_rule(value, kind, metadata: Mapping) -> str:
    """The rule that a value breaks, in words; empty if it breaks none."""
    if is_dataclass(kind):
        return "" if isinstance(value, kind) else "lines of `key: value`"
    if get_origin(kind) in (tuple, list):
        return _broken_list_rule(value, get_args(kind)[0], metadata)
    if kind in (int, float) and not _is_number(value, kind):
        bounds = _range(metadata)
        return f"a {'whole' if kind is int else 'finite'} number{', ' * bool(bounds)}{bounds}"
    if kind in (bool, str) and not isinstance(value, kind):
        return "true or false" if kind is bool else "a text"
    choices = metadata.get("choices", ())
    if choices and value not in list(choices):
        return f"one of {', '.join(map(str, choices))}"
    if kind is str and len(value) < metadata.get("min_length", 0):
        return "a text that is not empty"
    if kind is str and len(value) > metadata.get("max_length", math.inf):
        return f"a text of at most {metadata['max_length']} characters"
    if kind is str and "pattern" in metadata and not re.fullmatch(metadata["pattern"], value):
        return FORM
    inside = all(holds(value, metadata[name]) for name, (_, holds, _) in _BOUNDS.items() if name in metadata)
    return "" if inside else _range(metadata)


def _range(metadata: Mapping) -> str:
    """All bounds of a number in words, ``at least 1 and at most 20``; empty if it has none."""
    return " and ".join(words.format(metadata[name]) for name, (*_, words) in _BOUNDS.items() if name in metadata)


def _broken_list_rule(values, kind, metadata: Mapping) -> str:
    if not isinstance(values, tuple | list):
        return "a list"
    minimum = metadata.get("min_items", 0)
    if len(values) < minimum:
        return f"a list of at least {minimum} {'entry' if minimum == 1 else 'entries'}"
    maximum = metadata.get("max_items", math.inf)
    if len(values) > maximum:
        return f"a list of at most {maximum} {'entry' if maximum == 1 else 'entries'}"
    for value in values:
        rule = _broken_rule(value, kind, metadata["item"])
        if rule:
            return f"a list in which every entry is {rule}"
    if metadata.get("unique") and len(set(values)) < len(values):
        return "a list that names each entry once"
    return ""


def is_finite(value: float) -> bool:
    """Whether a number is neither infinite nor NaN; unlike ``math.isfinite`` it takes whole numbers of any size."""
    return isinstance(value, int) or math.isfinite(value)


def shortened(value, most: int = 80) -> str:
    """A value as text for a message, cut where it is long."""
    try:
        text = str(value).encode("utf-8", "backslashreplace").decode()
    except ValueError:  # Python does not write whole numbers of thousands of digits
        return "(a number of thousands of digits)"
    return text if len(text) <= most else f"{text[:most]} ..."


def _is_number(value, kind) -> bool:
    allowed = int if kind is int else int | float
    return isinstance(value, allowed) and not isinstance(value, bool) and is_finite(value)


def section_schema(cls, description: str = "", hidden: Sequence[str] = ()) -> dict:
    """JSON Schema (2020-12) of a settings dataclass; unknown keys are errors.

    Parameters
    ----------
    cls : subclass of :class:`Settings`
    description : of the section; default: first line of the class's docstring
    hidden : fields that a run sets itself, such as ``seed``
    """
    first = (cls.__doc__ or "").strip().split("\n")[0]
    return {
        "description": description or first,
        "type": "object",
        "additionalProperties": False,
        "properties": {
            name: _field_schema(kind, metadata) | _default_keyword(cls, name, kind)
            for name, kind, metadata in described_fields(cls)
            if name not in hidden
        },
    }


def _default_keyword(cls, name: str, kind) -> dict:
    """The schema's keyword ``default``; empty for a nested dataclass, whose own fields have it."""
    default = next(default_of(one) for one in fields(cls) if one.name == name)
    return {} if is_dataclass(kind) else {"default": _plain(default)}


def _field_schema(kind, metadata: Mapping) -> dict:
    if is_dataclass(kind):
        return section_schema(kind, metadata["description"])
    origin = get_origin(kind)
    schema = {"description": metadata["description"]} if "description" in metadata else {}
    if metadata.get("choices"):
        schema["enum"] = list(metadata["choices"])
    elif kind in _TYPES:
        schema["type"] = _TYPES[kind]
    elif origin is UnionType:
        schema["type"] = [_TYPES[one] for one in get_args(kind)]
    elif origin in (tuple, list):
        schema |= {"type": "array", "items": _field_schema(get_args(kind)[0], metadata["item"])}
        schema |= {"minItems": metadata["min_items"]} if "min_items" in metadata else {}
        schema |= {"maxItems": metadata["max_items"]} if "max_items" in metadata else {}
        schema |= {"uniqueItems": True} if metadata.get("unique") else {}
    else:  # a mapping, whose schema is given by its field
        schema |= metadata["item"] or {"type": "object"}
    schema |= {"minLength": metadata["min_length"]} if "min_length" in metadata else {}
    schema |= {"maxLength": metadata["max_length"]} if "max_length" in metadata else {}
    schema |= {"pattern": rf"^(?:{metadata['pattern']})\Z"} if "pattern" in metadata else {}
    return schema | {keyword: metadata[name] for name, (keyword, _, _) in _BOUNDS.items() if name in metadata}


def with_defaults(cls, given: Mapping, hidden: Sequence[str] = (), where: str = "") -> dict:
    """All fields of a section as plain data (lists, not tuples): the given values, and defaults for the others.

    Parameters
    ----------
    cls : subclass of :class:`Settings`
    given : values by field
    hidden : fields that are left out of the result
    where : place of the section in the run's settings, for messages; empty: its usual place, ``cls.section``

    Raises
    ------
    SettingError
        A key is unknown, or a value is invalid (see :class:`Settings`).
    """
    try:
        built = _built(cls, given)
    except FieldError as error:
        raise (error.at(cls.section, where) if where else error) from None
    return {name: value for name, value in _plain(asdict(built)).items() if name not in hidden}


def restored(cls, stored: Mapping, path):
    """Settings of the class ``cls`` as stored in the model file ``path``.

    Raises
    ------
    StorageError
        They do not match this version of the library.
    """
    try:
        return _built(cls, stored)
    except SettingError as error:
        raise StorageError(
            f"{path} was written by another version of this library ({error}) Delete it and run again to recreate it."
        ) from error


def _built(cls, given: Mapping):
    known = [one.name for one in fields(cls)]
    unknown = [str(key) for key in given if key not in known]
    if unknown:
        names = ", ".join(f"`{cls.section + '.' if cls.section else ''}{key}`" for key in unknown)
        raise SettingError(f"unknown setting {names}. Known here: {', '.join(sorted(known))}.")
    return cls(**given)


def _plain(value):
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return [_plain(inner) for inner in value] if isinstance(value, tuple | list) else value


def default_of(one):
    """Default of a dataclass field."""
    return one.default if one.default is not MISSING else one.default_factory()
