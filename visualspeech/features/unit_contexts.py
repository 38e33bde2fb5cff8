"""Where a frame lies in its unit, and which units are around it: for phones, dynamic visemes and any other units.

Units follow each other without gaps, from the beginning of an utterance to its end; a unit is a label with a start.
Contextual features of Thangthai et al. (2016), Table 1, of frame and segment level.
"""

from typing import NamedTuple

import numpy as np

from visualspeech.timing import frame_times, interval_of_frame

#: Values of a position: thirds of the unit or of the larger unit; "none" where there is no such unit, as in a pause.
POSITIONS = ("start", "middle", "end")
NO_POSITION = len(POSITIONS)
BEFORE = AFTER = 2  # units on either side in a segment of five (section 4.2)


class FramesInUnits(NamedTuple):
    """Each frame within its unit, (T,) each.

    Parameters
    ----------
    unit : int64, number of the unit
    position : uint8, of :data:`POSITIONS`
    count : int32, frames of the unit
    span : int32, frames of the unit from this one on, itself included; 1 in its last frame
    """

    unit: np.ndarray
    position: np.ndarray
    count: np.ndarray
    span: np.ndarray


def frames_in_units(starts: np.ndarray, frames: int, rate: float) -> FramesInUnits:
    """Where each frame of an utterance lies in its unit.

    A frame belongs to the unit at its time, see :mod:`visualspeech.timing`; a unit between two frames has none.

    Parameters
    ----------
    starts : (U,) seconds, ascending
    frames, rate : number of frames and frame rate in Hz
    """
    unit = interval_of_frame(starts, frame_times(frames, rate))
    # The units are ascending, so the frames of each follow each other.
    first, end = np.searchsorted(unit, unit, side="left"), np.searchsorted(unit, unit, side="right")
    number = np.arange(frames)
    count = (end - first).astype(np.int32)
    return FramesInUnits(unit, positions(number - first + 1, count), count, (end - number).astype(np.int32))


def positions(number: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Position of the ``number``-th of ``count`` units in a larger one: uint8, a third of :data:`POSITIONS`, or none.

    The third is that in which the middle of the unit lies if all are equally long: the first of two is at the start,
    the second at the end, and a single one is in the middle.

    Parameters
    ----------
    number : from 1; 0 for a unit that belongs to no larger one, which gives :data:`NO_POSITION`
    count : of the same shape
    """
    number, count = np.asarray(number, np.int64), np.asarray(count, np.int64)
    third = len(POSITIONS) * (2 * number - 1) // np.maximum(2 * count, 1)
    return np.where(number > 0, third, NO_POSITION).astype(np.uint8)


def neighbours(labels: np.ndarray, outside: int, before: int = BEFORE, after: int = AFTER) -> np.ndarray:
    """The labels of each unit and of those around it, (U, before + 1 + after) of the type of ``labels``.

    Parameters
    ----------
    labels : (U,) integers
    outside : label of what precedes the first and follows the last unit
    """
    labels = np.asarray(labels)
    padded = np.pad(labels, (before, after), constant_values=outside)
    return np.lib.stride_tricks.sliding_window_view(padded, before + 1 + after).copy()
