"""Mouth movement from phones, with coarticulation by dominance functions.

Cohen and Massaro, "Modeling coarticulation in synthetic visual speech" (1993): every phone s has a target T_sp for
every mouth parameter p and a dominance that decays exponentially before and after its centre,
``D_sp(t) = alpha_sp exp(-theta |t - centre_s|)``; the movement is the mean of the targets weighted by dominance,
``F_p(t) = sum_s D_sp(t) T_sp / sum_s D_sp(t)``. Here the decay begins at the phone's borders, not at its centre, so
that a long phone holds its target. The opening of p, b and m has a target below zero: a closed mouth with the lips
pressed together.
"""

import numpy as np

PARAMETERS = ("opening", "jaw", "width", "rounding", "labiodental", "tongue")
"""Distance of the inner lips (canonical pixels, negative: pressed), drop of the chin (canonical pixels), spreading of
the corners (-1 to 1), rounding (0 to 1), lower lip under the upper teeth (0 to 1), tongue tip up (0 to 1)."""

# Targets of opening, jaw, width, rounding, labiodental, tongue; strengths alpha of lips, jaw, rounding, tongue.
_TARGETS = {
    "sil": ((-1.0, 0.0, 0.0, 0.0, 0.0, 0.3), (0.7, 0.7, 0.4, 0.3)),
    "aa": ((15.0, 12.0, 0.0, 0.0, 0.0, 0.0), (1.0, 1.2, 0.6, 0.4)),
    "ae": ((13.0, 10.5, 0.5, 0.0, 0.0, 0.1), (1.0, 1.2, 0.6, 0.4)),
    "ah": ((9.0, 7.0, 0.1, 0.0, 0.0, 0.2), (0.8, 0.8, 0.4, 0.3)),
    "ao": ((11.5, 9.5, -0.4, 0.55, 0.0, 0.0), (1.0, 1.1, 0.9, 0.4)),
    "aw": ((13.0, 11.0, -0.1, 0.2, 0.0, 0.0), (1.0, 1.1, 0.6, 0.4)),
    "ay": ((13.0, 10.5, 0.2, 0.0, 0.0, 0.1), (1.0, 1.1, 0.6, 0.4)),
    "eh": ((9.5, 7.5, 0.4, 0.0, 0.0, 0.2), (0.9, 0.9, 0.6, 0.4)),
    "er": ((6.0, 5.0, -0.4, 0.5, 0.0, 0.4), (0.9, 0.8, 0.9, 0.6)),
    "ey": ((8.5, 6.0, 0.6, 0.0, 0.0, 0.3), (0.9, 0.9, 0.6, 0.4)),
    "ih": ((7.0, 5.0, 0.4, 0.0, 0.0, 0.3), (0.8, 0.8, 0.5, 0.4)),
    "iy": ((5.5, 3.5, 0.9, 0.0, 0.0, 0.4), (0.9, 0.9, 0.8, 0.5)),
    "ow": ((8.0, 7.0, -0.6, 0.8, 0.0, 0.0), (1.0, 1.0, 1.1, 0.4)),
    "oy": ((9.0, 7.5, -0.3, 0.6, 0.0, 0.0), (1.0, 1.0, 1.0, 0.4)),
    "uh": ((6.5, 5.5, -0.5, 0.6, 0.0, 0.1), (0.9, 0.9, 0.9, 0.4)),
    "uw": ((3.8, 3.5, -0.9, 1.0, 0.0, 0.1), (1.2, 1.0, 1.3, 0.4)),
    "p": ((-4.5, 1.5, 0.0, 0.0, 0.0, 0.2), (5.0, 0.9, 0.15, 0.1)),
    "b": ((-4.0, 2.0, 0.0, 0.0, 0.0, 0.2), (5.0, 0.9, 0.15, 0.1)),
    "m": ((-3.5, 1.5, 0.0, 0.0, 0.0, 0.2), (5.0, 0.9, 0.15, 0.1)),
    "f": ((1.2, 1.5, 0.1, 0.0, 1.0, 0.1), (4.0, 1.2, 0.3, 0.1)),
    "v": ((1.4, 1.8, 0.1, 0.0, 1.0, 0.1), (4.0, 1.2, 0.3, 0.1)),
    "w": ((2.0, 3.0, -1.0, 1.0, 0.0, 0.1), (2.0, 1.0, 1.8, 0.3)),
    "th": ((5.0, 3.5, 0.2, 0.0, 0.0, 1.0), (1.0, 1.0, 0.4, 2.5)),
    "dh": ((5.0, 3.5, 0.2, 0.0, 0.0, 0.9), (0.8, 0.9, 0.3, 2.0)),
    "t": ((4.5, 2.2, 0.2, 0.0, 0.0, 0.8), (0.5, 0.9, 0.2, 1.6)),
    "d": ((4.5, 2.5, 0.2, 0.0, 0.0, 0.8), (0.5, 0.9, 0.2, 1.6)),
    "n": ((4.8, 3.0, 0.2, 0.0, 0.0, 0.8), (0.5, 0.8, 0.2, 1.6)),
    "l": ((6.0, 4.5, 0.1, 0.0, 0.0, 0.9), (0.6, 0.8, 0.2, 1.8)),
    "s": ((3.6, 0.8, 0.4, 0.0, 0.0, 0.6), (0.9, 1.8, 0.4, 1.0)),
    "z": ((3.6, 0.8, 0.4, 0.0, 0.0, 0.6), (0.9, 1.8, 0.4, 1.0)),
    "sh": ((5.0, 1.2, -0.5, 0.75, 0.0, 0.5), (1.3, 1.8, 1.2, 1.0)),
    "zh": ((5.0, 1.2, -0.5, 0.75, 0.0, 0.5), (1.3, 1.8, 1.2, 1.0)),
    "ch": ((4.8, 1.2, -0.5, 0.7, 0.0, 0.6), (1.3, 1.8, 1.2, 1.0)),
    "jh": ((4.8, 1.2, -0.5, 0.7, 0.0, 0.6), (1.3, 1.8, 1.2, 1.0)),
    "r": ((4.5, 3.5, -0.6, 0.65, 0.0, 0.5), (0.9, 0.8, 1.0, 0.8)),
    "y": ((5.0, 3.0, 0.7, 0.0, 0.0, 0.4), (0.7, 0.8, 0.6, 0.5)),
    "k": ((5.5, 4.0, 0.1, 0.0, 0.0, 0.1), (0.4, 0.5, 0.15, 0.5)),
    "g": ((5.5, 4.0, 0.1, 0.0, 0.0, 0.1), (0.4, 0.5, 0.15, 0.5)),
    "ng": ((5.5, 4.0, 0.1, 0.0, 0.0, 0.1), (0.4, 0.5, 0.15, 0.5)),
    "hh": ((6.5, 5.0, 0.1, 0.0, 0.0, 0.1), (0.3, 0.3, 0.1, 0.2)),
}
# Second vowel of each diphthong.
_GLIDES = {"aw": "uw", "ay": "iy", "ey": "iy", "ow": "uw", "oy": "iy"}
_STRENGTH_OF = (0, 1, 2, 2, 0, 3)  # index of the strength that applies to each parameter
# Decay rates theta per second, before and after the phone: lips and tongue are fast, jaw and rounding slow.
_DECAY = np.array([[24.0, 24.0], [15.0, 15.0], [13.0, 15.0], [13.0, 15.0], [26.0, 26.0], [22.0, 22.0]])
_DECAY_OF_CLOSURE = 56.0
CLOSED = ("p", "b", "m")
LABIODENTAL = ("f", "v")


def movement(phones: list[tuple[str, float, float]], times: np.ndarray, size: float = 1.0) -> np.ndarray:
    """Mouth parameters at given times.

    Parameters
    ----------
    phones : (ARPAbet, start, end) in seconds
    times : (T,) seconds
    size : opening of the mouth as a multiple of normal speech

    Returns
    -------
    (T, 6) in the order of ``PARAMETERS``
    """
    segments = _segments(phones)
    start = np.array([segment[1] for segment in segments])
    end = np.array([segment[2] for segment in segments])
    targets = np.array([_TARGETS[segment[0]][0] for segment in segments])
    strengths = np.array([_TARGETS[segment[0]][1] for segment in segments])[:, _STRENGTH_OF]
    targets = targets * np.where(targets > 0, [size, size, 1, 1, 1, 1], 1.0)
    closures = np.array([segment[0] in CLOSED or segment[0] in LABIODENTAL for segment in segments])
    before = np.maximum(start[None] - times[:, None], 0.0)[..., None]
    after = np.maximum(times[:, None] - end[None], 0.0)[..., None]
    decay = np.tile(_DECAY, (len(segments), 1, 1))
    decay[np.ix_(closures, [0, 4])] = _DECAY_OF_CLOSURE
    dominance = strengths[None] * np.exp(-decay[None, :, :, 0] * before - decay[None, :, :, 1] * after)
    return (dominance * targets[None]).sum(axis=1) / dominance.sum(axis=1)


def _segments(phones: list[tuple[str, float, float]]) -> list[tuple[str, float, float]]:
    """The phones with their borders moved inwards, which leaves time for transitions; diphthongs become two phones."""
    segments = []
    for phone, start, end in phones:
        length = end - start
        margin = (0.12 if phone in CLOSED else 0.3) * min(length, 0.2)
        if phone in _GLIDES:
            segments.append((phone, start + margin, start + 0.5 * length))
            segments.append((_GLIDES[phone], end - margin, end - 0.5 * margin))
        else:
            segments.append((phone, start + margin, end - margin))
    return segments
