"""Syllables, words and phrases of an utterance: where each phone lies in them, and how large they are.

Syllables follow the maximal-onset principle on the pronunciation as aligned (:mod:`visualspeech.speech.syllables`).
Long pauses end phrases: transcripts lose their punctuation before they are aligned, and what a reader marks of it is a
pause. Contextual features and the questions of quinphone models are computed from this.
"""

from dataclasses import dataclass, fields
from itertools import groupby

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import PHONES, SILENCE
from visualspeech.speech.syllables import syllables

SHORT_PAUSE = "sp"
#: The 41 symbols of a phone sequence: silence, the 39 phones of ARPAbet, the short pause.
SYMBOLS: tuple[str, ...] = (*PHONES, SHORT_PAUSE)
LONG_PAUSE = 0.15  # seconds, default of the settings; the pauses at commas of the synthetic voice last 0.19 to 0.21
MAX_PAUSE = 60.0  # seconds; bound of the settings
_ROUNDING = 1e-6  # seconds; times have fewer digits


@dataclass(frozen=True)
class Structure:
    """Linguistic structure of an utterance of P phones, pauses included: integers (P,).

    ``phone_in_syllable`` is the number, from 1, of a phone within its syllable, and ``phones_in_syllable`` is how many
    phones that syllable has; the other pairs say the same of the syllable, the word and the phrase that the phone
    belongs to. A pause belongs to none: all its numbers are 0.
    """

    phone_in_syllable: np.ndarray
    phones_in_syllable: np.ndarray
    syllable_in_word: np.ndarray
    syllables_in_word: np.ndarray
    syllable_in_phrase: np.ndarray
    syllables_in_phrase: np.ndarray
    word_in_phrase: np.ndarray
    words_in_phrase: np.ndarray
    syllable_in_utterance: np.ndarray
    syllables_in_utterance: np.ndarray
    word_in_utterance: np.ndarray
    words_in_utterance: np.ndarray
    phrase_in_utterance: np.ndarray
    phrases_in_utterance: np.ndarray


#: Pairs of a unit and what contains it, in the order of the fields of :class:`Structure`.
_LEVELS = (
    ("phone", "syllable"),
    ("syllable", "word"),
    ("syllable", "phrase"),
    ("word", "phrase"),
    ("syllable", "utterance"),
    ("word", "utterance"),
    ("phrase", "utterance"),
)


def structure_of(alignment: Alignment, long_pause: float = LONG_PAUSE) -> Structure:
    """The linguistic structure of an utterance, int32 arrays (P,) by phone.

    Parameters
    ----------
    alignment : words, and phones with the words that they belong to
    long_pause : seconds from which on a pause ends a phrase

    Raises
    ------
    DataError
        The alignment has no phones, or a phone that is not ARPAbet.
    """
    labels = _labels(alignment)
    spoken = [number for number, label in enumerate(labels) if label != SILENCE]
    # Numbers of the units that each spoken phone belongs to, counted through the utterance.
    units = {name: np.zeros(len(spoken), np.int32) for name in ("syllable", "word", "phrase", "utterance")}
    units["phone"] = np.arange(len(spoken), dtype=np.int32)
    done, syllable, phrase, before = 0, 0, 0, None
    for word, (_, members) in enumerate(groupby(spoken, key=lambda number: alignment.phones[number].parent)):
        own = list(members)
        if before is not None and alignment.phones[own[0]].start - before >= long_pause - _ROUNDING:
            phrase += 1
        before = alignment.phones[own[-1]].end
        for part in syllables([labels[number] for number in own]):
            units["syllable"][done + part.start : done + part.stop] = syllable
            syllable += 1
        units["word"][done : done + len(own)] = word
        units["phrase"][done : done + len(own)] = phrase
        done += len(own)
    result = np.zeros((2 * len(_LEVELS), len(labels)), np.int32)
    if spoken:
        result[:, spoken] = [column for unit, whole in _LEVELS for column in _numbered(units[unit], units[whole])]
    return Structure(**{field.name: column for field, column in zip(fields(Structure), result, strict=True)})


def symbols_of(alignment: Alignment, long_pause: float = LONG_PAUSE) -> list[str]:
    """The P phones of an utterance in :data:`SYMBOLS`: pauses inside it shorter than ``long_pause`` seconds are "sp".

    Raises
    ------
    DataError
        As :func:`structure_of`.
    """
    labels, edges = _labels(alignment), (0, len(alignment.phones) - 1)
    return [
        SHORT_PAUSE
        if label == SILENCE and number not in edges and one.end - one.start < long_pause - _ROUNDING
        else label
        for number, (label, one) in enumerate(zip(labels, alignment.phones, strict=True))
    ]


def _labels(alignment: Alignment) -> list[str]:
    if not alignment.phones:
        raise DataError("the alignment has no phones; delete the alignment files and align again.")
    labels = [one.label for one in alignment.phones]
    for unknown in sorted(set(labels) - set(PHONES))[:1]:
        raise DataError(
            f"the phone {unknown!r} of the alignment is not one of the {len(PHONES)} symbols of ARPAbet and silence "
            f"({', '.join(PHONES[:4])} ... {PHONES[-1]}); align the utterance with this project's dictionary."
        )
    return labels


def _numbered(units: np.ndarray, wholes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Number from 1 of each unit in the whole that it lies in, and how many units that whole has.

    Parameters
    ----------
    units, wholes : (S,) ascending numbers without gaps, of what each spoken phone belongs to; units lie within wholes
    """
    firsts = units[np.searchsorted(wholes, np.arange(wholes[-1] + 1))]
    counts = np.diff(np.append(firsts, units[-1] + 1))
    return units - firsts[wholes] + 1, counts[wholes]
