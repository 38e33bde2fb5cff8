"""Settings against their schema: every mistake as a sentence that names the setting, the rule and the way out.

The schema is a YAML file. An object ``{settings: "visualspeech.face.head:PoseSettings", hidden: [seed]}`` in it stands
for the schema of that dataclass (:func:`visualspeech.fields.section_schema`), so that defaults, bounds and descriptions
are written once, in the library. ``description`` replaces the first line of the class's docstring, and ``properties``
adds keys that are no fields of the class; with ``defaults: false`` keys that are not given stay so.
"""

import difflib
import importlib
import math
from collections.abc import Mapping, Sequence
from copy import deepcopy
from decimal import Decimal, InvalidOperation
from pathlib import Path

import yaml

from visualspeech.errors import SettingError
from visualspeech.fields import section_schema, with_defaults

PACKAGE = __name__.partition(".")[0]
_KINDS = {
    "string": "a text",
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "array": "a list",
    "object": "lines of `key: value`",
}
_LIMITS = {
    "minimum": "at least {}",
    "exclusiveMinimum": "above {}",
    "maximum": "at most {}",
    "exclusiveMaximum": "below {}",
}


def load_schema(path: str | Path) -> dict:
    """A schema file as JSON Schema, with the sections that stand for settings dataclasses written out.

    Such a section keeps its keys ``settings`` and ``hidden``, from which :func:`fill_defaults` knows its defaults.

    Raises
    ------
    SettingError
        A class that the schema names is not in this package.
    """
    return _written_out(yaml.safe_load(Path(path).read_text(encoding="utf-8")))


def fill_defaults(settings: Mapping, schema: Mapping) -> dict:
    """A copy of settings with all defaults filled in; neither argument is changed.

    Sections of settings dataclasses get the defaults of their fields, other keys the ``default`` of their schema where
    it has one. A section that is not given is filled as an empty one.

    Parameters
    ----------
    settings : of a run, or of a part of it that ``schema`` describes
    schema : from :func:`load_schema`, or its part for these settings

    Raises
    ------
    SettingError
        Values of a section do not fit each other.
    """
    return _filled(settings, schema, schema)


def _written_out(node):
    """A schema node with every reference to a settings dataclass replaced by the derived schema."""
    if isinstance(node, list):
        return [_written_out(inner) for inner in node]
    if not isinstance(node, Mapping):
        return node
    inner = {key: _written_out(value) for key, value in node.items()}
    if not _is_section(node):
        return inner
    derived = section_schema(settings_class(node["settings"]), node.get("description", ""), node.get("hidden", ()))
    return {**derived, **inner, "properties": derived["properties"] | inner.get("properties", {})}


def _is_section(node: Mapping) -> bool:
    return isinstance(node.get("settings"), str)


def settings_class(name: str):
    """The class of this package that ``module:Class`` names.

    Raises
    ------
    SettingError
        There is none.
    """
    module, _, attribute = name.partition(":")
    if not module.startswith(f"{PACKAGE}.") or not attribute.isidentifier():
        raise SettingError(f"the schema names {name!r}, which is no class of {PACKAGE}; write {PACKAGE}.module:Class.")
    try:
        return getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise SettingError(f"the schema names {name!r}, which does not exist ({error}).") from error


def _filled(given, schema: Mapping, root: Mapping):
    while "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        schema = {**root["$defs"][name], **{key: value for key, value in schema.items() if key != "$ref"}}
    if isinstance(given, list) and isinstance(schema.get("items"), Mapping):
        return [_filled(one, schema["items"], root) for one in given]
    if not isinstance(given, Mapping):
        return deepcopy(given)
    known = schema.get("properties", {})
    others = schema.get("additionalProperties")
    others = others if isinstance(others, Mapping) else {}
    filled = {key: _filled(value, known.get(key, others), root) for key, value in given.items()}
    for key, inner in known.items():
        if key in filled:
            continue
        if "default" in inner:
            filled[key] = _filled(inner["default"], inner, root)
        elif value := _filled({}, inner, root):
            filled[key] = value
    if _is_section(schema) and schema.get("defaults", True):
        cls, hidden = settings_class(schema["settings"]), schema.get("hidden", ())
        fields = section_schema(cls, hidden=hidden)["properties"]
        own = {key: value for key, value in filled.items() if key in fields}
        filled |= with_defaults(cls, own, hidden)
    return filled


def check(settings: Mapping, schema: Mapping) -> None:
    """Hold settings against a JSON schema, in which a whole number is no 16.0 and no number is infinite or NaN.

    Raises
    ------
    SettingError
        They do not fit; a line for each mistake.
    """
    from jsonschema import Draft202012Validator, validators

    kinds = Draft202012Validator.TYPE_CHECKER.redefine_many(
        {"integer": lambda _, value: _is_number(value, int), "number": lambda _, value: _is_number(value, int | float)}
    )
    checker = validators.extend(Draft202012Validator, type_checker=kinds)(schema)
    problems = sorted(checker.iter_errors(settings), key=lambda error: list(map(str, error.path)))
    if problems:
        # One sentence names all keys that an object lacks; there is a problem for each.
        raise SettingError("\n".join(dict.fromkeys(map(_sentence, problems))))


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """A question that names the known word nearest to a mistyped one; empty where none is near."""
    close = difflib.get_close_matches(word, known, n=1)
    return f" Did you mean `{close[0]}`?" if close else ""


def _is_number(value, kind) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool) and math.isfinite(value)


def _sentence(problem) -> str:
    where = ".".join(str(part) for part in problem.absolute_path)
    if problem.validator == "additionalProperties":
        known = sorted(problem.schema.get("properties", {}))
        extra = [str(key) for key in problem.instance if key not in known]
        names = ", ".join(f"`{where + '.' if where else ''}{key}`" for key in extra)
        questions = "".join(did_you_mean(key, known) for key in extra)
        return f"unknown setting {names}.{questions} Known here: {', '.join(known)}."
    if problem.validator == "required":
        missing = [key for key in problem.validator_value if key not in problem.instance]
        return f"`{where or 'the configuration'}` lacks {', '.join(f'`{key}`' for key in missing)}."
    given = "is empty and" if problem.instance is None else ""
    name = f"`{where}`" if problem.instance is None else f"`{where}: {_shown(problem.instance)}`"
    said = " ".join(filter(None, (name, given, _rule(problem))))
    return f"{said}. {problem.schema.get('description', '')}".rstrip()


def _rule(problem) -> str:
    """What a value must be, said of it; the schema's own description follows."""
    rule, limit, value = problem.validator, problem.validator_value, problem.instance
    if rule in _LIMITS:
        return f"must be {_range(problem.schema)}"
    if rule == "type":
        kinds = [kind for kind in ([limit] if isinstance(limit, str) else limit) if kind != "null"]
        bounds = _range(problem.schema) if {"integer", "number"} & set(kinds) else ""
        ways = _way_out(kinds[0], value) if len(kinds) == 1 else ""
        return f"must be {' or '.join(_KINDS[kind] for kind in kinds)}{', ' * bool(bounds)}{bounds}{ways}"
    if rule == "enum":
        return f"must be one of {', '.join(map(str, limit))}"
    if rule == "oneOf":
        ways = [" and ".join(f"`{key}`" for key in way.get("required", ())) for way in limit]
        return f"must have either {' or '.join(ways)}" if all(ways) else "does not fit"
    if rule == "dependentRequired":
        key = next(key for key, others in limit.items() if key in value and not set(others) <= set(value))
        return f"has `{key}`, which goes with {', '.join(f'`{other}`' for other in limit[key])} alone"
    if rule == "uniqueItems":
        twice = [item for number, item in enumerate(value) if item in value[:number]]
        return f"names {_shown(twice[0])} more than once; give each once"
    if rule in ("minItems", "maxItems"):
        most = "at least" if rule == "minItems" else "at most"
        return f"must have {most} {limit} {'entry' if limit == 1 else 'entries'}"
    if rule == "minLength":
        return "must not be empty"
    return "does not fit"


def _range(schema: Mapping) -> str:
    """All limits of a number: ``at least 1 and at most 20``; empty where it has none."""
    return " and ".join(words.format(schema[key]) for key, words in _LIMITS.items() if key in schema)


def _way_out(kind: str, value) -> str:
    """How to write what was surely meant; YAML has its own ideas of what is a number and what is a text."""
    if kind == "string" and isinstance(value, bool):
        return " (YAML reads no, yes, on and off as false and true; put a text in quotes)"
    if kind == "string" and isinstance(value, int | float):
        return " (put it in quotes)"
    if kind == "array" and isinstance(value, str | int | float):
        return f"; write [{_shown(value)}]"
    if kind in ("integer", "number") and isinstance(value, str | float):
        try:
            meant = Decimal(str(value))
        except InvalidOperation:
            return ""
        if meant.is_finite() and (kind == "number" or meant == meant.to_integral_value()):
            return f"; write {int(meant) if meant == int(meant) else format(meant, 'f')}"
    return ""


def _shown(value) -> str:
    """A value as YAML writes it, on one line."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=math.inf, sort_keys=False)
    text = text.strip().removesuffix("...").strip()
    return text if len(text) <= 80 else text[:80] + " ..."
