"""What the prediction of visemes reads of a text: phones about a frame, and the phone's neighbours, as indicators."""

from collections.abc import Sequence

import numpy as np

from visualspeech.features.contexts import phone_contexts
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.phones import SILENCE
from visualspeech.timing import frame_times, interval_of_frame

OFFSETS = np.arange(-12, 13) * 0.02  # seconds from the frame's time at which a phone is read
THIRDS = 3
_CONTEXTS = ((0,), (1,), (2,), (0, 1), (1, 2))  # of left, current and right phone, for each third of the current one


def frame_codes(alignment: Alignment, frames: int, rate: float, phones: Sequence[str]) -> np.ndarray:
    """Indicators that are 1 at each frame, (frames, C) int64: their numbers, one of each group of indicators.

    The groups are: the phone at each of :data:`OFFSETS` from the frame's time (before and after the utterance:
    silence); and, for each third of the phone at the frame's time, the left, the current and the right phone, the pair
    of the left and the current one, and that of the current and the right one.

    Parameters
    ----------
    frames, rate : number of frames and frame rate in Hz
    phones : inventory, K entries

    Raises
    ------
    DataError
        A phone is not in the inventory, or the alignment has no phones.
    """
    count, contexts = len(phones), phone_contexts(alignment, phones)
    starts = starts_of(alignment.phones)
    ends = np.append(starts[1:], alignment.phones[-1].end)
    times, silence = frame_times(frames, rate), list(phones).index(SILENCE)
    columns, first = [], 0
    for offset in OFFSETS:
        moved = times + offset
        inside = (moved >= 0) & (moved < ends[-1])
        columns.append(first + np.where(inside, contexts[interval_of_frame(starts, moved), 1], silence))
        first += count
    at = interval_of_frame(starts, times)
    share = (times - starts[at]) / np.maximum(ends - starts, 1e-9)[at]
    third = np.clip((share * THIRDS).astype(int), 0, THIRDS - 1)
    for context in _CONTEXTS:
        code = np.ravel_multi_index([*(contexts[at, one] for one in context), third], [count] * len(context) + [THIRDS])
        columns.append(first + code)
        first += count ** len(context) * THIRDS
    return np.stack(columns, axis=1).astype(np.int64)


def number_of_codes(phones: int) -> int:
    """Number of all indicators for an inventory of this size."""
    return len(OFFSETS) * phones + sum(phones ** len(context) for context in _CONTEXTS) * THIRDS


def indicators(codes: np.ndarray, known: np.ndarray):
    """Sparse 0/1 matrix (T, F) of the indicators ``known`` (F,), ascending; others of ``codes`` (T, C) are left out."""
    from scipy.sparse import csr_array

    place = np.minimum(np.searchsorted(known, codes), len(known) - 1)
    found = known[place] == codes
    ends = np.concatenate([[0], np.cumsum(found.sum(axis=1))])
    return csr_array((np.ones(ends[-1]), place[found], ends), shape=(len(codes), len(known)))
