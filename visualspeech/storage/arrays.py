"""Arrays: HDF5 files, one per shard, with one group per utterance.

Every byte that is read is covered by a checksum: small arrays lie in the metadata of the file, which HDF5 checks in its
newer format, larger ones in chunks with a Fletcher checksum. What a file could refer to outside itself (soft and
external links, virtual and external datasets) is refused, as is an array that claims more bytes than the file holds.
"""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, StorageError
from visualspeech.storage.files import replacing, write_error

#: The oldest format in which HDF5 checks all metadata; named, so that files do not depend on the version of HDF5.
_FORMAT = ("v110", "v110")
_SMALL = 32_768  # bytes of an array that is kept in the metadata; HDF5 allows 64 KiB
_CHUNK = 2**20  # bytes of a chunk, which is read as a whole, at most, unless one row is larger
_LARGEST_RATE = 1e6  # Hz


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
            # No cache of chunks: HDF5 crashes where a cached one no longer fits the disk.
            self._file = h5py.File(temporary, "w", libver=_FORMAT, track_order=False, rdcc_nbytes=0)
            _write_attributes(self._file, self._attributes)
        except OSError as error:
            self._context.__exit__(type(error), error, error.__traceback__)
            raise write_error(error, self.path) from error
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
        _write_attributes(group, {"rate": float(rate), **attributes})
        for name, values in arrays.items():
            data = _create(group, name, np.asarray(values))
            if units and name in units:
                _write_attributes(data, {"units": units[name]})

    def __exit__(self, kind, error, trace) -> None:
        try:
            if self._file is not None:
                self._file.close()
        except (OSError, RuntimeError) as unclosed:  # closing a file on a full disk raises either
            if not isinstance(error, OSError):
                error = unclosed if isinstance(unclosed, OSError) else OSError(str(unclosed))
                kind, trace = type(error), error.__traceback__
        self._context.__exit__(kind, error, trace)


def _create(group, name: str, values: np.ndarray):
    """Write an array into a group so that a checksum covers it; returns its dataset."""
    import h5py

    if values.nbytes > _SMALL:
        # Chunks of equal size, so that the last one is not padded by much.
        rows = -(-len(values) // min(-(-values.nbytes // _CHUNK), len(values)))
        chunks = (rows, *values.shape[1:])
        return group.create_dataset(name, data=values, track_times=False, chunks=chunks, fletcher32=True)
    # With the low-level functions, since `create_dataset` ignores the properties of a scalar.
    properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    properties.set_layout(h5py.h5d.COMPACT)
    properties.set_obj_track_times(False)
    kind = h5py.h5t.py_create(values.dtype, logical=True)
    space = h5py.h5s.create_simple(values.shape) if values.shape else h5py.h5s.create(h5py.h5s.SCALAR)
    made = h5py.Dataset(h5py.h5d.create(group.id, name.encode("utf-8"), kind, space, properties))
    made[...] = values
    return made


def _write_attributes(node, attributes: Mapping) -> None:
    """Write attributes; texts have a fixed length, for those of variable length lie where HDF5 keeps no checksum."""
    for name, value in attributes.items():
        node.attrs[name] = np.bytes_(value.encode("utf-8")) if isinstance(value, str) else value


def _plain(value):
    """An attribute as it was given: a number of Python or a text."""
    if isinstance(value, bytes):
        return value.decode("utf-8")
    if not isinstance(value, str | np.number | np.bool_):
        raise TypeError(f"an attribute is of the type {type(value).__name__}")
    return value if isinstance(value, str) else value.item()


class ArrayReader:
    """Reads what :class:`ArrayWriter` wrote, utterance by utterance.

    ``reader.ids`` lists the utterances; ``reader[id]`` returns a dict of arrays, ``reader.rate(id)`` the frame rate in
    Hz, ``reader.attributes(id)`` all attributes of an utterance. Raises :class:`StorageError` for a missing or damaged
    file and for utterances and arrays that it does not hold.
    """

    def __init__(self, path: str | Path) -> None:
        import h5py

        self.path = Path(path)
        with self._reading():
            self._file = h5py.File(self.path, "r")
            self._bytes = self.path.stat().st_size

    def __enter__(self) -> "ArrayReader":
        return self

    def __exit__(self, *exception) -> None:
        self._file.close()

    @property
    def ids(self) -> list[str]:
        with self._reading():
            return sorted(self._file)

    def __contains__(self, utterance_id: str) -> bool:
        with self._reading(utterance_id):
            return _holds(self._file, utterance_id)

    def __getitem__(self, utterance_id: str) -> dict[str, np.ndarray]:
        with self._reading(utterance_id):
            names = list(self._group(utterance_id))
        return {name: self.array(utterance_id, name, ()) for name in names}

    def array(self, utterance_id: str, name: str, rows=slice(None)) -> np.ndarray:
        """One array of one utterance, or some of its rows."""
        with self._reading(utterance_id, name):
            return self._dataset(utterance_id, name)[rows]

    def length(self, utterance_id: str, name: str) -> int:
        """Number of rows of an array; the array is not read."""
        with self._reading(utterance_id, name):
            return self._dataset(utterance_id, name).shape[0]

    def rate(self, utterance_id: str) -> float:
        with self._reading(utterance_id):
            rate = float(self._group(utterance_id).attrs["rate"])
            if not 0 < rate <= _LARGEST_RATE:
                raise ValueError(f"the frame rate is {rate:g} Hz")
            return rate

    def attributes(self, utterance_id: str) -> dict:
        with self._reading(utterance_id):
            return {name: _plain(value) for name, value in self._group(utterance_id).attrs.items()}

    def _group(self, utterance_id: str):
        import h5py

        if utterance_id not in self:
            raise StorageError(
                f"{self.path} holds no utterance {utterance_id!r}. Delete the file and run the same command again."
            )
        return _node(self._file, utterance_id, h5py.Group)

    def _dataset(self, utterance_id: str, name: str):
        import h5py

        data = _node(self._group(utterance_id), name, h5py.Dataset)
        if data.dtype.kind not in "biuf" or data.shape is None or data.is_virtual or data.external:
            raise TypeError(f"it is no array of numbers in this file, but of the type {data.dtype}")
        if not data.nbytes <= data.id.get_storage_size() <= self._bytes:
            raise ValueError(f"it claims {data.nbytes} bytes, more than the file holds")
        return data

    @contextmanager
    def _reading(self, utterance_id: str = "", name: str = "") -> Iterator[None]:
        """Errors of h5py, and of what a foreign file holds, as a sentence that names file, utterance and array."""
        try:
            yield
        except (OSError, LookupError, RuntimeError, ValueError, TypeError, AttributeError, OverflowError) as error:
            where = f"array {name!r} of " * bool(name) + f"utterance {utterance_id!r}: " * bool(utterance_id)
            said = error.args[0] if isinstance(error, KeyError) and error.args else error
            raise DamagedFile(self.path, f"{where}{said}") from error


def _holds(parent, name: str) -> bool:
    """Whether a group has an entry of this name; a path through other groups is no name."""
    return bool(name.strip(".")) and "/" not in name and parent.id.links.exists(name.encode("utf-8"))


def _node(parent, name: str, kind: type):
    """A group or dataset that lies in the file itself; links to other places or files are not followed."""
    import h5py

    if not _holds(parent, name):
        raise KeyError("there is none")
    if parent.id.links.get_info(name.encode("utf-8")).type != h5py.h5l.TYPE_HARD:
        raise TypeError("it is a link to another place")
    node = parent[name]
    if not isinstance(node, kind):
        raise TypeError(f"it is a {type(node).__name__.lower()}, not a {kind.__name__.lower()}")
    return node


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
