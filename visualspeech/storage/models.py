"""Models: safetensors files, with their settings as JSON metadata."""

import json
from collections.abc import Collection, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from visualspeech.errors import StorageError
from visualspeech.storage.files import replacing


def write_model(path: str | Path, tensors: Mapping[str, np.ndarray], settings: Mapping) -> None:
    """Write a model as safetensors: named arrays, and its settings as JSON metadata."""
    from safetensors.numpy import save

    # np.ascontiguousarray would turn a scalar into a vector.
    arrays = {name: np.asarray(values, order="C") for name, values in sorted(tensors.items())}
    content = save(arrays, metadata={"settings": json.dumps(settings, sort_keys=True)})
    # safetensors would write a file that only its owner may read.
    with replacing(path) as temporary:
        temporary.write_bytes(content)


@contextmanager
def _opened_model(path: str | Path):
    """An opened model file; errors while it is read become a :class:`StorageError`."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(str(path), framework="numpy") as file:
            yield file
    except (OSError, SafetensorError, KeyError, ValueError) as error:
        raise StorageError(
            f"{path} is not a model of this project ({error!r}). Give a .safetensors file that a run has written."
        ) from error


def read_model(path: str | Path) -> tuple[dict[str, np.ndarray], dict]:
    """Read what :func:`write_model` wrote: (arrays by name, settings).

    Raises
    ------
    StorageError
        The file is missing, not safetensors, or holds no settings.
    """
    with _opened_model(path) as file:
        tensors = {name: file.get_tensor(name) for name in file.keys()}
        return tensors, json.loads((file.metadata() or {})["settings"])


def read_shapes(path: str | Path) -> dict[str, tuple[int, ...]]:
    """Shapes of a model's arrays by name, from the header of the file; raises as :func:`read_model`."""
    with _opened_model(path) as file:
        return {name: tuple(file.get_slice(name).get_shape()) for name in file.keys()}


def read_model_settings(path: str | Path) -> dict:
    """The settings that :func:`write_model` wrote, without reading the arrays; raises as :func:`read_model`."""
    with _opened_model(path) as file:
        return json.loads((file.metadata() or {})["settings"])


def read_model_of(
    path: str | Path, what: str, kinds: Collection[str | None], arrays: Collection[str] = (), family: str = ""
) -> tuple[dict[str, np.ndarray], dict]:
    """Read a model as :func:`read_model` does and check its kind.

    Parameters
    ----------
    what : name of the expected kind in messages
    kinds : allowed values of ``kind`` in its settings; None stands for settings without a kind
    arrays : names of arrays that it must hold
    family : required family of models; empty for any

    Raises
    ------
    StorageError
        The file is missing, not a model, or a model of another kind or family.
    """
    tensors, settings = read_model(path)
    other = settings.get("kind") not in kinds or (family and settings.get("family") != family)
    if other or not set(arrays) <= set(tensors):
        raise StorageError(f"{path} holds no {what}. Give the file that a run has written for it.")
    return tensors, settings


def part_of(tensors: Mapping[str, np.ndarray], part: str) -> dict[str, np.ndarray]:
    """The arrays whose names begin with ``part.``, by the rest of their names."""
    return {name.removeprefix(f"{part}."): values for name, values in tensors.items() if name.startswith(f"{part}.")}
