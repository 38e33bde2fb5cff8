"""MFCC, F0 and energy by Praat: against plain computations, closed forms and known sounds, at the right times."""

import numpy as np
import pytest

from tests.unit.speech.voices import harmonics, noise, sentence, sound_of
from visualspeech.speech import praat
from visualspeech.speech.praat import RATE, SILENCE
from visualspeech.speech.sound import RATE as SOUND_RATE
from visualspeech.speech.sound import Sound

FULL_SCALE = 20 * np.log10(1 / np.sqrt(2) / 2e-5)  # dB of a sine of amplitude 1


def f0(sound, first, last):
    return praat.f0(sound, first, last, 75.0, 600.0)


def plain_mfcc(sound, frames):
    """Coefficients 1 to 25 as the manual of Praat defines them, frame by frame."""
    size, bins = round(0.05 * SOUND_RATE), 1024
    place = (np.arange(1, size + 1) - (size + 1) / 2) / (size + 1)
    window = (np.exp(-48 * place**2) - np.exp(-12)) / (1 - np.exp(-12))
    hertz = np.arange(bins // 2 + 1) * SOUND_RATE / bins
    corners = 700 * (10 ** (np.arange(0, 2900, 100.0) / 2595) - 1)
    found = []
    for frame in frames:
        begin = round((frame + 0.5) / RATE * SOUND_RATE - size / 2)
        power = np.abs(np.fft.rfft(sound.between(begin, begin + size) * window, bins)) ** 2
        bands = []
        for low, centre, high in zip(corners[:-2], corners[1:-1], corners[2:], strict=True):
            filter_ = np.maximum(np.minimum((hertz - low) / (centre - low), (high - hertz) / (high - centre)), 0)
            bands.append(10 * np.log10(filter_ @ power))
        angles = np.pi * np.arange(1, 26)[:, None] * (np.arange(1, len(bands) + 1) - 0.5) / len(bands)
        found.append(np.cos(angles) @ bands)
    return np.array(found)


@pytest.mark.parametrize("samples", [noise() * np.linspace(0.2, 1, SOUND_RATE), sentence(1.0)])
def test_mfcc_are_those_of_a_plain_computation(samples):
    sound = sound_of(samples)
    found, plain = praat.mfcc(sound, 10, 100), plain_mfcc(sound, range(10, 100))
    # Half a sample between the two placements of a window is what remains.
    assert np.abs(found - plain).max() < 0.05 * np.abs(plain).max()
    assert np.abs(found - plain).mean() < 0.02 * np.abs(plain).mean()


def test_mfcc_do_not_depend_on_the_level():
    samples = sentence(1.0) + noise(1.0, 0.003)
    loud, quiet = (praat.mfcc(sound_of(samples * gain), 5, 115) for gain in (1.0, 0.25))
    assert np.abs(loud - quiet).mean() < 0.01 * np.abs(loud).mean()


@pytest.mark.parametrize("hertz", [80.0, 120.0, 233.0, 410.0])
@pytest.mark.parametrize("number", [1, 10])
def test_f0_of_tones_and_harmonics(hertz, number):
    found = f0(sound_of(harmonics(hertz, number=number)), 5, 115)
    assert found == pytest.approx(np.full(110, hertz), rel=0.002)


def test_f0_of_a_glide_is_that_of_the_frames_own_times():
    rising = 100 * 2 ** np.linspace(0, 1, SOUND_RATE)
    found, times = f0(sound_of(harmonics(rising)), 6, 114), (np.arange(6, 114) + 0.5) / RATE
    assert found == pytest.approx(100 * 2**times, rel=0.002)  # a frame earlier or later is 0.6 %


def test_noise_and_silence_have_no_f0():
    assert np.isnan(f0(sound_of(noise()), 0, 120)).mean() > 0.9
    assert np.isnan(f0(sound_of(np.zeros(16000)), 0, 120)).all()
    assert np.isnan(f0(sound_of(np.full(16000, 0.3)), 10, 110)).all()
    voiced = ~np.isnan(f0(sound_of(np.concatenate([noise(0.5, 1e-4), harmonics(150, 0.5)])), 0, 120))
    assert abs(np.flatnonzero(voiced)[0] - 60) <= 3 and voiced[64:116].all()


def test_f0_outside_the_range_is_not_found():
    sound = sound_of(harmonics(90.0))
    assert np.isnan(praat.f0(sound, 10, 110, 120.0, 600.0)).mean() > 0.9
    assert praat.f0(sound, 10, 110, 50.0, 300.0) == pytest.approx(np.full(100, 90.0), rel=0.002)


@pytest.mark.parametrize("amplitude", [0.9, 0.1, 0.01])
def test_energy_of_a_sine_in_closed_form(amplitude):
    found = praat.energy(sound_of(harmonics(400, number=1, amplitude=1.6 * amplitude)), 5, 115)
    assert found == pytest.approx(np.full(110, FULL_SCALE + 20 * np.log10(amplitude)), abs=0.1)


def test_energy_is_never_below_silence():
    assert (praat.energy(sound_of(np.zeros(16000)), 0, 120) == SILENCE).all()
    assert (praat.energy(sound_of(np.full(16000, 0.3)), 10, 110) == SILENCE).all()  # a constant is no sound
    rounding = Sound(np.random.default_rng(0).integers(0, 2, 16000).astype(np.int16))
    assert np.abs(praat.energy(rounding, 10, 110)).max() < 5


def test_all_three_have_their_frames_at_the_same_times():
    samples = np.zeros(16000)
    samples[8000:8160] = harmonics(200, 0.01)  # a burst around 0.505 s, in the middle of frame 60
    sound = sound_of(samples + noise(1.0, 1e-4))
    energy = praat.energy(sound, 0, 120)
    assert int(np.argmax(energy)) == 60
    # 400 samples are three frames: all move by three, to the last digit of what the position of samples allows.
    longer = Sound(np.concatenate([np.zeros(400, np.int16), sentence_samples()]))
    plain = Sound(sentence_samples())
    for feature in (praat.mfcc, praat.energy, lambda *of: np.nan_to_num(f0(*of))):
        assert np.allclose(feature(plain, 20, 100), feature(longer, 23, 103), rtol=1e-9, atol=1e-9)


def sentence_samples():
    return sound_of(sentence(1.0)).samples


@pytest.mark.parametrize("count", [1, 2, 3, 7, 119, 2400, 2401])
@pytest.mark.parametrize("first", [0, 1, 60, 4799])
def test_there_are_as_many_frames_as_are_asked_for(first, count):
    sound = sound_of(noise(0.5))
    last = first + count
    assert praat.mfcc(sound, first, last).shape == (count, 25)
    assert praat.energy(sound, first, last).shape == f0(sound, first, last).shape == (count,)
    assert praat.f0(sound, first, last, 61.7, 600.0).shape == (count,)
