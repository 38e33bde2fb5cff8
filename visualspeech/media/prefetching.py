"""Two cores for one stream: its items are made by a thread while those before them are used."""

from collections.abc import Iterable, Iterator
from queue import Full, Queue
from threading import Event, Thread


def prefetched(items: Iterable, ahead: int) -> Iterator:
    """The items of a stream, in their order, made up to ``ahead`` items early by a thread of its own."""
    waiting: Queue = Queue(maxsize=ahead)
    stopped = Event()

    def put(kind: str, value) -> bool:
        while not stopped.is_set():
            try:
                waiting.put((kind, value), timeout=0.2)
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
        except BaseException as error:  # raised again where the items are taken
            put("error", error)

    thread = Thread(target=work, daemon=True)
    thread.start()
    try:
        while True:
            kind, value = waiting.get()
            if kind == "error":
                raise value
            if kind == "end":
                return
            yield value
    finally:
        stopped.set()
        thread.join()
