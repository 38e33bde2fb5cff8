"""Shared by all jobs: logging to the terminal and to a file, progress lines, and errors shown without a traceback."""

import errno
import json
import logging
import os
import shlex
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from visualspeech.errors import VisualSpeechError
from visualspeech.interruption import SIGNALS, stoppable
from visualspeech.locks import jobs_lock, share
from visualspeech.unfinished import is_alive

log = logging.getLogger("visualspeech")

#: Variables that set the number of threads of numeric libraries. OpenCV's own threads cost more than they save on
#: images of faces.
THREAD_VARIABLES = (
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "OPENCV_FOR_THREADS_NUM",
)


#: Environment variables by which jobs know their run: its process id, and the lock files that its jobs share, as JSON.
RUN, LOCKS = "VISUALSPEECH_RUN", "VISUALSPEECH_LOCKS"
#: Set where the jobs of a run show warnings and errors alone; their log files hold every message.
QUIET = "VISUALSPEECH_QUIET"

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def settle_environment(root: str | Path) -> None:
    """Set the environment variables that every job started by this process inherits.

    One thread per job on every machine: figures do not depend on the number of cores, and small networks train faster
    with one. ``PYTHONPATH`` begins with ``root``, the folder of the Snakefile, so that jobs use the library beside it;
    ``VISUALSPEECH_COMMAND`` holds the command line of the run for the report, and ``VISUALSPEECH_RUN`` the process
    whose death ends its jobs.
    """
    os.environ.setdefault("VISUALSPEECH_COMMAND", shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]))
    os.environ[RUN] = str(os.getpid())
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    folders = [str(root), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(filter(None, folders)))


def settle_messages() -> None:
    """Let Ctrl-C end the main process with one line, where Snakemake would show a traceback (while it plans)."""
    show, show_ignored = sys.excepthook, sys.unraisablehook
    # A message that cannot be written, to a full disk or a closed terminal, is no error of the run.
    logging.raiseExceptions = False

    def shown(kind, error, trace) -> None:
        if not issubclass(kind, KeyboardInterrupt):
            show(kind, error, trace)
        else:
            with suppress(OSError):
                print("stopped; run the same command again to resume", file=sys.stderr)

    def shown_ignored(ignored) -> None:
        if not issubclass(ignored.exc_type, KeyboardInterrupt):
            show_ignored(ignored)

    sys.excepthook, sys.unraisablehook = shown, shown_ignored


def settle_quiet(quiet: bool) -> None:
    """Let every job started by this process show warnings and errors alone, or all of its messages."""
    os.environ[QUIET] = "1" if quiet else ""


def settle_sigterm() -> None:
    """Run the main process's own handler of SIGTERM in a thread; called when that handler is in place.

    Snakemake's takes a lock that the interrupted code may hold (``JobScheduler.exit_gracefully``), and then waits for
    ever.
    """
    handler = signal.getsignal(signal.SIGTERM)
    if callable(handler):
        signal.signal(signal.SIGTERM, lambda *given: threading.Thread(target=handler, args=given).start())


def settle_locks(folders: Iterable[str | Path]) -> None:
    """Let every job started by this process share the locks of these result folders."""
    os.environ[LOCKS] = json.dumps([str(jobs_lock(folder).absolute()) for folder in folders])


def shell_prefix() -> str:
    """What precedes the command of every job: its signals wait until :func:`job` is ready for them.

    A script imports for a second or more before that, and would end with a traceback. Where ``env`` cannot block
    signals (GNU coreutils before 8.31, macOS), it still does.
    """
    block = ["env", "--block-signal=" + ",".join(one.name.removeprefix("SIG") for one in SIGNALS)]
    try:
        possible = subprocess.run([*block, "true"], capture_output=True).returncode == 0
    except OSError:
        possible = False
    return "set -euo pipefail; " + (f"exec {shlex.join(block)} " if possible else "")


@contextmanager
def job(log_path: str | Path) -> Iterator[None]:
    """Run the body of a workflow script; messages go to the terminal and to the file ``log_path``.

    A :class:`VisualSpeechError` is shown as its message and ends the process with status 1. Any other exception is a
    defect: its traceback goes to the log file, and the terminal names that file. A signal, and the death of the run,
    end the process with one line (:func:`visualspeech.interruption.stoppable`).
    """
    run = int(os.environ.get(RUN, "0"))
    run = run if run != os.getpid() else 0
    share(json.loads(os.environ.get(LOCKS, "[]")) if run else ())
    if run and not is_alive(run):
        # The run died while this script was imported; another one may own the log file by now.
        os._exit(1)
    path = Path(log_path)
    # The log of a shard or of a model lies in a folder named after the stage.
    name = path.stem if path.parent.name == "logs" else f"{path.parent.name} {path.stem}"
    terminal = logging.StreamHandler(sys.stderr)
    terminal.setLevel(logging.WARNING if os.environ.get(QUIET) else logging.INFO)
    handlers, unlogged = [terminal], None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handlers.append(logging.FileHandler(path, mode="w", encoding="utf-8"))
    except OSError as error:
        unlogged = error
    for handler in handlers:
        handler.setFormatter(logging.Formatter(f"%(asctime)s {name}: %(message)s", "%H:%M:%S"))
    log.setLevel(logging.INFO)
    log.handlers[:] = handlers
    log.propagate = False
    # A message that cannot be written, to a full disk or a closed terminal, is no error of the job.
    logging.raiseExceptions = False
    try:
        with stoppable(_say_stopped, run or None):
            if unlogged:
                log.warning("cannot write the log file %s: %s", log_path, unlogged.strerror)
            yield
    except VisualSpeechError as error:
        log.error("%s", error)
        sys.exit(1)
    except MemoryError:
        log.error("out of memory. Run with fewer jobs at a time (a smaller --cores) or on a larger machine.")
        sys.exit(1)
    except Exception as error:
        if isinstance(error, OSError) and error.errno in _FULL:
            named = f" {error.filename}" if error.filename else ""
            log.error("cannot write%s: %s. Free space, then run the same command again.", named, error.strerror)
        else:
            _show_defect(error, terminal, handlers[1:], log_path)
        sys.exit(1)
    finally:
        for handler in handlers:
            with suppress(OSError):
                handler.flush()


def _say_stopped(reason: str) -> None:
    why = f"stopped ({reason})" if reason else "stopped, because its run has ended"
    log.warning("%s; run the same command again to resume", why)


def _show_defect(error: Exception, terminal: logging.Handler, files: list[logging.FileHandler], path) -> None:
    """The traceback of a defect goes to the log file, its message and the name of that file to the terminal."""
    for file in files:
        with suppress(OSError):
            file.stream.write("".join(traceback.format_exception(error)))
            file.flush()
    place = f"; see {path}" if files else ""
    terminal.emit(log.makeRecord(log.name, logging.ERROR, "", 0, "unexpected error: %r%s", (error, place), None))


def progress(items: Iterable, total: int, unit: str, every: float = 3.0) -> Iterator:
    """Yield the items; log every ``every`` seconds how many are done, the total, the speed and the time left.

    Parameters
    ----------
    total : number of items
    unit : what the items are, for the log
    """
    start = last = time.monotonic()
    done = 0
    for item in items:
        yield item
        done += 1
        now = time.monotonic()
        if now - last >= every or done == total:
            last = now
            speed = done / max(now - start, 1e-9)
            left = (total - done) / speed
            log.info("%d/%d %s, %.3g %s/s, %.0f s left", done, total, unit, speed, unit, left)


def log_defect(message: str, error: BaseException) -> None:
    """Log a sentence about an unexpected error that does not end the job; its traceback goes to the log file only."""
    log.warning("%s", message)
    trace = "".join(traceback.format_exception(error))
    for handler in log.handlers:
        if isinstance(handler, logging.FileHandler):
            handler.emit(log.makeRecord(log.name, logging.WARNING, "", 0, "%s", (trace,), None))
