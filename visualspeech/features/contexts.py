"""Phones with their neighbours: the contexts that labels and phone HMMs are built on."""

from collections.abc import Iterable, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import SILENCE
from visualspeech.storage.tables import read_table, write_table


def phone_inventory(alignments: Iterable[Alignment]) -> list[str]:
    """The phones of the training utterances, silence first and the others sorted: K entries."""
    found = {one.label for alignment in alignments for one in alignment.phones}
    return [SILENCE, *sorted(found - {SILENCE})]


def write_phones(path, phones: Sequence[str]) -> None:
    """Write an inventory as a table with the column ``phone``."""
    import pandas

    write_table(path, pandas.DataFrame({"phone": list(phones)}))


def read_phones(path) -> list[str]:
    """The inventory of a table with the column ``phone``, in its order."""
    return read_table(path, ("phone",), required=("phone",))["phone"].tolist()


def phone_contexts(alignment: Alignment, phones: Sequence[str], before: int = 1, after: int = 1) -> np.ndarray:
    """Each phone of an utterance with its neighbours, (P, before + 1 + after) int, as indices of the inventory.

    Column ``before`` is the phone itself. Neighbours are those of the whole utterance, across words and pauses; beyond
    its ends there is silence. The defaults give triphones; quinphones have two neighbours on either side.

    Parameters
    ----------
    phones : inventory, see :func:`phone_inventory`
    before, after : number of neighbours on the left and on the right

    Raises
    ------
    DataError
        The alignment has no phones, or phones that are not in the inventory, or the inventory has no silence.
    """
    if not alignment.phones:
        raise DataError("the alignment has no phones; delete the alignment files and align again.")
    index = {phone: number for number, phone in enumerate(phones)}
    labels = [one.label for one in alignment.phones]
    unknown = sorted({SILENCE, *labels} - set(index))
    if unknown:
        raise DataError(
            f"the inventory of {len(phones)} phones does not have {', '.join(unknown)}. If it is that of the same "
            "corpus, delete phones.tsv and the features and run again; if it is that of a trained model, train the "
            "model on the corpus that it is used for."
        )
    padded = [SILENCE] * before + labels + [SILENCE] * after
    numbers = np.array([index[label] for label in padded])
    return np.lib.stride_tricks.sliding_window_view(numbers, before + 1 + after).copy()
