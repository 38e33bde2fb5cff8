"""Log-mel spectra against a second library and plain loops; what level and channel add to them."""

import numpy as np
import pytest
from scipy.signal import ShortTimeFFT, firwin, lfilter

from visualspeech.speech import acoustics
from visualspeech.speech.acoustics import (
    FFT_SIZE,
    FLOOR_DB,
    MelBands,
    band_statistics,
    hertz_of,
    levels,
    mel,
    mel_filters,
)
from visualspeech.speech.sound import RATE, Sound

BANDS = MelBands(28, 60.0, 7600.0, 0.025)


def noise(seconds, seed=0, size=3000):
    """Noise whose level changes as that of speech: bursts of 50 to 300 ms."""
    random = np.random.default_rng(seed)
    count = round(seconds * RATE)
    gains = np.repeat(10 ** random.uniform(-2.5, 0, count // 800 + 1), 800)[:count]
    return np.clip(random.normal(0, size, count) * gains, -32000, 32000)


def sound(samples):
    return Sound(np.round(samples).astype(np.int16))


def test_mel_and_back():
    assert mel(1000) == pytest.approx(1000, abs=0.1)
    assert np.allclose(hertz_of(mel([0, 60, 440, 7600])), [0, 60, 440, 7600])


def test_filters_are_triangles_that_meet_in_the_middles_of_their_neighbours():
    filters = mel_filters(12, 100, 4000, RATE)
    assert filters.shape == (FFT_SIZE // 2 + 1, 12)
    middles = hertz_of(np.linspace(mel(100), mel(4000), 14))
    for band in range(12):  # point by point, as the definition says
        low, middle, high = middles[band : band + 3]
        for number in range(0, FFT_SIZE // 2 + 1, 3):
            hertz = number * RATE / FFT_SIZE
            expected = 0.0
            if low < hertz <= middle:
                expected = (hertz - low) / (middle - low)
            elif middle < hertz < high:
                expected = (high - hertz) / (high - middle)
            assert filters[number, band] == pytest.approx(expected, abs=1e-9)


def test_spectra_are_those_of_scipy():
    one, size = sound(noise(0.5)), 400
    window = np.hanning(size + 1)[:size]
    other = ShortTimeFFT(window, hop=160, fs=RATE, mfft=FFT_SIZE, fft_mode="onesided", phase_shift=None)
    samples = one.between(0, len(one.samples))
    # Slice p of scipy has its middle at sample 160 p.
    power = np.abs(other.stft(samples, p0=2, p1=48)) ** 2 / (window**2).sum()
    expected = 10 * np.log10(np.maximum(power.T @ mel_filters(28, 60, 7600, RATE), 1e-10))
    assert np.allclose(BANDS.spectra(one, np.arange(2, 48) * 0.01), expected, atol=1e-6)


def test_a_tone_is_in_its_band():
    times = np.arange(RATE) / RATE
    middles = hertz_of(np.linspace(mel(60), mel(7600), 30))[1:-1]
    for band in (3, 11, 25):
        found = BANDS.spectra(sound(8000 * np.sin(2 * np.pi * middles[band] * times)), np.array([0.5]))[0]
        assert found.argmax() == band


def test_a_gain_adds_a_constant_and_a_channel_one_constant_per_band():
    random = np.random.default_rng(3)
    samples = random.normal(0, 3000, RATE)
    times = np.arange(5, 95) * 0.01
    plain = BANDS.spectra(sound(samples), times)
    louder = BANDS.spectra(sound(samples * 2), times)
    assert np.allclose(louder - plain, 20 * np.log10(2), atol=0.05)  # rounding to 16 bit
    channel = firwin(201, [300, 3400], pass_zero=False, fs=RATE)
    filtered = BANDS.spectra(sound(lfilter(channel, 1, samples)[100:]), times[:-2])
    inside = slice(8, 19)  # bands that lie in the channel
    assert np.abs((filtered - plain[:-2])[:, inside]).mean() < 0.5
    assert (filtered - plain[:-2])[:, -1].mean() < -40


def test_statistics_are_those_of_the_frames_within_the_range(monkeypatch):
    one, step = sound(noise(3.0)), 0.01
    spectra = BANDS.spectra(one, (np.arange(300) + 0.5) * step)
    level = 10 * np.log10((10 ** (spectra / 10)).sum(axis=1))
    for wanted in (10.0, 25.0, 200.0):
        found = band_statistics(one, BANDS, step, wanted)
        threshold = np.percentile(level, 95, method="inverted_cdf") - wanted
        bounds = [spectra[level >= threshold + moved] for moved in (-0.5, 0.5)]  # classes of levels are 0.5 dB wide
        for name, function in (("mean", np.mean), ("deviation", np.std)):
            values = [function(part, axis=0) for part in bounds]
            assert np.all(getattr(found, name) >= np.minimum(*values) - 0.3)
            assert np.all(getattr(found, name) <= np.maximum(*values) + 0.3)
    exact = band_statistics(one, BANDS, step, 200.0)
    assert np.allclose(exact.mean, spectra.mean(axis=0)) and np.allclose(exact.deviation, spectra.std(axis=0))
    monkeypatch.setattr(acoustics, "BLOCK", 0.37)
    parts = band_statistics(one, BANDS, step, 25.0)
    whole = band_statistics(one, BANDS, step, 25.0)
    assert np.allclose(parts.mean, whole.mean)


def test_long_recordings_are_read_in_parts():
    class Counted:
        largest = 0

        def __len__(self):
            return 3600 * RATE

        def __getitem__(self, rows):
            Counted.largest = max(Counted.largest, rows.stop - rows.start)
            return np.full(rows.stop - rows.start, 7, np.int16)

    band_statistics(Sound(Counted()), MelBands(2, 60, 7600, 0.025), 0.09, 30)
    BANDS.spectra(Sound(Counted()), np.arange(40) * 80.0)
    assert 0 < Counted.largest <= 60 * RATE


@pytest.mark.parametrize("samples", [np.zeros(0), np.zeros(16), np.zeros(8000)])
def test_silence_has_a_level(samples):
    assert np.all(BANDS.spectra(sound(samples), np.array([0.0, 0.1])) == FLOOR_DB)
    found = band_statistics(sound(samples), BANDS, 0.01, 30)
    assert np.all(found.mean == FLOOR_DB) and np.all(found.deviation == 0)
    assert len(levels(sound(samples), 0.01)) == max(1, len(samples) // 160)


@pytest.mark.parametrize(("low", "high"), [(0, 2000), (1000, 2000), (0, 8000), (1000, 8000)])
def test_no_band_that_settings_allow_is_empty(low, high):
    assert mel_filters(80, low, high, RATE).sum(axis=0).min() > 0.3
