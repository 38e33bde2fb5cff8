"""Which frames of an utterance are silent, by its alignment."""

import numpy as np

from visualspeech.timing import frame_times, interval_of_frame

SILENCE = "sil"


def silent_frames(rows, frames: int, rate: float) -> np.ndarray:
    """Frames in which nobody speaks, (frames,) bool: those whose time lies in a pause of the phone tier.

    Parameters
    ----------
    rows : alignment of one utterance (data frame with the columns tier, label, start; seconds)
    frames, rate : length and rate in Hz of the visual stream
    """
    phones = rows[rows["tier"] == "phone"].sort_values("start")
    at = interval_of_frame(phones["start"].to_numpy(float), frame_times(frames, rate))
    return (phones["label"].to_numpy() == SILENCE)[at]
