"""Models: safetensors files, with their settings as JSON metadata and a digest of both."""

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, plain_reason
from visualspeech.storage.files import replacing
from visualspeech.storage.layouts import FileLayout, parse_plain

#: The one key of the metadata: with several, the order in the file would differ from process to process.
_KEY = "visualspeech"


def write_model(path: str | Path, tensors: Mapping[str, np.ndarray], settings: Mapping) -> None:
    """Write a model as safetensors: named arrays, and its settings as JSON metadata, with digests of both."""
    from safetensors.numpy import save

    # np.ascontiguousarray would turn a scalar into a vector.
    arrays = {name: np.asarray(values, order="C") for name, values in sorted(tensors.items())}
    shapes = {name: values.shape for name, values in arrays.items()}
    content = {"settings": json.dumps(settings, sort_keys=True), "arrays": _digest_of(arrays)}
    text = json.dumps({**content, "header": _header_digest(content, shapes)}, sort_keys=True)
    data = save(arrays, metadata={_KEY: text})
    # safetensors would write a file that only its owner may read.
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def read_model(path: str | Path) -> tuple[dict[str, np.ndarray], dict]:
    """Read what :func:`write_model` wrote: (arrays by name, settings).

    Numbers in the settings that are not finite are read as None.

    Raises
    ------
    StorageError
        The file is missing, not safetensors, not written by :func:`write_model`, or damaged.
    """
    with _opened_model(path) as (file, settings, digest):
        tensors = {name: file.get_tensor(name) for name in file.keys()}
        if _digest_of(tensors) != digest:
            raise DamagedFile(path, "its arrays are damaged")
        return tensors, settings


def read_shapes(path: str | Path) -> dict[str, tuple[int, ...]]:
    """Shapes of a model's arrays by name, from the header of the file; raises as :func:`read_model`."""
    with _opened_model(path) as (file, _, _):
        return _shapes(file)


def read_model_settings(path: str | Path) -> dict:
    """The settings that :func:`write_model` wrote, without reading the arrays; raises as :func:`read_model`."""
    with _opened_model(path) as (_, settings, _):
        return settings


def read_model_of(
    path: str | Path, what: str, kinds: Collection[str | None], layout: FileLayout | None = None, family: str = ""
) -> tuple[dict[str, np.ndarray], dict]:
    """Read a model as :func:`read_model` does and check that it is what it should be.

    Parameters
    ----------
    what : name of the expected kind in messages
    kinds : allowed values of ``kind`` in its settings; None stands for settings without a kind
    layout : of its arrays and settings, without ``kind`` and ``family``; None: any
    family : required family of models; empty for any

    Raises
    ------
    StorageError
        The file is missing, not a model, a model of another kind or family, or not of this layout.
    """
    tensors, settings = read_model(path)
    check_model(tensors, settings, path, what, kinds, layout, family)
    return tensors, settings


def check_model(
    tensors: Mapping[str, np.ndarray],
    settings: Mapping,
    path: str | Path,
    what: str,
    kinds: Collection[str | None],
    layout: FileLayout | None = None,
    family: str = "",
) -> None:
    """Check that a model is what it should be; parameters and errors as of :func:`read_model_of`.

    Parameters
    ----------
    tensors, settings : content of the file ``path``, or of a part of it
    """
    if settings.get("kind") not in kinds or (family and settings.get("family") != family):
        raise DamagedFile(
            path, f"it holds no {what}", "Give the file that a run has written for it, or delete it and run again."
        )
    if layout is not None:
        named = {"kind", "family"} if family else {"kind"}
        layout.check(path, tensors, {key: value for key, value in settings.items() if key not in named})


def part_of(tensors: Mapping[str, np.ndarray], part: str) -> dict[str, np.ndarray]:
    """The arrays whose names begin with ``part.``, by the rest of their names."""
    return {name.removeprefix(f"{part}."): values for name, values in tensors.items() if name.startswith(f"{part}.")}


@contextmanager
def _opened_model(path: str | Path) -> Iterator[tuple]:
    """An opened model file, its settings and the digest of its arrays; errors become a :class:`StorageError`."""
    from safetensors import SafetensorError, safe_open

    try:
        with safe_open(str(path), framework="numpy") as file:
            content = parse_plain((file.metadata() or {})[_KEY])
            if content["header"] != _header_digest(content, _shapes(file)):
                raise DamagedFile(path, "its header is damaged")
            settings = parse_plain(content["settings"])
            if not isinstance(settings, dict):
                raise DamagedFile(path, "its settings are no mapping")
            yield file, settings, content["arrays"]
    except RecursionError:
        raise DamagedFile(path, "its settings are nested too deeply") from None
    except (OSError, SafetensorError, LookupError, ValueError, TypeError, AttributeError) as error:
        reason = "it is missing, damaged, or not a model that this version of the library has written"
        raise DamagedFile(path, f"{reason} ({plain_reason(error)})") from error


def _shapes(file) -> dict[str, tuple[int, ...]]:
    return {name: tuple(file.get_slice(name).get_shape()) for name in file.keys()}


def _header_digest(content: Mapping[str, str], shapes: Mapping[str, tuple[int, ...]]) -> str:
    """Digest of what a file says before its arrays: their names and shapes, the settings, the digest of the arrays."""
    named = [[name, *map(int, shape)] for name, shape in sorted(shapes.items())]
    return hashlib.sha256(json.dumps([content["settings"], content["arrays"], named]).encode()).hexdigest()


def _digest_of(arrays: Mapping[str, np.ndarray]) -> str:
    """Digest of arrays: their names, types, shapes and bytes."""
    sha = hashlib.sha256()
    for name, values in sorted(arrays.items()):
        sha.update(f"{name} {values.dtype.str} {values.shape};".encode())
        sha.update(np.ascontiguousarray(values).reshape(-1).view(np.uint8))
    return sha.hexdigest()
