"""A speaker whose face is a function of the phones: utterances with alignments and visual parameters."""

import numpy as np

from tests.unit.speech.alignments import even_alignment
from visualspeech.features.blocks.base import Source
from visualspeech.speech.alignment import starts_of
from visualspeech.speech.phones import SILENCE
from visualspeech.timing import frame_times, interval_of_frame

RATE = 100.0
PHONES = ("sil", "aa", "b", "iy", "m", "s")
SECONDS = 0.12  # of a phone
TARGETS = np.random.default_rng(8).normal(0, 10, (len(PHONES), 4))


def source(name, labels, noise=0.5, seed=0):
    """One utterance of equally long phones between pauses, whose face glides from one phone's target to the next."""
    spoken = [(SILENCE, [SILENCE]), *((label, [label]) for label in labels), (SILENCE, [SILENCE])]
    alignment = even_alignment(spoken, SECONDS)
    frames = round(alignment.duration * RATE)
    starts = starts_of(alignment.phones)
    numbers = np.array([PHONES.index(one.label) for one in alignment.phones])
    times = frame_times(frames, RATE)
    middles = starts + SECONDS / 2
    glides = np.column_stack([np.interp(times, middles, TARGETS[numbers, column]) for column in range(4)])
    assert interval_of_frame(starts, times).max() == len(starts) - 1
    values = glides + np.random.default_rng(seed).normal(0, noise, glides.shape)
    return Source(frames, RATE, alignment, parameters=values.astype(np.float32), id=name)


def corpus(count, seed=1, words=8):
    """Utterances of random phones."""
    random = np.random.default_rng(seed)
    return [source(f"u{number}", random.choice(PHONES[1:], words), seed=number) for number in range(count)]
