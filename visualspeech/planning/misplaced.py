"""Keys at the top of a run's settings that belong elsewhere: what was probably meant, and how to write it.

A run's settings name systems, codings and corpora, whose keys lie in files of their own. Someone who wants another
frame rate writes ``rate: 50`` at first, or ``features: {rate: 50}``.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import yaml

#: Levels below a system, a coding or the run that a key is looked for in.
MOST_LEVELS = 4
#: What is often wanted of a frame rate.
TWO_RATES = " For two frame rates side by side, lay config/two_rates.yaml over a corpus."


def misplaced(config: Mapping, schemas: Mapping[str, Mapping], folder: Path) -> dict[str, str]:
    """Unknown keys of a run that are known elsewhere: key -> sentence that says where, and how to write it.

    Parameters
    ----------
    config : settings of the run as given, plain data
    schemas : of ``run``, ``system``, ``coding`` and ``corpus``
    folder : the repository's ``config`` folder
    """
    unknown = [key for key in config if isinstance(key, str) and key not in schemas["run"]["properties"]]
    found = {key: _said(key, config[key], config, schemas, folder) for key in unknown}
    return {key: said for key, said in found.items() if said}


def override_mistakes(override, schemas: Mapping[str, Mapping], config: Mapping, folder: Path) -> dict[str, str]:
    """As :func:`misplaced`, of keys of ``override`` beside ``systems`` and ``codings``."""
    if not isinstance(override, Mapping):
        return {}
    found = {
        key: _said(key, value, config, schemas, folder, "override.")
        for key, value in override.items()
        if isinstance(key, str) and key not in ("systems", "codings")
    }
    return {key: said for key, said in found.items() if said}


def _said(key: str, value, config: Mapping, schemas: Mapping, folder: Path, above: str = "") -> str:
    name = f"`{above}{key}`"
    for kind, what in (("systems", "a system"), ("codings", "a visual coding")):
        if key in _names(folder / kind) or (kind == "systems" and key in _selected(config)):
            if isinstance(value, Mapping) and value:
                return f"{name} is {what}, not a setting. {_write(kind, key, value)}"
            return f"{name} is {what}, not a setting. Select it with `systems`, change it with `override`."
    if key in _names(folder / "corpora"):
        return f"{name} is a corpus, not a setting. Select it with `corpora: {key}`; change it in a file of your own."
    system = next(iter(_selected(config)), "<system>")
    places = (
        ("systems", system, "system", "systems"),
        ("codings", _coding(system, folder), "coding", "visual codings"),
    )
    for kind, owner, schema, owners in places:
        for path in _paths(key, schemas[schema]):
            where = ".".join((f"override.{kind}.{owner}", *path))
            said = f"{name} is a setting of {owners}, `{where}`. {_write(kind, owner, _nested(path, value))}"
            return said + (TWO_RATES if path == ("rate",) else "")
    for path in _paths(key, schemas["run"]):
        if len(path) > 1 and not above:
            meant = _nested(path, value)
            return f"{name} is a setting of the run, `{'.'.join(path)}`. Write {_flow(meant)}{_typed(meant)}"
    if key in schemas["corpus"]["properties"]:
        return (
            f"{name} is a setting of a corpus. Write it in the corpus, for example corpora: "
            f"{_shown([{'name': 'mine', 'adapter': 'folder', key: value}])}."
        )
    # A section of an earlier version, or of another program, that holds keys of a system.
    if isinstance(value, Mapping) and value:
        paths = {inner: next(_paths(str(inner), schemas["system"]), None) for inner in value}
        if all(paths.values()):
            meant: dict = {}
            for inner, path in paths.items():
                _insert(meant, path, value[inner])
            listed = ", ".join(f"`{inner}`" for inner in value)
            said = f"there is no section {name}; {listed} belong{'s' * (len(value) == 1)} to systems."
            return f"{said} {_write('systems', system, meant)}{TWO_RATES if 'rate' in meant else ''}"
    return ""


def _write(kind: str, owner: str, value: Mapping) -> str:
    meant = {"override": {kind: {owner: value}}}
    return f"Write {_flow(meant)}{_typed(meant)}"


def _flow(meant: Mapping) -> str:
    return f"`{_shown(meant)[1:-1]}` in a file"


def _typed(meant: Mapping) -> str:
    """The same as an argument of the command line."""
    ((key, value),) = meant.items()
    shown = _shown(value).replace("'", '"')
    return f", or --config {key}='{shown}' on the command line."


def _names(folder: Path) -> set[str]:
    return {path.stem for path in folder.glob("*.yaml")}


def _selected(config: Mapping) -> list[str]:
    """Names of the selected systems, as far as they are given by name."""
    given = config.get("systems")
    listed = given if isinstance(given, list | tuple) else [given]
    named = [one.get("name") if isinstance(one, Mapping) else one for one in listed]
    return [Path(one).stem if one.endswith((".yaml", ".yml")) else one for one in named if isinstance(one, str)]


def _coding(system: str, folder: Path) -> str:
    """Name of the coding that a shipped system predicts."""
    path = folder / "systems" / f"{system}.yaml"
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError):
        return "<coding>"
    coding = found.get("coding", "<coding>") if isinstance(found, Mapping) else "<coding>"
    return coding if isinstance(coding, str) else "<coding>"


def _paths(key: str, schema: Mapping) -> Iterator[tuple[str, ...]]:
    """Places of a key below a schema's object, the highest first."""
    level: list[tuple[tuple[str, ...], Mapping]] = [((), schema)]
    for _ in range(MOST_LEVELS):
        below = []
        for path, node in level:
            for name, inner in node.get("properties", {}).items():
                if name == key and name != "name":
                    yield (*path, name)
                below.append(((*path, name), inner))
        level = below


def _nested(path: Sequence[str], value) -> dict:
    for name in reversed(path):
        value = {name: value}
    return value


def _insert(into: dict, path: Sequence[str], value) -> None:
    for name in path[:-1]:
        into = into.setdefault(name, {})
    into[path[-1]] = value


def _shown(value) -> str:
    """A value as YAML writes it, on one line; a long one is cut."""
    text = yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=math.inf, sort_keys=False)
    text = text.strip().removesuffix("...").strip()
    return text if len(text) <= 300 else text[:300] + " ..."
