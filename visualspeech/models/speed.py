"""How fast a model predicts, measured while it does."""

from collections.abc import Callable, Iterable, Iterator
from time import process_time

import numpy as np

from visualspeech.storage.tables import read_table, write_table

_COLUMNS = ("id", "seconds")


def timed_predictions(predict: Callable, utterances: Iterable[tuple]) -> Iterator[tuple[str, np.ndarray, float]]:
    """Predictions of utterances, one after the other, each with the processor seconds that it took.

    Processor time does not count what other processes of the machine do meanwhile. The first utterance is predicted
    twice and timed the second time, because libraries prepare themselves in their first call.

    Parameters
    ----------
    predict : of the arguments that follow an utterance's id
    utterances : id and arguments of each
    """
    warm = False
    for name, *given in utterances:
        if not warm:
            predict(*given)
            warm = True
        begin = process_time()
        predicted = predict(*given)
        yield name, predicted, process_time() - begin


def write_speed(path, seconds: Iterable[tuple[str, float]]) -> None:
    """Write the processor seconds of each utterance's prediction as a table, sorted by id."""
    import pandas

    write_table(path, pandas.DataFrame(sorted(seconds), columns=list(_COLUMNS)))


def read_speed(path) -> dict[str, float]:
    """What :func:`write_speed` wrote: id -> processor seconds; raises as :func:`read_table`."""
    table = read_table(path, ("id",), ("seconds",), ("id",))
    return dict(zip(table["id"], table["seconds"].astype(float), strict=True))
