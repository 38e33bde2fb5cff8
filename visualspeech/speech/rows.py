"""Alignment tables as rows of utterances, for stages that need times and labels and no aligner."""

from pathlib import Path

import numpy as np

from visualspeech.storage import read_table
from visualspeech.timing import frame_times, interval_of_frame

SILENCE = "sil"


def read_alignment_table(path: str | Path):
    """A table of alignments as a data frame: id, tier, index, parent, label, start, end (seconds)."""
    return read_table(path, ("id", "tier", "label"))


def read_alignment_rows(path: str | Path) -> dict:
    """The rows of each utterance of a table: id -> data frame."""
    return {str(name): rows for name, rows in read_alignment_table(path).groupby("id", sort=False)}


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
