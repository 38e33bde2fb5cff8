"""Sound in parts: slices beyond the ends, other sample rates, samples that stay in their file."""

import numpy as np
import pytest

from visualspeech.media.spooling import Spool
from visualspeech.speech.sound import RATE, Sound, StoredSamples, spans, to_int16
from visualspeech.storage.arrays import ArrayReader, ArrayWriter

SAMPLES = np.random.default_rng(0).integers(-32768, 32768, 1000).astype(np.int16)


@pytest.mark.parametrize(("first", "last"), [(0, 1000), (-5, 10), (990, 1010), (-20, -5), (1200, 1300), (5, 5)])
def test_beyond_its_ends_there_is_silence(first, last):
    numbers = np.arange(first, last)
    inside = (numbers >= 0) & (numbers < 1000)
    expected = np.where(inside, SAMPLES[np.clip(numbers, 0, 999)] / 32768, 0)
    assert np.array_equal(Sound(SAMPLES).between(first, last), expected)


def test_it_may_lie_in_a_file(tmp_path):
    spool = Spool(np.int16)
    spool.append(SAMPLES)
    with ArrayWriter(tmp_path / "a.h5") as out:
        out.add("one", {"samples": SAMPLES}, rate=RATE)
    with ArrayReader(tmp_path / "a.h5") as reader:
        for samples in (spool, StoredSamples(reader, "one")):
            assert len(samples) == 1000
            assert np.array_equal(Sound(samples).between(-3, 700), Sound(SAMPLES).between(-3, 700))


@pytest.mark.parametrize("rate", [16000, 22050, 48000, 8000])
def test_other_rates_are_brought_to_that_of_the_recordings(rate):
    times, wanted = np.arange(rate) / rate, np.arange(RATE) / RATE
    sound = Sound.of(0.5 * np.sin(2 * np.pi * 440 * times), rate)
    assert len(sound.samples) == RATE and sound.seconds == 1
    inner = slice(800, -800)
    assert np.abs(sound.between(0, RATE) - 0.5 * np.sin(2 * np.pi * 440 * wanted))[inner].max() < 2e-3


def test_no_sample_is_no_sound():
    assert len(Sound.of(np.zeros(0), 22050).samples) == 0


def test_full_scale():
    assert to_int16(np.array([-2.0, -1.0, 0.0, 0.5, 3.0])).tolist() == [-32767, -32767, 0, 16384, 32767]


def test_spans_cover_everything_once():
    assert list(spans(7, 3)) == [(0, 3), (3, 6), (6, 7)] and list(spans(0, 3)) == []
