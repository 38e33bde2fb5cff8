"""Unfinished files and folders: their names, and their removal whatever ends the process that writes them.

A file is written as ``.partial.<process id>.<name>`` and renamed when it is whole.
"""

import hashlib
import os
import re
import shutil
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

PREFIX = ".partial."

_MAX_NAME = 255  # bytes that file systems allow in a name
_unfinished: set[Path] = set()
#: Held while a file is renamed, and for good once the process gives up its files.
_renaming = threading.Lock()


def partial_of(path: Path) -> Path:
    """The name under which this process writes a file: in its folder, with its suffix."""
    name = f"{PREFIX}{os.getpid()}.{path.name}"
    if len(os.fsencode(name)) > _MAX_NAME:
        short = hashlib.sha256(os.fsencode(path.name)).hexdigest()[:16]
        name = f"{PREFIX}{os.getpid()}.{short}{path.suffix}"
    return path.with_name(name)


@contextmanager
def unfinished(path: Path) -> Iterator[None]:
    """A file or folder that is removed when the block ends, and also when the process is stopped before that."""
    _unfinished.add(path)
    try:
        yield
    finally:
        remove(path)
        _unfinished.discard(path)


def rename(source: Path, target: Path) -> None:
    """Rename a file or folder to a name that may exist; never returns once :func:`give_up` has been called."""
    with _renaming:
        if source.is_dir():
            remove(target)
        os.replace(source, target)


def give_up() -> None:
    """Remove what this process has not finished, just before it ends; from here on it renames nothing."""
    _renaming.acquire()
    for _ in range(3):  # other threads may make a folder again before they notice
        for number, path in enumerate(tuple(_unfinished)):
            with suppress(OSError):
                # Under a name that no other thread knows, nothing is added to a folder while it is removed.
                hidden = path.with_name(f"{PREFIX}{os.getpid()}.{number}")
                os.rename(path, hidden)
                remove(hidden)
        time.sleep(0.01)


def target_of(path: Path) -> Path:
    """A path as it will be called when everything on it is finished."""
    return Path(*(re.sub(rf"^{re.escape(PREFIX)}\d+\.", "", part) for part in path.parts))


def remove(path: Path) -> None:
    """Remove a file, a link or a folder with all that it holds, if it exists."""
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


def remove_leftovers(path: Path) -> None:
    """Remove what killed processes left of a file or folder; raises OSError where its folder cannot be read."""
    parent = path.parent
    if any(one.startswith(PREFIX) for one in parent.parts):
        return  # a folder that this process is writing: nothing is older, and it may hold many files
    with os.scandir(parent) as entries:
        names = [entry.name for entry in entries if entry.name.startswith(PREFIX)]
    own = partial_of(path).name.removeprefix(f"{PREFIX}{os.getpid()}")
    for name in names:
        if name == f"{PREFIX}{writer_of(name)}{own}" and _is_abandoned(parent / name):
            remove(parent / name)


def sweep(folder: Path) -> None:
    """Remove every unfinished file and folder below a folder whose process has ended."""
    for parent, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(parent, name)
            if name.startswith(PREFIX) and _is_abandoned(path):
                with suppress(OSError):
                    remove(path)
        folders[:] = [name for name in folders if not name.startswith(PREFIX)]


def writer_of(name: str) -> int:
    """Id of the process that wrote an unfinished file, from its name; 0 where the name holds none."""
    process = name.removeprefix(PREFIX).partition(".")[0]
    return int(process) if process.isascii() and process.isdecimal() and len(process) < 10 else 0


def is_alive(process: int) -> bool:
    """Whether a process with this id runs on this machine."""
    if process <= 0:
        return False
    with suppress(OSError):
        return _status(process)[0] not in "ZX"  # an ended process that nobody has waited for
    try:
        os.kill(process, 0)
    except PermissionError:
        return True
    except OSError:
        return False
    return True


def _is_abandoned(path: Path) -> bool:
    """Whether the process that wrote an unfinished file has ended.

    Ids are given out again, soon after the start of a machine or a container: a process that began well after the file
    was last changed is not its writer.
    """
    process = writer_of(path.name)
    if not is_alive(process):
        return True
    try:
        began = float(_status(process)[19]) / os.sysconf("SC_CLK_TCK") - time.clock_gettime(time.CLOCK_BOOTTIME)
        return began + time.time() > path.lstat().st_ctime + 60
    except (AttributeError, OSError):  # not Linux, or one of them has gone
        return False


def _status(process: int) -> list[str]:
    """The fields of a process's status from its state on (``man proc_pid_stat``); raises OSError if it has ended."""
    with open(f"/proc/{process}/stat", encoding="utf-8", errors="replace") as file:
        return file.read().rpartition(")")[2].split()
