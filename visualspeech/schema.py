"""Settings against their schema: every mistake as a sentence that names the setting, the rule and the way out."""

import difflib
import math
from collections.abc import Mapping, Sequence
from decimal import Decimal, InvalidOperation

import yaml

from visualspeech.errors import SettingError

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
    "maximum": "at most {}",
    "exclusiveMinimum": "above {}",
    "exclusiveMaximum": "below {}",
}


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
        raise SettingError("\n".join(_sentence(problem) for problem in problems))


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
        return f"must be {_LIMITS[rule].format(limit)}"
    if rule == "type":
        return f"must be {_KINDS[limit]}{_way_out(limit, value)}"
    if rule == "enum":
        return f"must be one of {', '.join(map(str, limit))}"
    if rule == "uniqueItems":
        twice = [item for number, item in enumerate(value) if item in value[:number]]
        return f"names {_shown(twice[0])} more than once; give each once"
    if rule in ("minItems", "maxItems"):
        most = "at least" if rule == "minItems" else "at most"
        return f"must have {most} {limit} {'entry' if limit == 1 else 'entries'}"
    if rule == "minLength":
        return "must not be empty"
    return "does not fit"


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
