"""Contextual labels at the visual frame rate: triphone and state of every frame (Fan 2015, section 3.1).

A frame's label is kept as four small integers (left, current, right phone and state); :func:`one_hot` expands them to
the 3K + 3 vector of the paper where a model needs it.
"""

from collections.abc import Iterable, Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.storage import read_table
from visualspeech.timing import frame_times, interval_of_frame

SILENCE = "sil"
STATES = 3


def phone_inventory(tables: Iterable) -> list[str]:
    """The phones that a corpus speaks, silence first and the others sorted: K entries.

    Parameters
    ----------
    tables : alignment tables (data frames with the columns ``tier`` and ``label``), read one at a time
    """
    found: set[str] = set()
    for table in tables:
        found.update(table.loc[table["tier"] == "phone", "label"].unique())
    return [SILENCE, *sorted(found - {SILENCE})]


def read_phones(path) -> list[str]:
    """The inventory of a table with the column ``phone``, in its order."""
    return read_table(path, ("phone",))["phone"].tolist()


def label_indices(rows, frames: int, rate: float, phones: Sequence[str]) -> np.ndarray:
    """Label of every frame of one utterance: (frames, 4) int16 of left, current, right phone index and state 0..2.

    Frame i belongs to the HMM state that is spoken at (i + 0.5) / rate seconds. The neighbours of a phone are those of
    the whole utterance, across words; before the first and after the last phone there is silence.

    Parameters
    ----------
    rows : the alignment of one utterance (columns tier, index, parent, label, start, end; seconds)
    frames, rate : length and frame rate (Hz) of the visual stream
    phones : the inventory, from :func:`phone_inventory`

    Raises
    ------
    DataError
        A phone is not in the inventory, or the alignment holds no states, or states that fit no phone.
    """
    spoken = rows[rows["tier"] == "phone"].sort_values("index")
    states = rows[rows["tier"] == "state"].sort_values("index")
    if not len(spoken) or not len(states):
        raise DataError("the alignment holds no phones or no states; delete the alignment files and align again.")
    position = {phone: number for number, phone in enumerate(phones)}
    unknown = sorted(set(spoken["label"]) - set(position))
    if unknown:
        raise DataError(
            f"the phones {', '.join(unknown)} are not in the inventory ({len(phones)} phones); "
            "delete phones.tsv and the features and run again."
        )
    current = np.array([position[label] for label in spoken["label"]])
    silence = position[SILENCE]
    triphones = np.stack([np.r_[silence, current[:-1]], current, np.r_[current[1:], silence]], axis=1)
    parents = states["parent"].to_numpy(int)
    numbers = states["label"].astype(int).to_numpy() - 1
    if parents.min() < 0 or parents.max() >= len(current) or numbers.min() < 0 or numbers.max() >= STATES:
        raise DataError("the alignment's states do not fit its phones; delete the alignment files and align again.")
    of_frame = interval_of_frame(states["start"].to_numpy(float), frame_times(frames, rate))
    return np.column_stack([triphones[parents[of_frame]], numbers[of_frame]]).astype(np.int16)


def one_hot(labels: np.ndarray, phones: int) -> np.ndarray:
    """The paper's label vectors (3.1): (..., 4) indices to (..., 3K + 3) float32 with four ones a row.

    The first three blocks of K name the left, the current and the right phone, the last block of three the state.
    """
    labels = np.asarray(labels, dtype=np.int64)
    result = np.zeros((*labels.shape[:-1], 3 * phones + STATES), dtype=np.float32)
    np.put_along_axis(result, labels + np.arange(4) * phones, 1.0, axis=-1)
    return result
