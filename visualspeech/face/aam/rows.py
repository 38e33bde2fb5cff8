"""Rows on disk, read one chunk at a time, because training textures do not fit into memory."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryFile, gettempdir

import numpy as np

from visualspeech.errors import DataError, StorageError


class RowFile:
    """Rows (n, d) of float32 in an unnamed temporary file, of which one chunk at a time is in memory.

    ``append`` while writing, then :meth:`chunks` as often as needed. Plain reads are used and not a memory map, so
    that pages of the file do not count as memory of the process. The system deletes the file when it is no longer used,
    also when the process is killed.

    Parameters
    ----------
    folder : folder of the file; None for the system's folder of temporary files
    dimension : d
    """

    def __init__(self, folder: str | Path | None, dimension: int) -> None:
        self.folder, self.dimension, self.count = Path(folder or gettempdir()), dimension, 0
        try:
            self._file = TemporaryFile(prefix="visualspeech.", dir=self.folder)
        except OSError as error:
            raise self._write_error(error) from error

    @property
    def shape(self) -> tuple[int, int]:
        return self.count, self.dimension

    def append(self, rows: np.ndarray) -> None:
        if rows.shape[1] != self.dimension:
            raise DataError(f"rows of {rows.shape[1]} values given to a file of rows of {self.dimension}")
        rows = np.ascontiguousarray(rows, np.float32)
        try:
            self._file.seek(4 * self.count * self.dimension)
            rows.tofile(self._file)
            self._file.flush()
        except OSError as error:
            raise self._write_error(error) from error
        self.count += len(rows)

    def chunks(self, size: int = 512) -> Iterator[np.ndarray]:
        """The rows in order, at most ``size`` at a time, (m, d) float32 each."""
        for start in range(0, self.count, size):
            rows = min(size, self.count - start)
            self._file.seek(4 * start * self.dimension)
            yield np.fromfile(self._file, np.float32, rows * self.dimension).reshape(rows, self.dimension)

    def _write_error(self, error: OSError) -> StorageError:
        return StorageError(
            f"cannot write temporary files in {self.folder}: {error.strerror or error}. Free space there, or set the "
            "environment variable TMPDIR to another folder, and run again."
        )


class ArrayRows:
    """An array (n, d) in memory with the interface of :class:`RowFile`."""

    def __init__(self, array: np.ndarray) -> None:
        self.array, self.shape = array, array.shape

    def chunks(self, size: int = 512) -> Iterator[np.ndarray]:
        for start in range(0, len(self.array), size):
            yield np.asarray(self.array[start : start + size], np.float32)


def choose_frames(lengths: Mapping[str, int], images: int, seed: int) -> dict[str, np.ndarray]:
    """At most ``images`` frames drawn at random over all utterances: id -> ascending frame numbers.

    The draw depends on the ids, their lengths and the seed, not on the order of the mapping. Utterances of which no
    frame was drawn are left out.
    """
    ids = sorted(lengths)
    starts = np.concatenate([[0], np.cumsum([lengths[name] for name in ids])]).astype(np.int64)
    total = int(starts[-1])
    drawn = np.arange(total)
    if total > images:
        drawn = np.sort(np.random.default_rng(seed).choice(total, images, replace=False, shuffle=False))
    home = np.searchsorted(starts, drawn, side="right") - 1
    return {ids[number]: drawn[home == number] - starts[number] for number in np.unique(home)}
