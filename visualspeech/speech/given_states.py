"""States of phones whose times are given, re-estimated from the sound with the acoustic model of the recogniser.

The decoder cannot be held to given times. It aligns the given phones by itself, and the shares of a phone that its
states take there divide the given phone. Where the decoder's phone lies elsewhere, it says nothing about the given one.
"""

from dataclasses import replace

import numpy as np

from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.speech.forced_alignment import MAX_DURATION
from visualspeech.speech.phones import PHONES, SILENCE, STATES
from visualspeech.speech.recognition import RATE, padded, recognise_words

MIN_OVERLAP = 0.5  # share of the shorter one of two phones that must lie in the other
_DIGITS = 5  # decimal places of times in seconds


def recognised_states(alignment: Alignment, samples: np.ndarray, settings: AlignmentSettings) -> tuple[Alignment, int]:
    """The alignment with the states that the recogniser finds in its phones.

    Parameters
    ----------
    alignment : with states that stay where the recogniser finds none, and in pauses
    samples : (n,) int16, mono, 16 kHz

    Returns
    -------
    the alignment, and the number of phones of speech whose states stayed
    """
    spoken = [number for number, one in enumerate(alignment.phones) if one.label != SILENCE]
    found = _recognised(alignment, spoken, samples, settings)
    states, kept = list(alignment.states), 0
    for number, borders in zip(spoken, found, strict=True):
        given = alignment.phones[number]
        inner = None if borders is None else _inner(given, np.array(borders))
        if inner is None:
            kept += 1
            continue
        times = [given.start, *inner, given.end]
        for k in range(STATES):
            states[STATES * number + k] = Segment(str(k + 1), times[k], times[k + 1], number)
    return replace(alignment, states=tuple(states)), kept


def _recognised(alignment, spoken, samples, settings) -> list[tuple[float, ...] | None]:
    """Borders of the states of each phone of speech as the decoder finds them; None where it does not."""
    none = [None] * len(spoken)
    labels = [alignment.phones[number].label for number in spoken]
    if len(samples) > MAX_DURATION * RATE or not np.any(samples) or not set(labels) <= set(PHONES):
        return none
    pronunciations: dict[str, list[str]] = {}  # by number of the word: the same word may be pronounced in two ways
    for number, label in zip(spoken, labels, strict=True):
        pronunciations.setdefault(str(alignment.phones[number].parent), []).append(label)
    sound = padded(samples, settings.padding, settings.padding_noise)
    given = {word: [phones] for word, phones in pronunciations.items()}
    found = recognise_words(sound, list(given), given, settings.pause_probability)
    if found is None:
        return none
    moved = round(settings.padding * RATE) / RATE
    borders = [tuple(time - moved for time in one.borders) for one in found if one.word != -1]
    return borders if len(borders) == len(spoken) else none


def _inner(given: Segment, borders: np.ndarray) -> list[float] | None:
    """Inner borders of the states of a given phone, from those that the decoder found; None where it found another."""
    overlap = min(given.end, borders[-1]) - max(given.start, borders[0])
    if overlap < MIN_OVERLAP * min(given.end - given.start, borders[-1] - borders[0]):
        return None
    shares = (borders[1:-1] - borders[0]) / (borders[-1] - borders[0])
    inner = [round(float(time), _DIGITS) for time in given.start + shares * (given.end - given.start)]
    times = [given.start, *inner, given.end]
    return inner if all(a < b for a, b in zip(times, times[1:], strict=False)) else None
