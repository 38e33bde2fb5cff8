"""Alignments of evenly spaced phones, for tests of what reads alignments."""

import numpy as np

from visualspeech.speech.alignment import Alignment, Segment


def even_alignment(words, step=0.1):
    """Every phone lasts ``step`` seconds, with three equal states.

    Parameters
    ----------
    words : (word, phones) in their order
    """
    tiers = ([], [], [])
    for word, spoken in words:
        begin = len(tiers[1]) * step
        for phone in spoken:
            start = len(tiers[1]) * step
            borders = np.linspace(start, start + step, 4).tolist()
            tiers[2].extend(Segment(str(k + 1), borders[k], borders[k + 1], len(tiers[1])) for k in range(3))
            tiers[1].append(Segment(phone, start, start + step, len(tiers[0])))
        tiers[0].append(Segment(word, begin, len(tiers[1]) * step))
    return Alignment(*map(tuple, tiers))


def spoken(*phones) -> Alignment:
    """An alignment of (phone, seconds), one after the other, in one word and without states."""
    segments, start = [], 0.0
    for label, seconds in phones:
        segments.append(Segment(label, start, start + seconds, 0))
        start += seconds
    return Alignment((Segment("word", 0.0, start),), tuple(segments), ())
