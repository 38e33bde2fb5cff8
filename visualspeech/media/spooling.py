"""Long streams kept on disk while they are put together, so that memory does not grow with their length."""

from tempfile import TemporaryFile

import numpy as np

from visualspeech.errors import StorageError


class Spool:
    """Rows of numbers in an unnamed temporary file, which goes when nobody holds the spool any more.

    Parameters
    ----------
    kind : of the numbers, as they are kept
    columns : numbers in a row; 0 for a plain sequence

    Raises
    ------
    StorageError
        The temporary folder cannot be written, or is full.
    """

    def __init__(self, kind: type = np.float32, columns: int = 0) -> None:
        self._kind = np.dtype(kind)
        self._shape = (columns,) if columns else ()
        self._row = self._kind.itemsize * max(1, columns)
        self._rows = 0
        try:
            self._file = TemporaryFile(prefix="visualspeech.")
        except OSError as error:
            raise _told(error) from error

    def __len__(self) -> int:
        return self._rows

    def append(self, rows: np.ndarray) -> None:
        """Add rows (n,) or (n, columns) at the end."""
        rows = np.ascontiguousarray(rows, self._kind)
        if rows.shape[1:] != self._shape:
            raise ValueError(f"rows of shape {rows.shape[1:]} for a spool of rows of shape {self._shape}")
        try:
            self._file.seek(self._rows * self._row)
            self._file.write(rows.tobytes())
            self._file.flush()
        except OSError as error:
            raise _told(error) from error
        self._rows += len(rows)

    def __getitem__(self, rows: slice) -> np.ndarray:
        """Some rows, one after the other; a slice with a step of 1."""
        first, last, step = rows.indices(self._rows)
        if step != 1:
            raise ValueError("a spool is read row by row")
        count = max(0, last - first)
        self._file.seek(first * self._row)
        data = self._file.read(count * self._row)
        return np.frombuffer(data, self._kind).reshape(count, *self._shape)


def _told(error: OSError) -> StorageError:
    return StorageError(
        f"cannot write temporary files: {error.strerror or error}. Make room there, or name another folder in the "
        "environment variable TMPDIR."
    )
