"""Speech and pauses of a recording by its level: what is known of it without a transcript.

The result is an alignment whose phones are pauses and the label :data:`SPEECH`, so that all that reads pauses (the face
at rest, drift, label files) reads these too.
"""

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.speech.acoustics import levels
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.forced_alignment import CHECK, NO_SPEECH
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.speech.sound import Sound

SPEECH = "spn"  # label of a stretch of speech of which no phone is known
MIN_SECONDS = 0.2  # of a recording
MIN_RANGE = 6.0  # dB between quiet and loud parts; sound of a steadier level is noise
MIN_PAUSE = 0.2  # seconds; a shorter quiet stretch may be the closure of a stop
THRESHOLD = 0.3  # share of the range in decibels from quiet (10th percentile) to loud (95th) below which is a pause
_STEP = 0.01  # seconds
_SMOOTHING = 9  # steps of a median filter, against clicks


def segmented(samples: np.ndarray, transcript: str = "") -> Alignment:
    """Speech and pauses of an utterance, in place of a forced alignment; the transcript is not used.

    Parameters
    ----------
    samples : (n,) int16, mono, 16 kHz

    Raises
    ------
    RejectedUtterance
        It is too short, or there is no speech in it.
    """
    sound = Sound(samples)
    return alignment_of(pauses(sound), 0.0, sound.seconds)


def pauses(sound: Sound) -> list[tuple[float, float]]:
    """Start and end in seconds of the pauses of a recording, ascending.

    Raises
    ------
    RejectedUtterance
        It is too short, or there is no speech in it.
    """
    from scipy.ndimage import median_filter

    if sound.seconds < MIN_SECONDS:
        raise RejectedUtterance(
            f"only {sound.seconds:.3f} s of sound, too short for speech", "Give a longer recording."
        )
    found = levels(sound, _STEP)
    found = median_filter(found, min(_SMOOTHING, len(found)), mode="nearest")
    quiet, loud = np.percentile(found, [10, 95])
    if loud - quiet < MIN_RANGE:
        raise RejectedUtterance(NO_SPEECH, CHECK)
    borders = np.flatnonzero(np.diff(np.concatenate([[0], found < quiet + THRESHOLD * (loud - quiet), [0]])))
    times = np.minimum(borders * _STEP, sound.seconds)
    times[borders == len(found)] = sound.seconds
    spans = [(float(start), float(end)) for start, end in zip(times[::2], times[1::2], strict=True)]
    # At the ends of a recording a short one is a pause too: no speech goes on there.
    return [
        (start, end) for start, end in spans
        if end - start >= MIN_PAUSE or (end > start and (start == 0 or end == sound.seconds))
    ]  # fmt: skip


def alignment_of(
    found: Iterable[tuple[float, float]], begin: float, end: float, origin: float | None = None
) -> Alignment:
    """Speech and pauses from ``begin`` to ``end`` as an alignment, which covers all of it.

    Parameters
    ----------
    found : start and end in seconds of each pause
    origin : second that is 0 in the alignment; None: ``begin``
    """
    zero = begin if origin is None else origin
    inside = [(max(a, begin) - zero, min(b, end) - zero) for a, b in found if b > begin and a < end]
    borders = [begin - zero, *(time for span in inside for time in span), end - zero]
    parts = [
        (SILENCE if number % 2 else SPEECH, start, stop)
        for number, (start, stop) in enumerate(pairwise(borders))
        if stop > start
    ] or [(SPEECH, begin - zero, end - zero)]
    tiers: tuple[list[Segment], ...] = ([], [], [])
    for label, start, stop in parts:
        tiers[0].append(Segment(label, start, stop))
        tiers[1].append(Segment(label, start, stop, len(tiers[1])))
        states = np.linspace(start, stop, STATES + 1).tolist()
        tiers[2].extend(Segment(str(k + 1), a, b, len(tiers[1]) - 1) for k, (a, b) in enumerate(pairwise(states)))
    return Alignment(*(tuple(tier) for tier in tiers))
