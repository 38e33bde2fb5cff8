"""Frames and seconds: frame ``i`` at rate ``r`` stands for the time ``(i + 0.5) / r``."""

import numpy as np


def frame_times(frames: int, rate: float) -> np.ndarray:
    """Times in seconds of ``frames`` frames at ``rate`` Hz, shape (frames,)."""
    return (np.arange(frames) + 0.5) / rate


def frames_in(seconds: float, rate: float) -> int:
    """Number of frames at ``rate`` Hz whose time lies inside ``seconds`` (rounded to the nearest whole frame)."""
    return int(np.floor(seconds * rate + 0.5))


def interval_of_frame(starts: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Index of the interval each time falls into.

    Intervals follow each other without gaps and begin at ``starts`` (ascending seconds); times before the first belong
    to the first, times after the last start to the last. Every assignment of labels to frames uses this function.
    """
    return np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(starts) - 1)
