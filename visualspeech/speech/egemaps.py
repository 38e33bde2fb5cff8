"""The 17 low-level descriptors of eGeMAPS that MFCC, F0 and energy do not cover, by openSMILE (Sadoughi 2017, 3.2).

eGeMAPS v01b (Eyben et al. 2016) has 23. F0, loudness and four MFCC are left out. openSMILE is licensed for research
only, so the package ``opensmile`` is an optional extra (``docs/licences.md``).
"""

import warnings
from functools import cache
from importlib.util import find_spec

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech.sound import Sound, between_voiced

#: As openSMILE calls them, in its order.
NAMES = (
    "alphaRatio", "hammarbergIndex", "slope0-500", "slope500-1500", "spectralFlux", "jitterLocal", "shimmerLocaldB",
    "HNRdBACF", "logRelF0-H1-H2", "logRelF0-H1-A3", "F1frequency", "F1bandwidth", "F1amplitudeLogRelF0", "F2frequency",
    "F2amplitudeLogRelF0", "F3frequency", "F3amplitudeLogRelF0",
)  # fmt: skip
#: Descriptors of periods and harmonics, which only voiced frames have. Their windows last 60 ms, those of others 20 ms.
VOICED = {name for name in NAMES if name.startswith(("jitter", "shimmer", "HNR", "logRel")) or "amplitude" in name}
STEP = 0.01  # seconds between frames
MARGIN = 0.1  # seconds of sound before and after the wanted times, more than a window
_CENTRES = {True: 0.03, False: 0.01}  # seconds from a frame's beginning, by whether its window is of 60 ms
_F0 = "F0semitoneFrom27.5Hz"


def missing() -> str:
    """Why the descriptors cannot be computed, and what to do about it; empty where openSMILE is installed."""
    if find_spec("opensmile"):
        return ""
    return (
        "the package opensmile is not installed. Install it with `pip install -e '.[egemaps]'` (its licence allows "
        "research only), or use `kind: speech27`, the 27 features that Praat computes."
    )


def descriptors(sound: Sound, times: np.ndarray) -> np.ndarray:
    """The descriptors at ``times`` (T,) in seconds, ascending, (T, 17) float64.

    openSMILE has a frame every 10 ms; between frame centres values are interpolated linearly. Those of voiced
    frames are interpolated through unvoiced stretches too, and NaN where no frame is voiced.

    Raises
    ------
    DataError
        openSMILE is not installed.
    """
    if missing():
        raise DataError(missing())
    begin = round((times[0] - MARGIN) * sound.rate)
    samples = sound.between(begin, round((times[-1] + MARGIN) * sound.rate))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a set of version v01b is called deprecated each time
        found = _opensmile()(samples.astype(np.float32), round(sound.rate))[0]
    names = [name.partition("_sma")[0] for name in _opensmile().feature_names]
    voiced = found[names.index(_F0)] > 0
    starts, result = begin / sound.rate + STEP * np.arange(found.shape[1]), np.empty((len(times), len(NAMES)))
    for column, name in enumerate(NAMES):
        values = found[names.index(name)].astype(np.float64)
        if name in VOICED:
            values = between_voiced(np.where(voiced, values, np.nan))
        result[:, column] = np.interp(times, starts + _CENTRES[name in VOICED], values)
    return result


@cache
def _opensmile():
    import opensmile

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return opensmile.Smile(opensmile.FeatureSet.eGeMAPSv01b, opensmile.FeatureLevel.LowLevelDescriptors)
