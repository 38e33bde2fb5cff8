"""What phones ask of the lips: closures (p, b, m with both lips, f, v with lower lip and teeth), and open vowels."""

import numpy as np

from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phone_sets import arpabet_of
from visualspeech.speech.phones import CLASSES
from visualspeech.timing import frame_times

#: Class of phones (:data:`visualspeech.speech.phones.CLASSES`) -> the phones as they are named in tables.
CLOSURES = {"bilabial": "p, b, m", "labiodental": "f, v"}
#: Vowels for which the mouth opens. "ah" is none of them: it stands for the reduced vowel too.
OPEN = "open"
OPEN_VOWELS = CLASSES["open"] - {"ah"}
MARGIN = 0.04  # seconds: one frame at 25 Hz


def occurrences(opening: np.ndarray, alignment: Alignment, rate: float, name: str) -> list[tuple[int, int]]:
    """Number in the phone tier, and frame of the least opening, of each occurrence of a class of phones.

    An occurrence lasts from :data:`MARGIN` seconds before the phone to :data:`MARGIN` seconds after it; occurrences
    outside the frames are left out.

    Parameters
    ----------
    opening : (T,) at ``rate`` Hz
    name : class of phones
    """
    times, found = frame_times(len(opening), rate), []
    for number, phone in enumerate(alignment.phones):
        if arpabet_of(phone.label) in CLASSES[name]:
            inside = np.flatnonzero((times >= phone.start - MARGIN) & (times <= phone.end + MARGIN))
            if len(inside):
                found.append((number, int(inside[np.argmin(opening[inside])])))
    return found


def least_openings(opening: np.ndarray, alignment: Alignment, rate: float, name: str) -> np.ndarray:
    """Least opening in each occurrence of a class of phones, (n,); see :func:`occurrences`."""
    return np.asarray(opening)[[frame for _, frame in occurrences(opening, alignment, rate, name)]]


def closing_frames(opening: np.ndarray, alignment: Alignment, rate: float) -> np.ndarray:
    """Frames (n,), ascending, in which the lips are least open in an occurrence of any class of :data:`CLOSURES`."""
    every = (frame for name in CLOSURES for _, frame in occurrences(opening, alignment, rate, name))
    return np.array(sorted(set(every)), int)


def open_frames(opening: np.ndarray, alignment: Alignment, rate: float) -> np.ndarray:
    """Frame of the greatest opening within each open vowel, (n,); vowels that hold no frame are left out."""
    times, opening = frame_times(len(opening), rate), np.asarray(opening)
    vowels = [(one.start, one.end) for one in alignment.phones if arpabet_of(one.label) in OPEN_VOWELS]
    inside = [np.flatnonzero((times >= start) & (times < end)) for start, end in vowels]
    return np.array([frames[np.argmax(opening[frames])] for frames in inside if len(frames)], int)


def greatest_openings(opening: np.ndarray, alignment: Alignment, rate: float) -> np.ndarray:
    """Greatest opening within each open vowel, (n,); see :func:`open_frames`."""
    return np.asarray(opening)[open_frames(opening, alignment, rate)]
