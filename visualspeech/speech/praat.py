"""MFCC, F0 and energy of a piece of sound by Praat (``praat-parselmouth``), each at the frames that are asked for.

Praat centres the frames of an analysis in the sound that it is given, and each analysis has windows of its own length:
the frames of MFCC, pitch and intensity lie at different times. Each analysis is therefore given just the sound that
holds the wanted frames and its own windows around them, so that all have their frames at the same times.
"""

import numpy as np

from visualspeech.speech.sound import Sound

RATE = 120.0  # Hz; a frame every 8.3 ms (Sadoughi 2017, section 3.2)
WINDOW = 0.025  # seconds; effective length of the windows of MFCC and energy (Sadoughi 2017, section 3.2)
COEFFICIENTS = 25
FILTER_DISTANCE = 100.0  # mel; Praat's own value, with which sound of 16 kHz has enough filters for 25 coefficients
SILENCE = 0.0  # dB re 20 uPa, 91 dB below a sine at full scale: about the rounding of 16-bit samples
PERIODS = 3.0  # of the lowest F0, in a window of the pitch analysis
_INTENSITY = 3.2  # effective length of Praat's intensity window in periods of its lowest pitch; it is cut at twice this


def mfcc(sound: Sound, first: int, last: int) -> np.ndarray:
    """Mel-frequency cepstral coefficients 1 to 25 of frames ``first`` to ``last`` (exclusive), (T, 25) float64.

    Coefficient 0 is left out, because energy is a feature of its own. The windows are Gaussian.
    """
    # One more frame on either side, because parselmouth 0.4.7 gives one coefficient alone of a single frame.
    piece = _piece(sound, first - 1, last + 1, 2 * WINDOW)
    found = piece.to_mfcc(COEFFICIENTS, WINDOW, 1 / RATE, FILTER_DISTANCE, FILTER_DISTANCE)
    return found.to_array()[1:, 1:-1].T


def energy(sound: Sound, first: int, last: int) -> np.ndarray:
    """Intensity of frames ``first`` to ``last`` (exclusive) in dB re 20 uPa, (T,) float64, at least :data:`SILENCE`.

    Praat takes samples as pascals: a sine of amplitude a has 20 log10(a / sqrt(2) / 2e-5) dB.
    """
    piece = _piece(sound, first, last, 2 * WINDOW)
    return np.maximum(piece.to_intensity(_INTENSITY / WINDOW, 1 / RATE).values[0], SILENCE)


def f0(sound: Sound, first: int, last: int, floor: float, ceiling: float) -> np.ndarray:
    """F0 of frames ``first`` to ``last`` (exclusive) in Hz, (T,) float64, NaN where unvoiced (autocorrelation method).

    The window holds three periods of the lowest F0, as Praat needs to find it: 40 ms at 75 Hz. One of 25 ms would find
    nothing below 120 Hz, which is most of a man's speech.

    Parameters
    ----------
    floor, ceiling : lowest and highest F0 in Hz
    """
    found = _piece(sound, first, last, PERIODS / floor).to_pitch(1 / RATE, floor, ceiling)
    hertz = found.selected_array["frequency"]
    return np.where(hertz > 0, hertz, np.nan)


def _piece(sound: Sound, first: int, last: int, window: float):
    """The sound in which an analysis with windows of ``window`` seconds has just the frames ``first`` to ``last``.

    Praat makes floor((duration - window) / step) + 1 frames and centres them; half a step less than one more frame
    would need keeps rounding from changing their number.
    """
    import parselmouth

    count = round(((last - first - 0.5) / RATE + window) * sound.rate)
    begin = round((first + last) / 2 / RATE * sound.rate - count / 2)
    return parselmouth.Sound(sound.between(begin, begin + count), sound.rate)
