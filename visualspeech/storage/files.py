"""Files that are whole or absent: writing through a temporary name, text, copies."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile

from visualspeech.errors import DamagedFile, StorageError, VisualSpeechError, plain_reason
from visualspeech.unfinished import partial_of, remove, remove_leftovers, rename, target_of, unfinished


def write_error(error: OSError, path: Path) -> StorageError:
    """The error of a file or folder that cannot be written."""
    reason = os.strerror(error.errno) if error.errno else error.strerror or str(error)
    return StorageError(
        f"cannot write {target_of(path)}: {reason}. Check that the folder exists, that you may write to it and that "
        "the disk is not full; then run the same command again, finished work is kept."
    )


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the folder of ``path``; rename it to ``path`` when the block succeeds.

    The temporary path keeps the suffix of ``path``, by which libraries choose the format, and is removed on failure.
    What a killed process left of ``path`` is removed too. Works for files and for folders (create the folder at the
    yielded path).

    Raises
    ------
    StorageError
        The folder is read-only, the disk is full, or the path cannot be created.
    """
    path = Path(path)
    temporary = partial_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(path)
        remove(temporary)
    except OSError as error:
        raise write_error(error, path) from error
    with unfinished(temporary):
        try:
            yield temporary
            rename(temporary, path)
        except OSError as error:
            if _is_unrelated(error, path, temporary):
                raise
            raise write_error(error, path) from error
        except VisualSpeechError:
            raise
        except Exception as error:
            # Libraries have exceptions of their own for a failed write (soundfile, SafetensorError), which say no more.
            try:
                _append(temporary)
            except OSError as cause:
                raise write_error(cause, path) from error
            raise


def _append(path: Path, size: int = 1 << 20) -> None:
    """Try to write more into an unfinished file or folder; raises OSError where the disk is full."""
    with path.open("ab") if path.is_file() else TemporaryFile(dir=path if path.is_dir() else path.parent) as file:
        file.write(bytes(size))


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
        raise write_error(error, path) from error


def _is_unrelated(error: OSError, path: Path, temporary: Path) -> bool:
    """Whether an error is about a file other than ``path`` and its temporary file, for example one that is read."""
    if not isinstance(error.filename, str | bytes | os.PathLike):
        return False
    named = Path(os.fsdecode(error.filename))
    ours = {path, *path.parents, temporary}
    return named not in ours and temporary not in named.parents


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
        raise DamagedFile(path, plain_reason(error)) from error
