"""States of given phones, re-estimated by the recogniser: as forced alignment has them where the phones are its own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import resample_poly

from visualspeech.speech.alignment import Segment
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.speech.forced_alignment import align
from visualspeech.speech.given_states import recognised_states
from visualspeech.speech.tts import synthesise

TEXT = "Please bring my blue boat back before noon."


@pytest.fixture(scope="module")
def spoken():
    speech = synthesise(TEXT)
    samples = np.clip(np.round(resample_poly(speech.samples.astype(float), 16000, speech.rate)), -32768, 32767)
    return samples.astype(np.int16), align(samples.astype(np.int16), TEXT)


def in_thirds(alignment):
    states = []
    for number, one in enumerate(alignment.phones):
        borders = np.linspace(one.start, one.end, 4).tolist()
        states += [Segment(str(k + 1), borders[k], borders[k + 1], number) for k in range(3)]
    return replace(alignment, states=tuple(states))


def test_the_states_of_the_recogniser_s_own_phones_come_back(spoken):
    samples, alignment = spoken
    found, kept = recognised_states(in_thirds(alignment), samples, AlignmentSettings())
    assert kept == 0 and found.phones == alignment.phones
    apart = [abs(a.end - b.end) for a, b in zip(found.states, alignment.states, strict=True)]
    thirds = [abs(a.end - b.end) for a, b in zip(in_thirds(alignment).states, alignment.states, strict=True)]
    assert np.mean(apart) < 0.3 * np.mean(thirds)


def test_states_stay_inside_moved_phones(spoken):
    samples, alignment = spoken
    moved = in_thirds(replace(alignment, phones=tuple(
        replace(one, start=max(0, one.start - 0.004 * (k > 0)), end=one.end - 0.004 * (k + 1 < len(alignment.phones)))
        for k, one in enumerate(alignment.phones)
    )))  # fmt: skip
    found, _ = recognised_states(moved, samples, AlignmentSettings())
    for number, one in enumerate(found.phones):
        own = found.states[3 * number : 3 * number + 3]
        assert own[0].start == one.start and own[2].end == one.end
        assert all(a.start < a.end for a in own) and own[0].end == own[1].start


def test_another_sound_and_other_phones_keep_the_thirds(spoken):
    samples, alignment = spoken
    given = in_thirds(alignment)
    for sound, phones in (
        (np.zeros(len(samples), np.int16), given.phones),
        (np.zeros(130 * 16000, np.int16) + 1, given.phones),
        (samples, tuple(replace(one, label="øː") for one in given.phones)),
    ):
        found, kept = recognised_states(replace(given, phones=phones), sound, AlignmentSettings())
        assert found.states == given.states and kept == sum(one.label != "sil" for one in phones)
