"""Shared by all jobs: logging to the terminal and to a file, progress lines, and errors shown without a traceback."""

import logging
import os
import shlex
import sys
import time
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from visualspeech.errors import VisualSpeechError

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


def settle_environment(root: str | Path) -> None:
    """Set the environment variables that every job started by this process inherits.

    One thread per job on every machine: figures do not depend on the number of cores, and small networks train faster
    with one. ``PYTHONPATH`` begins with ``root``, the folder of the Snakefile, so that jobs use the library beside it;
    ``VISUALSPEECH_COMMAND`` holds the command line of the run for the report.
    """
    os.environ.setdefault("VISUALSPEECH_COMMAND", shlex.join([Path(sys.argv[0]).name, *sys.argv[1:]]))
    os.environ.update(dict.fromkeys(THREAD_VARIABLES, "1"))
    folders = [str(root), *os.environ.get("PYTHONPATH", "").split(os.pathsep)]
    os.environ["PYTHONPATH"] = os.pathsep.join(dict.fromkeys(filter(None, folders)))


@contextmanager
def job(log_path: str | Path) -> Iterator[None]:
    """Run the body of a workflow script; messages go to the terminal and to the file ``log_path``.

    A :class:`VisualSpeechError` is shown as its message and ends the process with status 1. Any other exception is a
    defect: its traceback goes to the log file, and the terminal names that file.
    """
    Path(log_path).parent.mkdir(parents=True, exist_ok=True)
    path = Path(log_path)
    # The log of a shard or of a model lies in a folder named after the stage.
    name = path.stem if path.parent.name == "logs" else f"{path.parent.name} {path.stem}"
    file = logging.FileHandler(log_path, mode="w", encoding="utf-8")
    terminal = logging.StreamHandler(sys.stderr)
    for handler in (file, terminal):
        handler.setFormatter(logging.Formatter(f"%(asctime)s {name}: %(message)s", "%H:%M:%S"))
    log.setLevel(logging.INFO)
    log.handlers[:] = [file, terminal]
    log.propagate = False
    try:
        yield
    except VisualSpeechError as error:
        log.error("%s", error)
        sys.exit(1)
    except MemoryError:
        log.error("out of memory. Run with fewer jobs at a time (a smaller --cores) or on a larger machine.")
        sys.exit(1)
    except Exception as error:
        file.stream.write(traceback.format_exc())
        terminal.emit(
            log.makeRecord(log.name, logging.ERROR, "", 0, "unexpected error: %r; see %s", (error, log_path), None)
        )
        sys.exit(1)
    finally:
        logging.shutdown([])
        for handler in (file, terminal):
            handler.flush()


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
