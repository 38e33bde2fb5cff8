"""Settings files: read as plain data and merged in layers."""

from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path

import yaml

from visualspeech.errors import SettingError


def read_yaml(path: Path) -> dict:
    """A YAML file as plain data (never code).

    Raises
    ------
    SettingError
        The file is missing, not YAML, or not a mapping.
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
