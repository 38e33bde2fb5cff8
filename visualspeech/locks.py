"""Locks of a corpus's result folder: one run at a time, and no job of an earlier run beside it.

The operating system releases a lock when its process ends, however it ends.
"""

import fcntl
import os
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import IO

from visualspeech.errors import StorageError
from visualspeech.unfinished import sweep

#: Seconds that a run waits for jobs of an earlier run, which end by themselves within about a second.
PATIENCE = 15.0

#: Seconds that a run waits for the folder itself: :func:`is_held` holds it for a moment.
_MOMENT = 0.5


def hold(folder: str, run: str = "") -> IO:
    """Hold a corpus's result folder for this process and remove the unfinished files of killed jobs below it.

    Returns the open lock file, to be kept for as long as the folder is held.

    Parameters
    ----------
    run : name of this run, by which jobs on other machines know whether it still holds the folder

    Raises
    ------
    StorageError
        Another run holds the folder, a job of an earlier run does not end, or the folder cannot be written.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        held, jobs = open(path / ".lock", "a"), open(jobs_lock(folder), "w")  # noqa: SIM115 - held open on purpose
    except OSError as error:
        raise StorageError(
            f"cannot write to the results folder {path.resolve()}: {error.strerror}. Give yourself the right to write "
            "there, or choose another folder with `results` or --directory."
        ) from error
    with jobs:
        if not _locked(held, _MOMENT):
            held.close()
            raise StorageError(
                f"another run is using {path.resolve()}. Wait until it has ended, stop it, or choose another folder "
                "with `results` or --directory."
            )
        # Before the wait: jobs of an earlier run that start from now on see that it has ended.
        held.truncate(0)
        held.write(run)
        held.flush()
        if not _locked(jobs, PATIENCE):
            held.close()
            raise StorageError(
                f"a job of an earlier run is still writing to {path.resolve()}. Wait until it has ended or end it "
                f"(`fuser {jobs_lock(path.resolve())}` names its process, on a cluster `squeue` its job), then run the "
                "same command again."
            )
        sweep(path)
    return held


def is_held(folder: str | Path, run: str) -> bool:
    """Whether the run of this name still holds a folder, on whatever machine it is.

    True also where that cannot be found out, as for a moment on a file system that does not answer.
    """
    try:
        with open(Path(folder, ".lock"), encoding="utf-8") as file:
            if file.read() != run:
                return False
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False


def jobs_lock(folder: str | Path) -> Path:
    """The lock file that every job of a corpus shares."""
    return Path(folder, ".jobs.lock")


def share(locks: Iterable[str | Path]) -> list[int]:
    """Share lock files for as long as this process lives; returns their descriptors.

    A lock that cannot be opened is left out: the job itself will report that its folder cannot be written.
    """
    shared = []
    for path in locks:
        with suppress(OSError):
            shared.append(os.open(path, os.O_RDONLY))
            fcntl.flock(shared[-1], fcntl.LOCK_SH)
    return shared


def _locked(file: IO, patience: float) -> bool:
    """Lock a file for this process alone; False if another still holds it after ``patience`` seconds.

    Raises
    ------
    StorageError
        The file system has no locks.
    """
    end = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= end:
                return False
            time.sleep(0.05)
        except OSError as error:
            raise StorageError(
                f"cannot lock {Path(file.name).resolve()}: {error.strerror}. Choose a folder on another file system "
                "with `results` or --directory."
            ) from error
