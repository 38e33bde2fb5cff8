"""Runs whose jobs are on other machines: what ``profiles/slurm`` asks before a run, and how jobs end with their run.

On one machine a job watches the process of its run (:mod:`visualspeech.jobs`). On another machine it cannot see
that process, but it sees the lock that the run holds on the results, if the file system shares locks between machines.
"""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from pathlib import Path

from visualspeech.jobs import LOCKS
from visualspeech.locks import is_held, share

PLUGIN = "snakemake_executor_plugin_slurm"

#: Environment variable that holds the name of the run, which stands in the lock of each corpus's results.
NAME = "VISUALSPEECH_RUN_NAME"

#: Seconds between two looks at that lock; less than a new run waits for jobs of an earlier one (``locks.PATIENCE``).
EVERY = 3.0


def check_plugin() -> None:
    """End the program with one sentence if Snakemake's executor for Slurm is not installed."""
    if find_spec(PLUGIN) is None:
        raise SystemExit(
            "profiles/slurm needs Snakemake's executor for Slurm; install it with: "
            "pip install -c constraints.txt -e '.[cluster]' (docs/cluster.md)."
        )


def keeps_accounts() -> bool:
    """Whether the cluster keeps accounts of its jobs; without, the executor would wait for ever for ``sacct``."""
    try:
        asked = ["sacct", "--noheader", "--allocations", "--starttime", "now"]
        return subprocess.run(asked, capture_output=True, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def name_run() -> str:
    """A name for this run, which its jobs inherit."""
    os.environ[NAME] = f"{socket.gethostname()} {os.getpid()} {uuid.uuid4().hex}"
    return os.environ[NAME]


def settle_signals() -> None:
    """Let SIGTERM and SIGHUP cancel the jobs of this run, as SIGINT does; called by a run whose jobs are elsewhere.

    Snakemake would wait until they have finished. A signal that the process ignores, as SIGHUP under ``nohup``, stays
    ignored.
    """

    def cancel(*_) -> None:
        for number in caught:
            signal.signal(number, signal.SIG_IGN)  # another one would interrupt the cancelling
        raise KeyboardInterrupt

    caught = [one for one in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(one) != signal.SIG_IGN]
    for number in caught:
        signal.signal(number, cancel)


def follow_run(end: Callable[[int], None] = os._exit, every: float = EVERY) -> None:
    """End this process, Snakemake around a job on another machine, when its run has ended, and at once if it has.

    Shares the locks of the run's results first: either this process sees a new run, or that run waits for it.

    Parameters
    ----------
    end : ends the process with a status
    every : seconds between two looks
    """
    locks, run = json.loads(os.environ.get(LOCKS, "[]")), os.environ.get(NAME, "")
    if not run or not locks:
        return
    share(locks)
    folders = [Path(lock).parent for lock in locks]
    if not _all_held(folders, run):
        _say_ended(end)
        return
    threading.Thread(target=_follow, args=(folders, run, end, every), daemon=True).start()


def _follow(folders: Iterable[Path], run: str, end: Callable[[int], None], every: float) -> None:
    while _all_held(folders, run):
        time.sleep(every)
    _say_ended(end)


def _all_held(folders: Iterable[Path], run: str) -> bool:
    return all(is_held(folder, run) for folder in folders)


def _say_ended(end: Callable[[int], None]) -> None:
    print(
        "stopped, because the run of this job has ended, or because the file system does not share locks between "
        "machines (docs/cluster.md)",
        file=sys.stderr,
        flush=True,
    )
    end(128 + signal.SIGTERM)
