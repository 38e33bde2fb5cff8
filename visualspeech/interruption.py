"""The end of a process that comes from outside: a signal, or the death of the run that a job belongs to.

Nothing is raised in the code that runs. A thread waits for the event, removes unfinished files and ends the process, so
that it makes no difference what the code is doing: there is no traceback, and a second signal changes nothing.
"""

import os
import select
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from visualspeech.unfinished import give_up, is_alive

SIGNALS = (signal.SIGHUP, signal.SIGINT, signal.SIGTERM)

_stopping = threading.Event()


@contextmanager
def stoppable(say: Callable[[str], None], run: int | None = None) -> Iterator[None]:
    """End the process when a signal comes or the process ``run`` dies, with its unfinished files removed.

    The exit status is 128 plus the number of the signal. A signal that the process ignores, as SIGHUP under ``nohup``,
    stays ignored. Outside the main thread, where Python accepts no handlers, signals keep their effect.

    Parameters
    ----------
    say : shows why the process ends: the name of a signal, or the empty text where the run died
    run : id of the process whose death ends this one; with it, handlers stay in place after the block, since the
        process ends after it. None: the handlers of before are restored.
    """
    readable, writable = os.pipe()
    os.set_blocking(writable, False)
    watcher = threading.Thread(target=_watch, args=(readable, run, say), daemon=True)
    watcher.start()
    before = {}
    if threading.current_thread() is threading.main_thread():
        signal.set_wakeup_fd(writable, warn_on_full_buffer=False)
        caught = [number for number in SIGNALS if signal.getsignal(number) != signal.SIG_IGN]
        before = {number: signal.signal(number, lambda *_: None) for number in caught}
        # They may have been blocked until here, so that imports are not interrupted (visualspeech.jobs).
        signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    try:
        yield
    finally:
        while _stopping.is_set():  # what fails because its files are removed is not reported
            time.sleep(1)
        if run is None:
            for number, handler in before.items():
                signal.signal(number, handler)
            if before:
                signal.set_wakeup_fd(-1)
            os.write(writable, b"\0")
            watcher.join()
            os.close(readable)
            os.close(writable)


def _watch(signals: int, run: int | None, say: Callable[[str], None]) -> None:
    """Wait for a signal or the death of the run, and end the process; 0 in the pipe ends the watch."""
    poll = select.poll()
    poll.register(signals, select.POLLIN)
    watched = None
    if run is not None:
        try:
            watched = os.pidfd_open(run)  # readable when the process ends
            poll.register(watched, select.POLLIN)
        except (AttributeError, OSError):
            pass  # not Linux, or it has ended: it is looked at twice per second instead
    while True:
        ready = {file for file, _ in poll.poll(500 if run is not None and watched is None else None)}
        if signals in ready:
            number = os.read(signals, 1)[0]
            if number == 0:
                return
            if number in SIGNALS:
                _stop(128 + number, signal.Signals(number).name, say)
        elif watched in ready or (run is not None and not is_alive(run)):
            _stop(128 + signal.SIGTERM, "", say)


def _stop(status: int, reason: str, say: Callable[[str], None]) -> None:
    try:
        _stopping.set()
        give_up()
        say(reason)
    finally:
        os._exit(status)
