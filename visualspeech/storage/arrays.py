"""Arrays: HDF5 files, one per shard, with one group per utterance."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from visualspeech.errors import StorageError
from visualspeech.storage.files import replacing, write_error


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
