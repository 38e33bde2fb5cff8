"""Contextual features of dynamic visemes: a frame in its viseme, and the viseme in its syllable, word and so on.

The rows of Table 1 for dynamic visemes in Thangthai et al. (2016), section 4, other than the centre viseme and the
window of visemes, which are the input block ``dynamic_visemes`` and the window with which a model reads it.
"""

from collections.abc import Sequence

import numpy as np

from visualspeech.features.linguistic import LEVEL_POSITIONS, LEVELS, Columns, Feature, level_columns
from visualspeech.features.unit_contexts import (
    AFTER,
    BEFORE,
    POSITIONS,
    frames_in_units,
    positions,
)
from visualspeech.features.visemes.segmentation import Gestures
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.structure import structure_of
from visualspeech.timing import frame_times, interval_of_frame

VISEME = "viseme_context"
#: Feature -> its columns; sizes of None are the number of classes of visemes.
FEATURES: dict[str, Feature] = {
    "position": Feature(sizes=(len(POSITIONS),)),
    "number_of_frames": Feature(counts=1),
    "forward_span": Feature(counts=1),
    VISEME: Feature(),
    "number_of_phones": Feature(counts=1),
    "syllable": Feature((LEVEL_POSITIONS,), 1),
    **{
        name: Feature((LEVEL_POSITIONS,) * len(pairs), len(pairs))
        for name, pairs in LEVELS.items()
        if name != "syllable"
    },
}


def sizes_of(features: Sequence[str], classes: int) -> Feature:
    """All columns of some features of :data:`FEATURES`, in their order.

    Parameters
    ----------
    classes : number of classes of visemes
    """
    chosen = [
        Feature(sizes=(classes,) * (BEFORE + 1 + AFTER)) if name == VISEME else FEATURES[name] for name in features
    ]
    return Feature(tuple(size for one in chosen for size in one.sizes), sum(one.counts for one in chosen))


def viseme_columns(
    alignment: Alignment,
    rate: float,
    gestures: Gestures,
    classes: np.ndarray,
    features: Sequence[str],
    long_pause: float,
) -> Columns:
    """Contextual features of every frame of one utterance of T frames, as :func:`sizes_of` lays them out.

    Of units that do not nest, those count that share a frame: the phones of a viseme are all that are spoken in it, and
    the visemes of a syllable all that are seen in it. Before the first and after the last viseme, the segment of five
    repeats it.

    Parameters
    ----------
    rate : Hz
    gestures, classes : the visemes of the utterance, and the class (G,) of each
    features : names of :data:`FEATURES`
    long_pause : seconds from which on a pause ends a phrase

    Raises
    ------
    DataError
        The alignment has no phones, or a phone that is not ARPAbet.
    """
    frames = gestures.frames
    frame = frames_in_units(gestures.starts / rate, frames, rate)
    phone = interval_of_frame(starts_of(alignment.phones), frame_times(frames, rate))
    structure = structure_of(alignment, long_pause)
    none = Columns(np.zeros((frames, 0), np.uint16), np.zeros((frames, 0), np.int32), np.zeros((frames, 0), bool))

    def columns_of(name: str) -> Columns:
        if name == "position":
            return none._replace(index=frame.position[:, None])
        if name == "number_of_frames":
            return none._replace(counts=frame.count[:, None])
        if name == "forward_span":
            return none._replace(counts=frame.span[:, None])
        if name == VISEME:
            padded = np.pad(classes, (BEFORE, AFTER), mode="edge")
            segments = np.lib.stride_tricks.sliding_window_view(padded, BEFORE + 1 + AFTER)
            return none._replace(index=segments[frame.unit])
        if name == "number_of_phones":
            return none._replace(counts=_within(frame.unit, phone)[1][:, None])
        if name == "syllable":
            syllable = structure.syllable_in_utterance[phone]
            number, count = (np.where(syllable > 0, values, 0) for values in _within(syllable, frame.unit))
            return none._replace(index=positions(number, count)[:, None], counts=count[:, None])
        return Columns(*(values[phone] for values in level_columns(structure, name)))

    chosen = [none, *map(columns_of, features)]
    index, counts, classes = (np.concatenate(columns, axis=1) for columns in zip(*chosen, strict=True))
    return Columns(index.astype(np.uint16), counts.astype(np.int32), classes)


def _within(wholes: np.ndarray, units: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of each frame's unit: its number, from 1, among the units that share a frame with its whole; and their count.

    Parameters
    ----------
    wholes, units : (T,) numbers of what each frame lies in; the units ascend
    """
    names, whole = np.unique(wholes, return_inverse=True)
    first, last = np.full(len(names), units.max()), np.zeros(len(names), units.dtype)
    np.minimum.at(first, whole, units)
    np.maximum.at(last, whole, units)
    return units - first[whole] + 1, (last - first)[whole] + 1
