import threading

import pytest

from visualspeech.errors import DataError
from visualspeech.media.prefetching import prefetched


def test_a_thread_makes_items_in_their_order_and_tells_its_errors():
    assert list(prefetched(range(1000), 3)) == list(range(1000))

    def broken():
        yield 1
        raise DataError("no more")

    taken = prefetched(broken(), 2)
    assert next(taken) == 1
    with pytest.raises(DataError, match="no more"):
        next(taken)
    before = threading.active_count()
    endless = prefetched(iter(int, 1), 2)
    assert next(endless) == 0
    endless.close()  # the thread ends with its reader
    assert threading.active_count() == before
