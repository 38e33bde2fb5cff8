"""Contextual labels at the visual frame rate: triphone and HMM state of every frame (Fan 2015, section 3.1).

A frame's label is kept as four small integers (left, current, right phone and state); :func:`one_hot` expands them to
the 3K + 3 vector of the paper where a model needs it. :func:`label_shares` gives that vector averaged over the frame.
"""

from collections.abc import Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.contexts import phone_contexts
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.phones import STATES
from visualspeech.timing import frame_times, interval_of_frame

#: Where the states of a phone begin: where forced alignment puts them, or at the thirds of the phone.
DIVISIONS = ("aligned", "thirds")


def label_indices(
    alignment: Alignment, frames: int, rate: float, phones: Sequence[str], states: str = "aligned"
) -> np.ndarray:
    """Label of every frame of one utterance: (frames, 4) int16 of left, current and right phone index and state 0..2.

    Frame i belongs to the state that is spoken at (i + 0.5) / rate seconds. The neighbours of a phone are those of the
    whole utterance, across words; before the first and after the last phone there is silence.

    Parameters
    ----------
    frames, rate : number of frames and frame rate (Hz) of the visual stream
    phones : inventory, see :func:`visualspeech.features.contexts.phone_inventory`
    states : of :data:`DIVISIONS`

    Raises
    ------
    DataError
        A phone is not in the inventory, or the alignment has no phones, no states, or states that do not fit its
        phones.
    """
    starts, labels = state_labels(alignment, phones, states)
    return labels[interval_of_frame(starts, frame_times(frames, rate))].astype(np.int16)


def label_shares(
    alignment: Alignment, frames: int, rate: float, phones: Sequence[str], states: str = "aligned"
) -> np.ndarray:
    """Share of every frame that each phone and state fills: (frames, 3K + 3) float32, columns as in :func:`one_hot`.

    The shares of the left phones add up to 1, as do those of the current phones, the right phones and the states.
    Parameters and errors are those of :func:`label_indices`.
    """
    starts, labels = state_labels(alignment, phones, states)
    return mean_over_frames(one_hot(labels, len(phones)), starts, frames, rate)


def state_labels(alignment: Alignment, phones: Sequence[str], states: str) -> tuple[np.ndarray, np.ndarray]:
    """Start in seconds (S,) of every state of an utterance, and its label (S, 4), see :func:`label_indices`."""
    triphones = phone_contexts(alignment, phones)
    if states == "thirds":
        starts, parents, numbers = _thirds(alignment)
    else:
        starts = starts_of(alignment.states)
        parents = np.array([one.parent for one in alignment.states], int)
        numbers = np.array([int(one.label) for one in alignment.states], int) - 1
    if not _valid(parents, len(triphones)) or not _valid(numbers, STATES):
        raise DataError(
            "the states of the alignment do not fit its phones; delete the alignment files and align again."
        )
    return starts, np.column_stack([triphones[parents], numbers])


def _thirds(alignment: Alignment) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starts of the states of evenly divided phones, the phones that they belong to, and their numbers."""
    starts = starts_of(alignment.phones)
    ends = np.r_[starts[1:], alignment.phones[-1].end]
    numbers = np.tile(np.arange(STATES), len(starts))
    parents = np.repeat(np.arange(len(starts)), STATES)
    return starts[parents] + (ends - starts)[parents] * numbers / STATES, parents, numbers


def mean_over_frames(values: np.ndarray, starts: np.ndarray, frames: int, rate: float) -> np.ndarray:
    """Mean over every frame of what is constant in each of some intervals: (frames, D) float32.

    Frame i lasts from i / rate to (i + 1) / rate seconds. Intervals are those of
    :func:`visualspeech.timing.interval_of_frame`: the first reaches back and the last on for ever.

    Parameters
    ----------
    values : (S, D) of the intervals
    starts : (S,) seconds, ascending
    """
    edges = np.arange(frames + 1) / rate
    cuts = np.unique(np.r_[edges, starts[(starts > 0) & (starts < edges[-1])]])
    middles = (cuts[1:] + cuts[:-1]) / 2
    parts = (np.diff(cuts) * rate)[:, None] * values[interval_of_frame(starts, middles)]
    # Every frame begins at a cut, so its parts follow each other.
    return np.add.reduceat(parts, np.searchsorted(cuts, edges[:-1]), axis=0).astype(np.float32)


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
