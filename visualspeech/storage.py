"""The only module that reads and writes the project's files.

Tables are TSV, arrays HDF5 (one file per shard, one group per utterance), models safetensors with their settings as
JSON metadata. Every file is written under a temporary name in its folder and renamed into place, so a killed job never
leaves a half-written file under a name that another job reads. Nothing that is read is unpickled or executed.
"""

import json
import os
import shutil
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

import numpy as np

from visualspeech.errors import StorageError


def _write_error(error: OSError, path: Path) -> StorageError:
    reason = os.strerror(error.errno) if error.errno else error.strerror or str(error)
    return StorageError(
        f"cannot write {path}: {reason}. Check that the folder exists, that you may write to it and that the disk is "
        "not full; then run the same command again, finished work is kept."
    )


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of ``path``; rename it to ``path`` when the block succeeds.

    The temporary path keeps the suffix of ``path``, by which libraries choose the format, and is removed on failure.
    Works for files and for folders (create the folder at the yielded path).

    Raises
    ------
    StorageError
        The folder is read-only, the disk is full, or the path cannot be created.
    """
    path = Path(path)
    temporary = None
    try:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            # The name is fixed, so that the next run replaces what a killed job left behind.
            temporary = path.with_name(f".partial.{path.name}")
            _remove(temporary)
            yield temporary
            if temporary.is_dir():
                _remove(path)
            os.replace(temporary, path)
        except OSError as error:
            if _is_unrelated(error, path, temporary):
                raise
            raise _write_error(error, path) from error
    finally:
        if temporary is not None:
            _remove(temporary)


def check_writable(path: str | Path) -> None:
    """Check, before long work, that :func:`replacing` will be able to write a file; leaves nothing behind.

    Raises
    ------
    StorageError
        The file cannot be written.
    """
    path = Path(path)
    folder = next((parent for parent in path.absolute().parents if parent.exists()), Path("/"))
    try:
        # The permissions of a folder do not say what root may write, so writing is tried.
        with TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _write_error(error, path) from error


def _is_unrelated(error: OSError, path: Path, temporary: Path | None) -> bool:
    """Whether an error is about a file other than ``path`` and its temporary file, for example one that is read."""
    if not isinstance(error.filename, str | bytes | os.PathLike):
        return False
    named = Path(os.fsdecode(error.filename))
    ours = {path, *path.parents, temporary}
    return named not in ours and temporary not in named.parents


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    """Write UTF-8 text, atomically."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def copy_file(source: str | Path, path: str | Path) -> None:
    """Copy a file; raises :class:`StorageError` if it is missing, and as :func:`replacing`."""
    if not Path(source).is_file():
        raise StorageError(f"cannot read {source}: there is no such file.")
    with replacing(path) as temporary:
        shutil.copyfile(source, temporary)


def read_text(path: str | Path) -> str:
    """Read UTF-8 text.

    Raises
    ------
    StorageError
        The file is missing or not UTF-8 text.
    """
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"cannot read {path}: {error}. Delete it and run again to recreate it.") from error


def table_text(table) -> str:
    """A data frame as TSV text (floats with the shortest digits that read back equal, no index)."""
    return table.to_csv(sep="\t", index=False, lineterminator="\n")


def write_table(path: str | Path, table) -> None:
    """Write a :class:`pandas.DataFrame` as TSV, atomically."""
    write_text(path, table_text(table))


def read_table(path: str | Path, text_columns: tuple[str, ...] = ("id",)):
    """Read a TSV written by :func:`write_table`; ``text_columns`` stay text even where they look like numbers.

    Empty cells of text columns become empty strings, those of other columns NaN. Words such as "null" and "NA" are
    read as text, not as missing values. Raises :class:`StorageError` for a missing or damaged file.
    """
    import pandas

    try:
        return pandas.read_csv(
            path,
            sep="\t",
            dtype={name: str for name in text_columns},
            keep_default_na=False,
        ).pipe(_numbers_where_possible, text_columns)
    except (OSError, ValueError) as error:
        raise StorageError(f"cannot read the table {path}: {error}. Delete it and run the command again.") from error


def _numbers_where_possible(table, text_columns):
    import pandas

    converted = {}
    for name in table.columns:
        if name in text_columns or pandas.api.types.is_numeric_dtype(table[name]):
            continue
        column = table[name].replace("", np.nan)
        try:
            converted[name] = pandas.to_numeric(column)
        except (ValueError, TypeError):
            continue
    return table.assign(**converted)


class ArrayWriter:
    """Writes the arrays of one shard: ``with ArrayWriter(path) as out: out.add(id, {...}, rate=25.0, units={...})``.

    Memory does not grow with the number of utterances. The file appears under its name only when the block succeeds.
    """

    def __init__(self, path: str | Path, **attributes) -> None:
        self.path = Path(path)
        self._attributes = attributes

    def __enter__(self) -> "ArrayWriter":
        import h5py

        self._context = replacing(self.path)
        self._file = None
        temporary = self._context.__enter__()
        try:
            # No time stamps, sorted names: the same content gives the same bytes.
            self._file = h5py.File(temporary, "w", track_order=False)
            self._file.attrs.update(self._attributes)
        except OSError as error:
            self._context.__exit__(type(error), error, error.__traceback__)
            raise _write_error(error, self.path) from error
        return self

    def add(
        self,
        utterance_id: str,
        arrays: Mapping[str, np.ndarray],
        rate: float,
        units: Mapping[str, str] | None = None,
        **attributes,
    ) -> None:
        """Add one utterance: named arrays, the frame rate in Hz, the unit of each array, further attributes."""
        group = self._file.create_group(utterance_id)
        group.attrs["rate"] = float(rate)
        group.attrs.update(attributes)
        for name, values in arrays.items():
            data = group.create_dataset(name, data=np.asarray(values), track_times=False)
            if units and name in units:
                data.attrs["units"] = units[name]

    def __exit__(self, kind, error, trace) -> None:
        try:
            if self._file is not None:
                self._file.close()
        except (OSError, RuntimeError) as unclosed:  # closing a file on a full disk raises either
            if not isinstance(error, OSError):
                error = unclosed if isinstance(unclosed, OSError) else OSError(str(unclosed))
                kind, trace = type(error), error.__traceback__
        self._context.__exit__(kind, error, trace)


class ArrayReader:
    """Reads what :class:`ArrayWriter` wrote, utterance by utterance.

    ``reader.ids`` lists the utterances; ``reader[id]`` returns a dict of arrays, ``reader.rate(id)`` the frame rate in
    Hz, ``reader.attributes(id)`` all attributes of an utterance. Raises :class:`StorageError` for a missing or damaged
    file and for utterances that it does not hold.
    """

    def __init__(self, path: str | Path) -> None:
        import h5py

        self.path = Path(path)
        try:
            self._file = h5py.File(self.path, "r")
        except OSError as error:
            raise StorageError(f"cannot read {path}: {error}. Delete it and run again to recreate it.") from error

    def __enter__(self) -> "ArrayReader":
        return self

    def __exit__(self, *exception) -> None:
        self._file.close()

    @property
    def ids(self) -> list[str]:
        return sorted(self._file)

    def __contains__(self, utterance_id: str) -> bool:
        return utterance_id in self._file

    def __getitem__(self, utterance_id: str) -> dict[str, np.ndarray]:
        return {name: data[()] for name, data in self._group(utterance_id).items()}

    def array(self, utterance_id: str, name: str, rows=slice(None)) -> np.ndarray:
        """One array of one utterance, or some of its rows."""
        return self._group(utterance_id)[name][rows]

    def length(self, utterance_id: str, name: str) -> int:
        """Number of rows of an array; the array is not read."""
        return self._group(utterance_id)[name].shape[0]

    def rate(self, utterance_id: str) -> float:
        return float(self._group(utterance_id).attrs["rate"])

    def attributes(self, utterance_id: str) -> dict:
        return dict(self._group(utterance_id).attrs)

    def _group(self, utterance_id: str):
        try:
            return self._file[utterance_id]
        except KeyError:
            raise StorageError(f"{self.path} holds no utterance {utterance_id!r}. Delete it and run again.") from None


class ArrayCollection:
    """Several shards read as one: ``with ArrayCollection(paths) as arrays: arrays[id]``. Files are opened once."""

    def __init__(self, paths) -> None:
        self._readers = [ArrayReader(path) for path in paths]
        self._reader_of = {name: reader for reader in self._readers for name in reader.ids}

    def __enter__(self) -> "ArrayCollection":
        return self

    def __exit__(self, *exception) -> None:
        for reader in self._readers:
            reader.__exit__(*exception)

    @property
    def ids(self) -> list[str]:
        return sorted(self._reader_of)

    def __contains__(self, utterance_id: str) -> bool:
        return utterance_id in self._reader_of

    def reader(self, utterance_id: str) -> ArrayReader:
        """The shard that holds an utterance.

        Raises
        ------
        StorageError
            No shard holds it.
        """
        if utterance_id not in self._reader_of:
            paths = ", ".join(str(reader.path) for reader in self._readers)
            raise StorageError(f"no utterance {utterance_id!r} in {paths}. Delete these files and run again.")
        return self._reader_of[utterance_id]

    def __getitem__(self, utterance_id: str) -> dict[str, np.ndarray]:
        return self.reader(utterance_id)[utterance_id]

    def array(self, utterance_id: str, name: str, rows=slice(None)) -> np.ndarray:
        return self.reader(utterance_id).array(utterance_id, name, rows)

    def length(self, utterance_id: str, name: str) -> int:
        return self.reader(utterance_id).length(utterance_id, name)

    def rate(self, utterance_id: str) -> float:
        return self.reader(utterance_id).rate(utterance_id)


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
