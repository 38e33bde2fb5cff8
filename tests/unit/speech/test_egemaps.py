"""The descriptors of eGeMAPS by openSMILE: what they say of known sounds, their times, and what is said without it."""

import numpy as np
import pytest

from tests.unit.speech.voices import harmonics, noise, sound_of, vowel
from visualspeech.errors import DataError
from visualspeech.speech import egemaps
from visualspeech.speech.egemaps import NAMES, VOICED, descriptors

TIMES = (np.arange(12, 108) + 0.5) / 120
needs_opensmile = pytest.mark.skipif(bool(egemaps.missing()), reason=egemaps.missing())


def of(samples, times=TIMES):
    return dict(zip(NAMES, descriptors(sound_of(samples), times).T, strict=True))


def test_there_are_17_of_which_8_are_of_voiced_frames():
    assert len(NAMES) == len(set(NAMES)) == 17
    assert VOICED == {
        "jitterLocal", "shimmerLocaldB", "HNRdBACF", "logRelF0-H1-H2", "logRelF0-H1-A3", "F1amplitudeLogRelF0",
        "F2amplitudeLogRelF0", "F3amplitudeLogRelF0",
    }  # fmt: skip


def test_without_opensmile_it_says_what_to_do(monkeypatch):
    monkeypatch.setattr(egemaps, "find_spec", lambda name: None)
    assert "pip install -e '.[egemaps]'" in egemaps.missing() and "speech27" in egemaps.missing()
    with pytest.raises(DataError, match="opensmile is not installed"):
        descriptors(sound_of(noise()), TIMES)


@needs_opensmile
def test_they_are_the_set_of_opensmile_less_f0_loudness_and_four_mfcc():
    names = [name.partition("_sma")[0] for name in egemaps._opensmile().feature_names]
    left_out = {"F0semitoneFrom27.5Hz", "Loudness", "mfcc1", "mfcc2", "mfcc3", "mfcc4"}
    assert len(names) == 23 and [name for name in names if name not in left_out] == list(NAMES)


@needs_opensmile
def test_formants_of_a_neutral_vowel():
    found = of(vowel(110, (500, 1500, 2500)))  # of others openSMILE's are rougher, and merge neighbours
    for number, hertz in enumerate((500, 1500, 2500), 1):
        assert np.median(found[f"F{number}frequency"]) == pytest.approx(hertz, rel=0.08), number


@needs_opensmile
def test_slopes_and_ratios_follow_the_spectrum():
    dark, bright = of(harmonics(150, number=4)), of(noise(1.0, 0.1))
    # The share of 50-1000 Hz against 1-5 kHz, and the peaks of 0-2 and 2-5 kHz; noise of 4 kHz against 1 kHz has 6 dB.
    assert np.median(bright["alphaRatio"]) == pytest.approx(10 * np.log10(4000 / 950), abs=1.0)
    assert np.median(dark["alphaRatio"]) < -20 < np.median(bright["alphaRatio"])
    assert np.median(dark["hammarbergIndex"]) > 20 > np.median(bright["hammarbergIndex"])


@needs_opensmile
def test_what_only_voiced_frames_have_goes_on_between_them():
    silent = of(noise(1.0, 0.0005))
    assert all(np.isnan(silent[name]).all() == (name in VOICED) for name in NAMES)
    mixed = of(np.concatenate([vowel(120, (500, 1500, 2500), 0.5), noise(0.5, 0.0005)]))
    for name in VOICED:
        assert np.isfinite(mixed[name]).all()
        assert np.ptp(mixed[name][-20:]) == 0  # constant after the last voiced frame
    periodic, hoarse = of(harmonics(150)), of(harmonics(150) + noise(1.0, 0.08))
    assert np.median(periodic["HNRdBACF"]) > np.median(hoarse["HNRdBACF"]) + 3


@needs_opensmile
@pytest.mark.parametrize("name", ["alphaRatio", "hammarbergIndex"])
def test_changes_of_the_spectrum_lie_at_their_own_times(name):
    times, late = (np.arange(1000) + 0.5) / 1000, []
    for seed in range(6):
        moment = 0.5 + 0.0013 * seed
        cut, bright = round(moment * 16_000), noise(1.0, 0.1, seed)
        dark = np.convolve(noise(1.0, 0.1, seed + 50), np.ones(8) / 8, "same")
        # In decibels the middle of a change is nearer to the louder side; two directions together have none of that.
        for before, after in ((dark, bright), (bright, dark)):
            values = of(np.concatenate([before[:cut], after[cut:]]), times)[name]
            low, high = np.median(values[200:400]), np.median(values[600:800])
            crossed = np.flatnonzero((values - low) / (high - low) > 0.5)
            late.append(times[crossed[crossed > 420][0]] - moment)
    assert abs(np.mean(late)) < 0.003  # windows of 20 ms, a frame every 10 ms


@needs_opensmile
@pytest.mark.parametrize("moment", [0.5, 0.503, 0.5077])
def test_descriptors_of_voice_lie_around_it(moment):
    times, cut = (np.arange(240) + 0.5) / 240, round(moment * 16_000)
    samples = noise(1.0, 0.0005)
    samples[cut - 3200 : cut + 3200] += vowel(120, (500, 1500, 2500), 0.4)
    changes = np.flatnonzero(np.diff(of(samples, times)["F1amplitudeLogRelF0"]))
    assert (times[changes[0]] + times[changes[-1]]) / 2 == pytest.approx(moment, abs=0.015)
