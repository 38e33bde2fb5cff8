"""The phones of an utterance with their times, and as runs of frames."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.timing import frame_times, interval_of_frame

SILENCE = "sil"


@dataclass(frozen=True)
class PhoneTrack:
    """The phones of an utterance in time.

    Parameters
    ----------
    triphones : (P, 3) int, left, current and right phone as indices of the inventory
    starts : (P,) seconds, ascending; a phone ends where the next one starts
    """

    triphones: np.ndarray
    starts: np.ndarray

    def runs(self, frames: int, rate: float) -> tuple[np.ndarray, np.ndarray]:
        """Triphones (Q, 3) and lengths (Q,) of the runs of frames that share a phone.

        A frame belongs to the phone that is spoken at its middle (:mod:`visualspeech.timing`); a phone so short that no
        frame's middle lies in it is left out.
        """
        at = interval_of_frame(self.starts, frame_times(frames, rate))
        phones, lengths = np.unique(at, return_counts=True)
        return self.triphones[phones], lengths


def phone_track(rows, phones: Sequence[str]) -> PhoneTrack:
    """The phone tier of one utterance's alignment; before the first and after the last phone there is silence.

    Parameters
    ----------
    rows : alignment (columns tier, index, label, start; seconds)
    phones : the inventory

    Raises
    ------
    DataError
        There is no phone, or one that is not in the inventory.
    """
    spoken = rows[rows["tier"] == "phone"].sort_values("index")
    position = {phone: number for number, phone in enumerate(phones)}
    unknown = sorted(set(spoken["label"]) - set(position))
    if unknown or not len(spoken):
        what = f"phones that the model does not know: {', '.join(unknown)}" if unknown else "no phones"
        raise DataError(f"the alignment holds {what}. Train the model on the corpus that it is to speak for.")
    current = np.array([position[label] for label in spoken["label"]])
    silence = position.get(SILENCE, 0)
    triphones = np.stack([np.r_[silence, current[:-1]], current, np.r_[current[1:], silence]], axis=1)
    return PhoneTrack(triphones, spoken["start"].to_numpy(float))
