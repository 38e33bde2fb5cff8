"""What labels can say beyond phones and states: place in the syllable and in the word, stress (Fan 2015, section 3.1).

The paper names these and leaves them for later. A part is one more small integer of a frame's label, and one more
one-hot block of the network's input.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.features.labels import SILENCE, label_indices
from visualspeech.speech import tts
from visualspeech.speech.syllables import VOWELS, stress_of_syllables, syllables
from visualspeech.timing import frame_times, interval_of_frame

#: What each part can be, in the order of its values. A pause is the first of each.
PARTS: dict[str, tuple[str, ...]] = {
    "position_in_syllable": ("pause", "onset", "nucleus", "coda"),
    "position_in_word": ("pause", "first", "inside", "last", "only"),
    "stress": ("pause", "none", "secondary", "primary"),
}


def part_sizes(parts: Sequence[str]) -> tuple[int, ...]:
    """Number of values of each part.

    Raises
    ------
    SettingError
        A part is unknown.
    """
    for part in parts:
        if part not in PARTS:
            raise SettingError(f"`networks.label_parts: {part}` is unknown. Known: {', '.join(PARTS)}.")
    return tuple(len(PARTS[part]) for part in parts)


def label_parts(
    rows, frames: int, rate: float, parts: Sequence[str], stresses: Mapping[str, Sequence[int]] | None = None
) -> np.ndarray:
    """Parts of every frame's label of one utterance: (frames, parts) int16, values as in :data:`PARTS`.

    Frame i has those of the phone that is spoken at (i + 0.5) / rate seconds, as in
    :func:`visualspeech.features.labels.label_indices`.

    Parameters
    ----------
    rows : the alignment of the utterance (columns tier, index, parent, label, start, end; seconds)
    parts : names of :data:`PARTS`
    stresses : of the vowels of each word, by word (:func:`visualspeech.speech.tts.stresses`); asked for where absent

    Raises
    ------
    SettingError
        A part is unknown.
    DataError
        The alignment's phones do not fit its words.
    """
    part_sizes(parts)
    words = rows[rows["tier"] == "word"].sort_values("index")["label"].tolist()
    spoken = rows[rows["tier"] == "phone"].sort_values("index")
    if not len(spoken) or spoken["parent"].min() < 0 or spoken["parent"].max() >= len(words):
        raise DataError("the alignment's phones do not fit its words; delete the alignment files and align again.")
    if stresses is None:
        stresses = tts.stresses([word for word in words if word != SILENCE]) if "stress" in parts else {}
    values = {part: np.zeros(len(spoken), np.int16) for part in PARTS}
    labels, parents = spoken["label"].to_numpy(), spoken["parent"].to_numpy(int)
    for number, word in enumerate(words):
        own = np.nonzero((parents == number) & (labels != SILENCE))[0]
        if len(own):
            found = _of_word(labels[own].tolist(), stresses.get(word, ()))
            for part, places in found.items():
                values[part][own] = places
    of_frame = interval_of_frame(spoken["start"].to_numpy(float), frame_times(frames, rate))
    return np.column_stack([values[part] for part in parts] or [np.zeros((len(spoken), 0), np.int16)])[of_frame]


def _of_word(phones: list[str], stresses: Sequence[int]) -> dict[str, list[int]]:
    in_syllable, stress = [], []
    marks = stress_of_syllables(phones, stresses)
    for syllable, mark in zip(syllables(phones), marks, strict=True):
        nucleus = next((index for index in syllable if phones[index] in VOWELS), syllable.stop)
        in_syllable += [1 + (index >= nucleus) + (index > nucleus) for index in syllable]
        stress += [1 + mark] * len(syllable)
    in_word = [4] if len(phones) == 1 else [1, *[2] * (len(phones) - 2), 3]
    return {"position_in_syllable": in_syllable, "position_in_word": in_word, "stress": stress}


def full_labels(rows, frames: int, rate: float, phones: Sequence[str], parts: Sequence[str]) -> np.ndarray:
    """The labels that a network of these parts reads: (frames, 4 + parts) int16; see the two functions it joins."""
    labels = label_indices(rows, frames, rate, phones)
    return np.column_stack([labels, label_parts(rows, frames, rate, parts)]) if parts else labels
