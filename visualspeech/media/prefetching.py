"""Prefetching of a stream: a thread makes the next items while earlier ones are used."""

from collections.abc import Iterable, Iterator
from queue import Full, Queue
from threading import Event, Thread


def prefetched(items: Iterable, ahead: int) -> Iterator:
    """Yield the items of a stream in order; a separate thread makes them up to ``ahead`` items early.

    An exception in the thread is raised where the items are taken.
    """
    waiting: Queue = Queue(maxsize=ahead)
    stopped = Event()

    def put(tag: str, value) -> bool:
        while not stopped.is_set():
            try:
                waiting.put((tag, value), timeout=0.2)
                return True
            except Full:
                continue
        return False

    def work() -> None:
        try:
            for item in items:
                if not put("item", item):
                    return
            put("end", None)
        except BaseException as error:  # raised again by the consumer
            put("error", error)

    thread = Thread(target=work, daemon=True)
    thread.start()
    try:
        while True:
            tag, value = waiting.get()
            if tag == "error":
                raise value
            if tag == "end":
                return
            yield value
    finally:
        stopped.set()
        thread.join()
