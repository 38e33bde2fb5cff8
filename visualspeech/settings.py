"""Settings files: plain data, read and laid over each other."""

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
        The file is missing, not YAML, or no mapping.
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


#: Two ways to say one thing: a layer that says it one way replaces the other way of the layers below.
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
