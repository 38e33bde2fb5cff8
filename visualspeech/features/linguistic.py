"""Contextual features of phones: a frame in its phone, and the phone in its syllable, word, phrase and utterance.

The rows of Table 1 for phonetic units in Thangthai et al. (2016), section 4, other than the centre phone and the window
of phones, which are the input block ``phone`` and the window with which a model reads it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from visualspeech.features.unit_contexts import (
    AFTER,
    BEFORE,
    POSITIONS,
    frames_in_units,
    neighbours,
    positions,
)
from visualspeech.speech.acoustic_classes import ACOUSTIC_CLASSES, acoustic_classes
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.structure import SHORT_PAUSE, SYMBOLS, Structure, structure_of, symbols_of


class Columns(NamedTuple):
    """Features of T rows.

    Parameters
    ----------
    index : (T, C) uint8, categorical
    counts : (T, N) int32
    classes : (T, B) bool
    """

    index: np.ndarray
    counts: np.ndarray
    classes: np.ndarray


class Feature(NamedTuple):
    """Columns of one feature: sizes of the categorical ones, number of counts, number of binary classes."""

    sizes: tuple[int, ...] = ()
    counts: int = 0
    classes: int = 0


#: Feature of syllable, word, phrase and utterance level -> units and larger units of which it has position and number.
LEVELS: dict[str, tuple[tuple[str, str], ...]] = {
    "syllable": (("phone", "syllable"),),
    "word": (("syllable", "word"),),
    "phrase": (("syllable", "phrase"), ("word", "phrase")),
    "utterance": (("syllable", "utterance"), ("word", "utterance"), ("phrase", "utterance")),
}
#: Classes of a position in a larger unit: start, middle, end, and none of a pause.
LEVEL_POSITIONS = len(POSITIONS) + 1

FEATURES: dict[str, Feature] = {
    "position": Feature(sizes=(len(POSITIONS),)),
    "number_of_frames": Feature(counts=1),
    "forward_span": Feature(counts=1),
    "acoustic_class": Feature(classes=len(ACOUSTIC_CLASSES)),
    "phone_context": Feature(sizes=(len(SYMBOLS),) * (BEFORE + 1 + AFTER)),
    **{name: Feature((LEVEL_POSITIONS,) * len(pairs), len(pairs)) for name, pairs in LEVELS.items()},
}


def sizes_of(features: Sequence[str]) -> Feature:
    """All columns of some features of :data:`FEATURES`, in their order."""
    chosen = [FEATURES[name] for name in features]
    sizes = tuple(size for one in chosen for size in one.sizes)
    return Feature(sizes, sum(one.counts for one in chosen), sum(one.classes for one in chosen))


def level_columns(structure: Structure, name: str) -> Columns:
    """Positions and numbers of a feature of :data:`LEVELS`, by phone: (P, C) each; pauses have no position, and 0."""
    pairs = [
        (getattr(structure, f"{unit}_in_{whole}"), getattr(structure, f"{unit}s_in_{whole}"))
        for unit, whole in LEVELS[name]
    ]
    counts = np.column_stack([count for _, count in pairs]).astype(np.int32)
    return Columns(np.column_stack([positions(*pair) for pair in pairs]), counts, np.zeros((len(counts), 0), bool))


def symbol_numbers(alignment: Alignment, long_pause: float, short_pauses: bool = True) -> np.ndarray:
    """Number of each phone in :data:`visualspeech.speech.structure.SYMBOLS`, (P,) uint8.

    Parameters
    ----------
    long_pause : seconds from which on a pause inside the utterance is silence
    short_pauses : whether the others are short pauses; otherwise they are silence, too

    Raises
    ------
    DataError
        The alignment has no phones, or a phone that is not ARPAbet.
    """
    known = {symbol: number for number, symbol in enumerate(SYMBOLS)}
    if not short_pauses:
        known[SHORT_PAUSE] = known[SILENCE]
    return np.array([known[symbol] for symbol in symbols_of(alignment, long_pause)], np.uint8)


def linguistic_columns(
    alignment: Alignment,
    frames: int,
    rate: float,
    features: Sequence[str],
    long_pause: float,
    short_pauses: bool = True,
) -> Columns:
    """Contextual features of every frame of one utterance, as :func:`sizes_of` lays them out.

    Parameters
    ----------
    frames, rate : number of frames and frame rate in Hz of the visual stream
    features : names of :data:`FEATURES`
    long_pause, short_pauses : see :func:`symbol_numbers`; long pauses also end phrases

    Raises
    ------
    DataError
        As :func:`symbol_numbers`.
    """
    frame = frames_in_units(starts_of(alignment.phones), frames, rate)
    symbols = symbol_numbers(alignment, long_pause, short_pauses)
    structure = structure_of(alignment, long_pause)
    none = Columns(np.zeros((frames, 0), np.uint8), np.zeros((frames, 0), np.int32), np.zeros((frames, 0), bool))

    def columns_of(name: str) -> Columns:
        if name == "position":
            return none._replace(index=frame.position[:, None])
        if name == "number_of_frames":
            return none._replace(counts=frame.count[:, None])
        if name == "forward_span":
            return none._replace(counts=frame.span[:, None])
        if name == "acoustic_class":
            return none._replace(classes=acoustic_classes()[symbols][frame.unit])
        if name == "phone_context":
            return none._replace(index=neighbours(symbols, SYMBOLS.index(SILENCE))[frame.unit])
        return Columns(*(values[frame.unit] for values in level_columns(structure, name)))

    chosen = [none, *map(columns_of, features)]
    return Columns(*(np.concatenate(columns, axis=1) for columns in zip(*chosen, strict=True)))
