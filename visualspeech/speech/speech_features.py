"""The speech features of Sadoughi 2017 (section 3.2): 25 MFCC, log F0 and energy, and 17 descriptors of eGeMAPS.

All are computed at one grid of times, a frame every 8.3 ms (:data:`visualspeech.speech.praat.RATE`) from the beginning
of the recording, frame i at (i + 0.5) / rate. The grid is cut at fixed times into stretches of 20 s, and each is
analysed with some sound around it. Memory does not grow with the recording, and a part of a recording has the features
that it has as a part of the whole.

F0 is taken as its logarithm. It and the descriptors of voiced frames are interpolated linearly through unvoiced
stretches and constant before the first and after the last voiced frame.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech import egemaps, praat
from visualspeech.speech.praat import COEFFICIENTS, RATE
from visualspeech.speech.sound import BLOCK, Sound, between_voiced
from visualspeech.speech.sound import RATE as SOUND_RATE
from visualspeech.timing import frames_in

#: Names of the 27 features, in their order.
PRAAT_NAMES = (*(f"mfcc{number}" for number in range(1, COEFFICIENTS + 1)), "log_f0", "energy")
#: Names of the 44 features, in their order.
ALL_NAMES = (*PRAAT_NAMES, *egemaps.NAMES)
STRETCH = round(BLOCK * RATE)  # frames that are analysed at a time
CONTEXT = round(1.0 * RATE)  # frames before and after a stretch in which F0 is tracked too


@dataclass(frozen=True)
class Extractor:
    """What computes the features of a sound.

    Parameters
    ----------
    descriptors : whether the 17 descriptors of eGeMAPS follow the 27 features of Praat
    pitch_floor, pitch_ceiling : lowest and highest F0 in Hz
    """

    descriptors: bool
    pitch_floor: float
    pitch_ceiling: float

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the features, in their order."""
        return ALL_NAMES if self.descriptors else PRAAT_NAMES

    def frames(self, sound: Sound) -> int:
        """Number of frames of a sound, at least one."""
        return max(frames_in(sound.seconds, RATE), 1)

    def features(self, sound: Sound, first: int, last: int) -> np.ndarray:
        """Features of frames ``first`` to ``last`` (exclusive) of a sound, (T, D) float64.

        A feature of voiced frames is NaN where no frame around is voiced.

        Raises
        ------
        DataError
            The sound has another sample rate than recordings are kept at, or openSMILE is needed and missing.
        """
        numbers = range(first // STRETCH, (last - 1) // STRETCH + 1)
        found = [_stretch(self, sound, number) for number in numbers]
        begin = numbers[0] * STRETCH
        return np.concatenate(found)[first - begin : last - begin]


@lru_cache(maxsize=2)  # the pieces of a long recording follow each other and share stretches
def _stretch(extractor: Extractor, sound: Sound, number: int) -> np.ndarray:
    """Features of one stretch of a sound, read only."""
    if sound.rate != SOUND_RATE:
        raise DataError(
            f"speech features are computed from sound of {SOUND_RATE} Hz, not of {sound.rate:g} Hz; resample it."
        )
    total = extractor.frames(sound)
    first, last = number * STRETCH, min((number + 1) * STRETCH, total)
    before, after = max(first - CONTEXT, 0), min(last + CONTEXT, total)
    own = slice(first - before, last - before)
    hertz = praat.f0(sound, before, after, extractor.pitch_floor, extractor.pitch_ceiling)
    found = [
        praat.mfcc(sound, first, last),
        between_voiced(np.log(hertz))[own, None],
        praat.energy(sound, first, last)[:, None],
    ]
    if extractor.descriptors:
        found.append(egemaps.descriptors(sound, (np.arange(before, after) + 0.5) / RATE)[own])
    result = np.hstack(found)
    result.setflags(write=False)
    return result
