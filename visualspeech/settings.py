"""Settings files: read as plain data, strictly, and merged in layers.

``python -m visualspeech.settings FILE ...`` checks files before a run, and says file, line and key of what is wrong.
"""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from pathlib import Path

import yaml

from visualspeech.errors import SettingError

MAX_BYTES = 500_000  # of a settings file; larger ones take the YAML reader minutes
MAX_VALUES = 20_000  # of a settings file and of a run's settings, every repetition of an alias counted
MAX_DEPTH = 30  # levels of settings inside settings
MAX_BITS = 1000  # of a whole number; Python does not write those of thousands of digits
MAX_TEXT = 1_000_000  # characters of a text
_TEMPLATE = "__use_yte__"


def read_yaml(path: Path) -> dict:
    """A YAML file as plain data (never code).

    Raises
    ------
    SettingError
        The file is missing, too large, not YAML, not a mapping, or gives a key twice.
    """
    return _mapping(_yaml(_text(path), path), path)


def check_overlays(paths: Iterable[str | Path]) -> None:
    """Check the files of ``--configfile`` as strictly as the project's own; Snakemake's reader passes over mistakes.

    Raises
    ------
    SettingError
        As :func:`read_yaml`, also for JSON; or a file is a template, whose code Snakemake would run.
    """
    for path in map(Path, paths):
        if _TEMPLATE in _mapping(_json_or_yaml(_text(path), path), path):
            raise SettingError(f"{path} has the key `{_TEMPLATE}`; templates are no settings files. Remove the key.")


def plain_data(settings: Mapping) -> dict:
    """A copy of settings as plain dicts, lists, texts, numbers, booleans and None.

    Raises
    ------
    SettingError
        They hold anything else, a text that cannot be written to a file, or more than a run can have.
    """
    for number, (where, value) in enumerate(_inside(settings, "", 0)):
        if number >= MAX_VALUES:
            raise SettingError(
                f"the settings hold more than {MAX_VALUES:,} values, aliases written out, the last of them at "
                f"`{where[:200]}`; give fewer."
            )
        _check_text(value, f"`{where}`")
        if isinstance(value, int) and value.bit_length() > MAX_BITS:
            raise SettingError(f"`{where}` is a number of hundreds of digits; give a smaller one.")
        if value is not None and not isinstance(value, bool | int | float | str | list | tuple | Mapping):
            raise SettingError(f"`{where}: {str(value)[:80]}` is a {type(value).__name__}; put a text in quotes.")
    return _plain(settings)


def _text(path: Path) -> str:
    try:
        if not path.is_file():
            path.stat()  # says what is wrong, if it is missing
            raise SettingError(f"cannot read {path}: it is not a file.")
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise SettingError(f"{path} has {size:,} bytes; settings files have at most {MAX_BYTES:,}.")
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise SettingError(f"cannot read {path}: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise SettingError(
            f"{path} is not YAML: byte {error.start} is not UTF-8 text. Save the file in the encoding UTF-8."
        ) from error
    except ValueError as error:  # a NUL in the path
        raise SettingError(f"cannot read {str(path)[:80]!r}: this is no possible path.") from error


def _json_or_yaml(text: str, path: Path):
    def unique(pairs: list[tuple]) -> dict:
        _check_json_keys([name for name, _ in pairs], path)
        return dict(pairs)

    try:
        return json.loads(text, object_pairs_hook=unique)  # Snakemake takes a file for JSON where it can
    except (ValueError, RecursionError):
        return _yaml(text, path)


def _yaml(text: str, path: Path):
    loader = None
    try:
        loader = yaml.SafeLoader(text)
        node = loader.get_single_node()
        if node is None:
            return None
        _check_nodes(node, path)
        return loader.construct_document(node)
    except SettingError:
        raise
    except RecursionError as error:
        raise SettingError(f"{path} is nested too deeply: settings have at most {MAX_DEPTH} levels.") from error
    except Exception as error:  # PyYAML raises errors of many kinds for values that do not fit their tags
        reason = " ".join(str(error).split())
        raise SettingError(f"{path} is not YAML: {reason[:300]}") from error
    finally:
        if loader is not None:
            loader.dispose()


def _check_nodes(root: yaml.Node, path: Path) -> None:
    for number, node in enumerate(_nodes(root, path, ())):
        if number >= MAX_VALUES:
            raise SettingError(f"{path} holds more than {MAX_VALUES:,} values, aliases written out; give fewer.")
        if isinstance(node, yaml.MappingNode):
            _check_keys(node, path)


def _nodes(node: yaml.Node, path: Path, above: Sequence[yaml.Node]) -> Iterator[yaml.Node]:
    """All nodes of a document, those of an alias wherever it stands."""
    yield node
    line = node.start_mark.line + 1
    if any(node is one for one in above):
        raise SettingError(f"{path}, line {line}: an alias contains itself; write out what is meant.")
    if len(above) > MAX_DEPTH:
        raise SettingError(f"{path}, line {line}: nested too deeply; settings have at most {MAX_DEPTH} levels.")
    if not isinstance(node, yaml.ScalarNode):
        for one in node.value:
            yield from _nodes(one[1] if isinstance(one, tuple) else one, path, (*above, node))


def _check_keys(node: yaml.MappingNode, path: Path) -> None:
    seen: dict[tuple, int] = {}
    for key, _ in node.value:
        line = key.start_mark.line + 1
        if not isinstance(key, yaml.ScalarNode):
            raise SettingError(f"{path}, line {line}: a list or mapping is no possible key; give a text.")
        name = (key.tag, key.value)
        if name in seen:
            raise SettingError(
                f"{path}: the key `{key.value[:80]}` is given twice, in line {seen[name]} and in line {line}; keep one."
            )
        seen[name] = line


def _check_json_keys(names: Sequence[str], path: Path) -> None:
    twice = next((name for number, name in enumerate(names) if name in names[:number]), None)
    if twice is not None:
        raise SettingError(f"{path}: the key `{twice[:80]}` is given twice; keep one.")


def _mapping(data, path: Path) -> dict:
    if not isinstance(data, dict):
        raise SettingError(f"{path} must hold `key: value` lines.")
    return data


def _inside(value, where: str, depth: int) -> Iterator[tuple[str, object]]:
    """A value and all values in it, each with its place in the settings."""
    yield where, value
    if depth > MAX_DEPTH:
        raise SettingError(f"`{where[:80]} ...` is nested too deeply; settings have at most {MAX_DEPTH} levels.")
    parts = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list | tuple) else ()
    for key, inner in parts:
        _check_text(key, f"a key of `{where}`" if where else "a key")
        yield from _inside(inner, f"{where}.{key}" if where else str(key), depth + 1)


def _plain(value):
    if isinstance(value, Mapping):
        return {key: _plain(inner) for key, inner in value.items()}
    return [_plain(inner) for inner in value] if isinstance(value, list | tuple) else value


def _check_text(value, what: str) -> None:
    if not isinstance(value, str):
        return
    if len(value) > MAX_TEXT:
        raise SettingError(f"{what} has {len(value):,} characters; a text has at most {MAX_TEXT:,}.")
    unfit = next((one for one in value if one < " " and one not in "\t\r\n" or "\ud800" <= one <= "\udfff"), None)
    if unfit is not None:
        raise SettingError(f"{what} holds the character U+{ord(unfit):04X}, which is no text; remove it.")


def typed(value):
    """What a value of the command line means: inside mappings and lists Snakemake hands on every value as text."""
    if isinstance(value, Mapping):
        return {key: typed(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [typed(inner) for inner in value]
    if not isinstance(value, str) or not value or len(value) > 100:
        return value
    try:
        meant = yaml.safe_load(value)
    except (yaml.YAMLError, ValueError):
        return value
    return meant if meant is None or isinstance(meant, bool | int | float) else value


def from_command_line(config: Mapping, given: Mapping) -> dict:
    """The settings of a run in which the values of ``--config`` have the types that YAML gives them.

    Parameters
    ----------
    config : of the run, ``given`` laid over the files
    given : values of the command line as Snakemake has read them; those that are no mappings and lists have their types
    """
    nested = {key: value for key, value in given.items() if isinstance(value, Mapping | list | tuple)}
    return {key: _retyped(value, nested[key]) if key in nested else value for key, value in config.items()}


def _retyped(value, given):
    """A value of a run with the types of what the command line gave, where it comes from there."""
    if isinstance(value, Mapping) and isinstance(given, Mapping):
        return {key: _retyped(inner, given[key]) if key in given else inner for key, inner in value.items()}
    return typed(given) if value == given else value


#: Keys that exclude each other: a layer that gives keys of one set drops the keys of the other set from lower layers.
ALTERNATIVES = ({"energy", "at_most"}, {"components"})


def merged(base: Mapping, over: Mapping) -> dict:
    """A copy of ``base`` updated with ``over``: mappings are merged key by key, anything else is replaced."""
    result = deepcopy(dict(base))
    for given, excluded in (ALTERNATIVES, ALTERNATIVES[::-1]):
        if given & set(over):
            result = {key: value for key, value in result.items() if key not in excluded}
    for key, value in over.items():
        below = result.get(key)
        result[key] = (
            merged(below, value) if isinstance(below, dict) and isinstance(value, Mapping) else deepcopy(value)
        )
    return result


def main(paths: Sequence[str]) -> int:
    """Check settings files; returns the exit status: 0 if all of them can be read, else 2."""
    try:
        check_overlays(paths)
    except SettingError as error:
        print(error, file=sys.stderr)
        return 2
    print(f"{len(paths)} {'file is' if len(paths) == 1 else 'files are'} well-formed; a dry run checks the keys.")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
