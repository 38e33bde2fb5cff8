"""Check of settings against their schema; each error is a sentence that names the setting, the rule and the fix.

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
from functools import cache
from pathlib import Path

import yaml

from visualspeech.errors import SettingError
from visualspeech.fields import FORM, is_finite, section_schema, shortened, with_defaults

PACKAGE = __name__.partition(".")[0]
_KINDS = {
    "string": "a text",
    "integer": "a whole number",
    "number": "a number",
    "boolean": "true or false",
    "array": "a list",
    "object": "lines of `key: value`",
}
MAX_MISTAKES = 50  # sentences for the mistakes of one part of the settings
MAX_WORD = 100  # characters of a word that is compared with the known ones
_MOST_DIGITS = 30  # of a number that is suggested
_BOOLEANS = " (YAML reads no, yes, on and off as false and true; put a text in quotes)"
_LIMITS = {
    "minimum": "at least {}",
    "exclusiveMinimum": "above {}",
    "maximum": "at most {}",
    "exclusiveMaximum": "below {}",
}


def load_schema(path: str | Path) -> dict:
    """A schema file as JSON Schema, with references to settings dataclasses expanded.

    An expanded section keeps its keys ``settings`` and ``hidden``, by which :func:`fill_defaults` finds its defaults.

    Raises
    ------
    SettingError
        A class that the schema names is not in this package.
    """
    return _written_out(yaml.safe_load(Path(path).read_text(encoding="utf-8")))


def fill_defaults(settings: Mapping, schema: Mapping, where: str = "") -> dict:
    """A copy of settings with all defaults filled in.

    Sections of settings dataclasses get the defaults of their fields, other keys the ``default`` of their schema where
    it has one. A section that is not given is filled as an empty one.

    Parameters
    ----------
    settings : of a run, or of a part of it that ``schema`` describes
    schema : from :func:`load_schema`, or its part for these settings
    where : place of ``settings`` in those of the run, for messages

    Raises
    ------
    SettingError
        Values of a section do not fit each other.
    """
    return _filled(settings, schema, schema, where)


def _written_out(node):
    """A schema node with every reference to a settings dataclass replaced by the schema derived from it."""
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
    """The class of this package named ``module:Class``.

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


def _filled(given, schema: Mapping, root: Mapping, where: str):
    while "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        schema = {**root["$defs"][name], **{key: value for key, value in schema.items() if key != "$ref"}}
    if isinstance(given, list) and isinstance(schema.get("items"), Mapping):
        return [_filled(one, schema["items"], root, _below(where, number)) for number, one in enumerate(given)]
    if not isinstance(given, Mapping):
        return deepcopy(given)
    known = schema.get("properties", {})
    others = schema.get("additionalProperties")
    others = others if isinstance(others, Mapping) else {}
    filled = {key: _filled(value, known.get(key, others), root, _below(where, key)) for key, value in given.items()}
    for key, inner in known.items():
        if key in filled:
            continue
        if "default" in inner:
            filled[key] = _filled(inner["default"], inner, root, _below(where, key))
        elif value := _filled({}, inner, root, _below(where, key)):
            filled[key] = value
    if _is_section(schema) and schema.get("defaults", True):
        cls, hidden = settings_class(schema["settings"]), schema.get("hidden", ())
        fields = section_schema(cls, hidden=hidden)["properties"]
        own = {key: value for key, value in filled.items() if key in fields}
        filled |= with_defaults(cls, own, hidden, where)
    # Keys are in the order of the schema, so that a job does not run again when only their order in the files changes.
    return {key: filled[key] for key in dict.fromkeys((*known, *filled)) if key in filled}


def _below(where: str, key) -> str:
    return f"{where}.{key}" if where else str(key)


def check(settings: Mapping, schema: Mapping, where: str = "") -> None:
    """Check settings against a JSON schema; see :func:`mistakes`.

    Raises
    ------
    SettingError
        They do not fit; a line for each mistake.
    """
    found = mistakes(settings, schema, where)
    if found:
        raise SettingError("\n".join(found))


def mistakes(settings: Mapping, schema: Mapping, where: str = "") -> list[str]:
    """Errors of settings by a JSON schema; 16.0 does not count as a whole number, nor infinity and NaN as numbers.

    Parameters
    ----------
    settings, schema : plain data
    where : place of ``settings`` in those of the run, for messages

    Returns
    -------
    One sentence per error, in the order of the keys' paths; after :data:`MAX_MISTAKES` the number of the others.
    """
    problems = sorted(_validator()(schema).iter_errors(settings), key=lambda error: list(map(str, error.absolute_path)))
    found = [sentence for problem in problems[:MAX_MISTAKES] for sentence in _sentences(problem, where)]
    more = len(found[MAX_MISTAKES:]) + len(problems[MAX_MISTAKES:])
    further = [f"{more} further mistakes in `{where}`." if where else f"{more} further mistakes."] if more else []
    return [*dict.fromkeys(found[:MAX_MISTAKES]), *further]


@cache
def _validator():
    from jsonschema import Draft202012Validator, validators

    kinds = Draft202012Validator.TYPE_CHECKER.redefine_many(
        {"integer": lambda _, value: _is_number(value, int), "number": lambda _, value: _is_number(value, int | float)}
    )
    return validators.extend(Draft202012Validator, type_checker=kinds)


def did_you_mean(word: str, known: Sequence[str]) -> str:
    """A question with the known word nearest to a mistyped one; empty if none is similar."""
    close = difflib.get_close_matches(word, known, n=1) if len(word) <= MAX_WORD else []
    return f" Did you mean `{close[0]}`?" if close else ""


def unknown(key: str, word: str, known: Sequence[str], what: str = "") -> str:
    """A sentence that says that a word, given for a key, is not among the known ones; ``what`` it is no one of."""
    said = f"is no {what}" if what else "is not known"
    listed = f" Known: {', '.join(map(str, known))}." if known else " There is none."
    return f"`{key}: {shortened(word)}` {said}.{did_you_mean(str(word), list(map(str, known)))}{listed}"


def _is_number(value, kind) -> bool:
    return isinstance(value, kind) and not isinstance(value, bool) and is_finite(value)


def _sentences(problem, above: str) -> list[str]:
    """The sentences for one error of the validator: one for each unknown or missing key, else a single one."""
    where = ".".join(str(part) for part in ([above] if above else []) + list(problem.absolute_path))
    if problem.validator == "additionalProperties":
        known = sorted(problem.schema.get("properties", {}))
        return [_unknown_key(where, key, known) for key in problem.instance if key not in known]
    if problem.validator == "required":
        keys = problem.schema.get("properties", {})
        place = f"`{where}`" if where else "the configuration"
        missing = [key for key in problem.validator_value if key not in problem.instance]
        return [f"{place} lacks `{key}`. {keys.get(key, {}).get('description', '')}".rstrip() for key in missing]
    description = problem.schema.get("description", "")
    if "propertyNames" in problem.schema_path:
        quotes = _BOOLEANS if isinstance(problem.instance, bool) else ""
        return [f"`{where}`: {_shown(problem.instance)} is no possible name{quotes}. {description}".rstrip()]
    given = "is empty and" if problem.instance is None else ""
    name = f"`{where}`" if problem.instance is None else f"`{where}: {_shown(problem.instance)}`"
    said = " ".join(filter(None, (name, given, _rule(problem))))
    question = ""
    if problem.validator == "enum" and isinstance(problem.instance, str):
        question = did_you_mean(problem.instance, list(map(str, problem.validator_value)))
    return [f"{said}{':' if said.endswith(FORM) and description else '.'}{question} {description}".rstrip()]


def _unknown_key(where: str, key, known: Sequence[str]) -> str:
    name = _shown(key) if isinstance(key, bool) else shortened(key)
    quotes = _BOOLEANS if isinstance(key, bool) else ""
    listed = f" Known here: {', '.join(known)}." if known else ""
    return f"unknown setting `{_below(where, name)}`{quotes}.{did_you_mean(name, known)}{listed}"


def _rule(problem) -> str:
    """The broken rule as the predicate of a sentence about the value."""
    rule, limit, value = problem.validator, problem.validator_value, problem.instance
    if rule in _LIMITS:
        return f"must be {_range(problem.schema)}"
    if rule == "type":
        return f"must be {_of_type([limit] if isinstance(limit, str) else limit, value, problem.schema)}"
    if rule == "enum":
        quotes = _BOOLEANS if isinstance(value, bool) and not any(isinstance(one, bool) for one in limit) else ""
        listed = f"one of {', '.join(map(str, limit))}" if limit else "left out: there is none to choose from"
        return f"must be {listed}{quotes}"
    if rule == "oneOf":
        ways = [" and ".join(f"`{key}`" for key in way.get("required", ())) for way in limit]
        return f"must have either {' or '.join(ways)}" if all(ways) else "does not fit"
    if rule == "dependentRequired":
        key = next(key for key, others in limit.items() if key in value and not set(others) <= set(value))
        return f"has `{key}`, which goes with {', '.join(f'`{other}`' for other in limit[key])} alone"
    if rule == "uniqueItems":
        twice = [item for number, item in enumerate(value) if item in value[:number]]
        return f"names {_shown(twice[0])} more than once; give each once"
    if rule in ("minProperties", "maxProperties"):
        return f"must have at {'least' if rule == 'minProperties' else 'most'} {limit} keys"
    if rule in ("minItems", "maxItems"):
        most = "at least" if rule == "minItems" else "at most"
        return f"must have {most} {limit} {'entry' if limit == 1 else 'entries'}"
    if rule == "minLength":
        return "must not be empty"
    if rule == "maxLength":
        return f"must have at most {limit} characters"
    return f"must be {FORM}" if rule == "pattern" else "does not fit"


def _of_type(kinds: Sequence[str], value, schema: Mapping) -> str:
    """The allowed types of a value, with its bounds and how to write what was probably meant."""
    words = [_KINDS[kind] for kind in kinds if kind != "null"]
    listed = " or ".join(filter(None, (", ".join(words[:-1]), words[-1])))
    bounds = _range(schema) if {"integer", "number"} & set(kinds) else ""
    ways = [_suggestion(kind, value) for kind in sorted(kinds, key="string".__ne__)]
    return f"{listed}{', ' * bool(bounds)}{bounds}{next(filter(None, ways), '')}"


def _range(schema: Mapping) -> str:
    """All bounds of a number in words, ``at least 1 and at most 20``; empty if it has none."""
    return " and ".join(words.format(schema[key]) for key, words in _LIMITS.items() if key in schema)


def _suggestion(kind: str, value) -> str:
    """How to write what was probably meant, where YAML reads text as a number or a number as text."""
    if kind == "string" and isinstance(value, bool):
        return _BOOLEANS
    if kind == "string" and isinstance(value, int | float):
        return " (put it in quotes)"
    if kind == "array" and isinstance(value, str | int | float) and not isinstance(value, bool):
        return f"; write [{_shown(value)}]"
    if kind in ("integer", "number") and isinstance(value, str | float):
        try:
            meant = Decimal(str(value))
        except InvalidOperation:
            return ""
        short = len(meant.as_tuple().digits) <= _MOST_DIGITS and abs(meant.adjusted()) <= _MOST_DIGITS
        if meant.is_finite() and short and (kind == "number" or meant == meant.to_integral_value()):
            return f"; write {int(meant) if meant == int(meant) else format(meant, 'f')}"
    return ""


def _shown(value) -> str:
    """A value as YAML writes it, on one line; a long one is cut."""
    if isinstance(value, int) and not isinstance(value, bool):
        return shortened(value)
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=math.inf, sort_keys=False)
    text = text.strip().removesuffix("...").strip()
    return text if len(text) <= 80 else text[:80] + " ..."
