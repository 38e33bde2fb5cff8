"""Contextual labels at the visual frame rate: triphone and HMM state of every frame (Fan 2015, section 3.1).

A frame's label is kept as four small integers (left, current, right phone and state); :func:`one_hot` expands them to
the 3K + 3 vector of the paper where a model needs it.
"""

from collections.abc import Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.contexts import phone_contexts
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.phones import STATES
from visualspeech.timing import frame_times, interval_of_frame


def label_indices(alignment: Alignment, frames: int, rate: float, phones: Sequence[str]) -> np.ndarray:
    """Label of every frame of one utterance: (frames, 4) int16 of left, current and right phone index and state 0..2.

    Frame i belongs to the HMM state that is spoken at (i + 0.5) / rate seconds. The neighbours of a phone are those of
    the whole utterance, across words; before the first and after the last phone there is silence.

    Parameters
    ----------
    frames, rate : number of frames and frame rate (Hz) of the visual stream
    phones : inventory, see :func:`visualspeech.features.contexts.phone_inventory`

    Raises
    ------
    DataError
        A phone is not in the inventory, or the alignment has no phones, no states, or states that do not fit its
        phones.
    """
    triphones = phone_contexts(alignment, phones)
    parents = np.array([one.parent for one in alignment.states], int)
    numbers = np.array([int(one.label) for one in alignment.states], int) - 1
    if not _valid(parents, len(triphones)) or not _valid(numbers, STATES):
        raise DataError(
            "the states of the alignment do not fit its phones; delete the alignment files and align again."
        )
    of_frame = interval_of_frame(starts_of(alignment.states), frame_times(frames, rate))
    return np.column_stack([triphones[parents[of_frame]], numbers[of_frame]]).astype(np.int16)


def _valid(indices: np.ndarray, count: int) -> bool:
    """Whether there are indices, all of them from 0 to ``count`` - 1."""
    return bool(len(indices) and indices.min() >= 0 and indices.max() < count)


def one_hot(labels: np.ndarray, phones: int) -> np.ndarray:
    """The paper's label vectors (3.1): (..., 4) indices to (..., 3K + 3) float32 with four ones per row.

    The first three blocks of K encode the left, the current and the right phone, the last block of three the state.
    """
    labels = np.asarray(labels, dtype=np.int64)
    result = np.zeros((*labels.shape[:-1], 3 * phones + STATES), dtype=np.float32)
    np.put_along_axis(result, labels + np.arange(4) * phones, 1.0, axis=-1)
    return result
