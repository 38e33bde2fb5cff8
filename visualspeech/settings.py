"""Settings: read, layered, and checked against the schema before any job runs.

A run has three layers, the later over the earlier: the experiment's file (the numbers of one paper), ``config.yaml``,
and what the command line gives (``--configfile``, ``--config``). The corpus is named, or given as a file or in place.
"""

import os
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from pathlib import Path

import yaml

from visualspeech.errors import SettingError
from visualspeech.naming import NetworkName, parse_name
from visualspeech.schema import check, did_you_mean, fill_defaults, load_schema


def read_yaml(path: Path) -> dict:
    """A YAML file as plain data (never code).

    Raises
    ------
    SettingError
        The file is missing, no YAML, or no mapping.
    """
    try:
        data = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingError(f"cannot read {path}: {error.strerror}.") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SettingError(f"{path} is not YAML: {error}") from error
    if not isinstance(data, dict):
        raise SettingError(f"{path} must hold `key: value` lines.")
    return data


#: Two ways to say one thing: whoever says it one way does not mean the other below it any more.
ALTERNATIVES = ({"energy", "at_most"}, {"components"})


def merged(base: Mapping, over: Mapping) -> dict:
    """``over`` laid over ``base``: mappings merge key by key, anything else is replaced. Neither is changed."""
    result = deepcopy(dict(base))
    for one, other in (ALTERNATIVES, ALTERNATIVES[::-1]):
        if one & set(over):
            result = {key: value for key, value in result.items() if key not in other}
    for key, value in over.items():
        below = result.get(key)
        result[key] = (
            merged(below, value) if isinstance(below, dict) and isinstance(value, Mapping) else deepcopy(value)
        )
    return result


def resolve(config: Mapping, folder: Path) -> dict:
    """All settings of a run, defaults filled in, from what the user gave; ``folder``: the repository's ``config``.

    Raises
    ------
    SettingError
        A key is unknown or mistyped, a value is of the wrong kind, or a named file does not exist.
    """
    experiment = config.get("experiment", "fan2015")
    layers = read_yaml(_named(experiment, "experiment", folder / "experiments"))
    settings = merged(layers, config)
    settings["corpus"] = _corpus(config.get("corpus"), folder / "corpora")
    schema = load_schema(folder.parent / "workflow" / "schemas" / "config.schema.yaml")
    check(settings, schema)
    settings = fill_defaults(settings, schema)
    _check_together(settings)
    return settings


def _named(name, key: str, folder: Path) -> Path:
    known = sorted(path.stem for path in folder.glob("*.yaml"))
    if isinstance(name, str) and name in known:
        return folder / f"{name}.yaml"
    if isinstance(name, str) and name.endswith((".yaml", ".yml")) and key == "corpus":
        return Path(name)
    raise SettingError(f"`{key}: {name}` is not known. Known: {', '.join(known)}." + did_you_mean(str(name), known))


def _corpus(given, folder: Path) -> dict:
    if isinstance(given, Mapping):
        return dict(given)
    path = _named(given, "corpus", folder)
    corpus = read_yaml(path)
    # The file may be a whole overlay (`corpus:` on top) or the corpus alone.
    corpus = corpus["corpus"] if isinstance(corpus.get("corpus"), dict) else corpus
    root = corpus.get("root")
    if isinstance(root, str) and root and not os.path.isabs(os.path.expanduser(root)) and path.parent != folder:
        corpus["root"] = str(path.parent / root)
    return corpus


def _check_together(settings: dict) -> None:
    """What no schema can say: settings that must fit each other."""
    shares = settings["split"]
    if abs(sum(shares.values()) - 1) > 1e-6:
        raise SettingError(f"`split`: the shares must sum to 1, they sum to {sum(shares.values()):g}.")
    networks = settings["networks"]
    for cell in network_cells(settings):
        key = f"networks.richer: {cell.letters}-{cell.nodes}" if cell.rich else f"networks.nodes: {cell.nodes}"
        if networks.get("b_nodes") == "layer" and "B" in cell.letters and cell.nodes % 2:
            raise SettingError(
                f"`{key}` is odd; with `networks.b_nodes: layer` the two directions of a B layer share its nodes. "
                "Give an even number."
            )
    shown = settings["videos"]["model"]
    if shown not in model_names(settings):
        raise SettingError(f"`videos.model: {shown}` is not trained. Trained here: {', '.join(model_names(settings))}.")


def network_seeds(settings: Mapping) -> list[int]:
    """Seeds that every network is trained with; the first one goes without saying in its name."""
    return settings["networks"].get("seeds") or [settings["seed"]]


def network_cells(settings: Mapping) -> list[NetworkName]:
    """The networks of a run but for their seeds: one a stack and width, then those of richer labels."""
    networks = settings["networks"]
    plain = [NetworkName(stack, nodes) for stack in networks["stacks"] for nodes in networks["nodes"]]
    return plain + [replace(parse_name(name), rich=True) for name in networks.get("richer", [])]


def model_names(settings: Mapping) -> list[str]:
    """Names of the networks of a run: one a stack and width (``FBB-128``), those of richer labels, further seeds."""
    _, *further = network_seeds(settings)
    return [str(replace(cell, seed=seed)) for seed in [None, *further] for cell in network_cells(settings)]
