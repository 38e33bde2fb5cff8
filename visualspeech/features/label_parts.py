"""Label parts beyond phones and states: position in the syllable and in the word, stress (Fan 2015, section 3.1).

The paper leaves these for future work. A part is one more small integer of a frame's label, and one more one-hot block
of the network's input.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from visualspeech.errors import DataError, SettingError
from visualspeech.features.labels import label_indices
from visualspeech.speech import tts
from visualspeech.speech.alignment import Alignment, starts_of
from visualspeech.speech.phones import SILENCE
from visualspeech.speech.syllables import VOWELS, stress_of_syllables, syllables
from visualspeech.timing import frame_times, interval_of_frame

#: Values of each part by name, in the order of their numbers. The first value is a pause.
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
            raise SettingError(f"`blocks: parts: {part}` is unknown. Known: {', '.join(PARTS)}.")
    return tuple(len(PARTS[part]) for part in parts)


def label_parts(
    alignment: Alignment,
    frames: int,
    rate: float,
    parts: Sequence[str],
    stresses: Mapping[str, Sequence[int]] | None = None,
) -> np.ndarray:
    """Label parts of every frame of one utterance: (frames, parts) int16, numbered as in :data:`PARTS`.

    Frame i has the parts of the phone that is spoken at (i + 0.5) / rate seconds, as in
    :func:`visualspeech.features.labels.label_indices`.

    Parameters
    ----------
    frames, rate : number of frames and frame rate (Hz) of the visual stream
    parts : names from :data:`PARTS`
    stresses : stress of each vowel, by word; None asks :func:`visualspeech.speech.tts.stresses`

    Raises
    ------
    SettingError
        A part is unknown.
    DataError
        The phones of the alignment do not fit its words.
    """
    part_sizes(parts)
    words, spoken = [one.label for one in alignment.words], alignment.phones
    parents = np.array([one.parent for one in spoken], int)
    if not len(spoken) or parents.min() < 0 or parents.max() >= len(words):
        raise DataError("the phones of the alignment do not fit its words; delete the alignment files and align again.")
    if stresses is None:
        stresses = tts.stresses([word for word in words if word != SILENCE]) if "stress" in parts else {}
    values = {part: np.zeros(len(spoken), np.int16) for part in PARTS}
    labels = np.array([one.label for one in spoken])
    for number, word in enumerate(words):
        own = np.nonzero((parents == number) & (labels != SILENCE))[0]
        if len(own):
            for part, found in _of_word(labels[own].tolist(), stresses.get(word, ())).items():
                values[part][own] = found
    of_frame = interval_of_frame(starts_of(spoken), frame_times(frames, rate))
    return np.column_stack([values[part] for part in parts] or [np.zeros((len(spoken), 0), np.int16)])[of_frame]


def _of_word(phones: list[str], stresses: Sequence[int]) -> dict[str, list[int]]:
    """Numbers of all parts of each phone of a word."""
    in_syllable, stress = [], []
    marks = stress_of_syllables(phones, stresses)
    for syllable, mark in zip(syllables(phones), marks, strict=True):
        nucleus = next((index for index in syllable if phones[index] in VOWELS), syllable.stop)
        in_syllable += [1 + (index >= nucleus) + (index > nucleus) for index in syllable]
        stress += [1 + mark] * len(syllable)
    in_word = [4] if len(phones) == 1 else [1, *[2] * (len(phones) - 2), 3]
    return {"position_in_syllable": in_syllable, "position_in_word": in_word, "stress": stress}


def full_labels(
    alignment: Alignment, frames: int, rate: float, phones: Sequence[str], parts: Sequence[str]
) -> np.ndarray:
    """Label indices and label parts of every frame: (frames, 4 + parts) int16, input of a network with these parts."""
    labels = label_indices(alignment, frames, rate, phones)
    return np.column_stack([labels, label_parts(alignment, frames, rate, parts)]) if parts else labels
