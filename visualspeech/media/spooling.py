"""Temporary storage of long streams on disk, so that memory does not grow with their length."""

from tempfile import TemporaryFile

import numpy as np

from visualspeech.errors import StorageError


class Spool:
    """Rows of numbers in an unnamed temporary file, which is deleted with the spool.

    Parameters
    ----------
    dtype : number type in the file
    columns : numbers per row; 0 for a one-dimensional sequence

    Raises
    ------
    StorageError
        The temporary folder cannot be written, or is full.
    """

    def __init__(self, dtype: type = np.float32, columns: int = 0) -> None:
        self._dtype = np.dtype(dtype)
        self._shape = (columns,) if columns else ()
        self._row = self._dtype.itemsize * max(1, columns)
        self._rows = 0
        try:
            self._file = TemporaryFile(prefix="visualspeech.")
        except OSError as error:
            raise _write_error(error) from error

    def __len__(self) -> int:
        return self._rows

    def append(self, rows: np.ndarray) -> None:
        """Append rows (n,) or (n, columns)."""
        rows = np.ascontiguousarray(rows, self._dtype)
        if rows.shape[1:] != self._shape:
            raise ValueError(f"rows of shape {rows.shape[1:]} for a spool of rows of shape {self._shape}")
        try:
            self._file.seek(self._rows * self._row)
            self._file.write(rows.tobytes())
            self._file.flush()
        except OSError as error:
            raise _write_error(error) from error
        self._rows += len(rows)

    def __getitem__(self, rows: slice) -> np.ndarray:
        """The rows of a slice with a step of 1, (n,) or (n, columns)."""
        first, last, step = rows.indices(self._rows)
        if step != 1:
            raise ValueError("a spool is read row by row")
        count = max(0, last - first)
        self._file.seek(first * self._row)
        data = self._file.read(count * self._row)
        return np.frombuffer(data, self._dtype).reshape(count, *self._shape)


def _write_error(error: OSError) -> StorageError:
    return StorageError(
        f"cannot write temporary files: {error.strerror or error}. Free space there, or set the environment "
        "variable TMPDIR to another folder."
    )
