"""The features of a sound on their grid: names, stretches of long recordings, unvoiced parts, sounds without speech."""

import numpy as np
import pytest

from tests.unit.speech.voices import harmonics, noise, sentence, sound_of
from visualspeech.errors import DataError
from visualspeech.speech import egemaps, speech_features
from visualspeech.speech.sound import Sound, between_voiced
from visualspeech.speech.speech_features import ALL_NAMES, PRAAT_NAMES, RATE, Extractor

PRAAT = Extractor(False, 75.0, 600.0)
ALL = Extractor(True, 75.0, 600.0)
EXTRACTORS = [PRAAT, pytest.param(ALL, marks=pytest.mark.skipif(bool(egemaps.missing()), reason=egemaps.missing()))]


def all_of(extractor, sound):
    return extractor.features(sound, 0, extractor.frames(sound))


def test_the_44_names_in_their_order():
    assert list(ALL_NAMES) == [
        "mfcc1", "mfcc2", "mfcc3", "mfcc4", "mfcc5", "mfcc6", "mfcc7", "mfcc8", "mfcc9", "mfcc10", "mfcc11", "mfcc12",
        "mfcc13", "mfcc14", "mfcc15", "mfcc16", "mfcc17", "mfcc18", "mfcc19", "mfcc20", "mfcc21", "mfcc22", "mfcc23",
        "mfcc24", "mfcc25", "log_f0", "energy", "alphaRatio", "hammarbergIndex", "slope0-500", "slope500-1500",
        "spectralFlux", "jitterLocal", "shimmerLocaldB", "HNRdBACF", "logRelF0-H1-H2", "logRelF0-H1-A3", "F1frequency",
        "F1bandwidth", "F1amplitudeLogRelF0", "F2frequency", "F2amplitudeLogRelF0", "F3frequency",
        "F3amplitudeLogRelF0",
    ]  # fmt: skip
    assert PRAAT_NAMES == ALL_NAMES[:27] == PRAAT.names and ALL.names == ALL_NAMES
    assert RATE == 120.0


@pytest.mark.parametrize("extractor", EXTRACTORS)
@pytest.mark.parametrize("count", [0, 1, 40, 400, 4000, 16_000, 16_001])
@pytest.mark.parametrize("kind", ["silent", "constant", "one_step", "noise", "full"])
def test_any_sound_has_finite_features(extractor, count, kind):
    random = np.random.default_rng(4)
    samples = {
        "silent": np.zeros(count),
        "constant": np.full(count, 9000),
        "one_step": random.integers(-1, 2, count),
        "noise": random.normal(0, 3000, count),
        "full": random.choice([-32768, 32767], count),
    }[kind]
    found = all_of(extractor, Sound(samples.astype(np.int16)))
    assert found.shape == (max(1, round(count / 16_000 * 120)), len(extractor.names))
    # Without a voiced frame what only those have is missing, in all frames alike.
    missing = np.isnan(found)
    names = {name for name, gone in zip(extractor.names, missing.all(axis=0), strict=True) if gone}
    assert (missing.any(axis=0) == missing.all(axis=0)).all() and names <= {"log_f0", *egemaps.VOICED}
    assert np.abs(found[~missing]).max() < 1e5


@pytest.mark.parametrize("extractor", EXTRACTORS)
def test_a_part_of_a_recording_has_the_features_of_the_whole(extractor, monkeypatch):
    monkeypatch.setattr(speech_features, "STRETCH", 120)
    speech_features._stretch.cache_clear()
    sound = sound_of(sentence(4.3))
    whole = all_of(extractor, sound)
    assert whole.shape == (516, len(extractor.names))
    pieces = [extractor.features(sound, first, last) for first, last in ((0, 50), (50, 51), (51, 300), (300, 516))]
    assert np.array_equal(np.concatenate(pieces), whole, equal_nan=True)
    speech_features._stretch.cache_clear()


@pytest.mark.parametrize("extractor", EXTRACTORS)
def test_stretches_do_not_show(extractor, monkeypatch):
    sound = sound_of(sentence(6.0))
    whole = all_of(extractor, sound)
    monkeypatch.setattr(speech_features, "STRETCH", 240)
    cut = all_of(extractor, Sound(sound.samples))
    voice = [number for number, name in enumerate(extractor.names) if name in {"log_f0", *egemaps.VOICED}]
    rest = [number for number in range(27) if number not in voice]
    # Windows lie at whole samples, so that other stretches move them by up to half a sample (31 us).
    assert np.abs(cut[:, rest] - whole[:, rest]).mean() < 0.01 * whole[:, rest].std(axis=0).mean()
    # F0 is tracked through a stretch and a second on either side of it: a few frames at borders of voice can differ.
    assert (np.abs(cut[:, voice] - whole[:, voice]) < 0.02 * whole[:, voice].std(axis=0)).mean() > 0.95
    speech_features._stretch.cache_clear()


def test_f0_goes_on_through_unvoiced_parts():
    samples = np.concatenate([noise(0.4), harmonics(100, 0.4), noise(0.4), harmonics(200, 0.4), np.zeros(6400)])
    found = all_of(PRAAT, sound_of(samples))[:, PRAAT_NAMES.index("log_f0")]
    assert found[:40] == pytest.approx(np.full(40, np.log(100)), abs=0.05)
    assert found[-40:] == pytest.approx(np.full(40, np.log(200)), abs=0.05)
    middle = found[100:140]
    assert (np.diff(middle) >= -1e-6).all() and abs(np.median(middle) - np.log(np.sqrt(100 * 200))) < 0.15


def test_between_voiced_against_a_plain_loop():
    random = np.random.default_rng(0)
    for _ in range(30):
        values = np.where(random.random(20) < 0.6, np.nan, random.normal(size=20))
        found, known = between_voiced(values), [i for i in range(20) if not np.isnan(values[i])]
        for place in range(20):
            left, right = [i for i in known if i <= place], [i for i in known if i >= place]
            if not known:
                assert np.isnan(found[place])
            elif not left or not right:
                assert found[place] == values[known[0] if not left else known[-1]]
            else:
                share = (place - left[-1]) / max(right[0] - left[-1], 1)
                assert found[place] == pytest.approx((1 - share) * values[left[-1]] + share * values[right[0]])


@pytest.mark.parametrize("extractor", EXTRACTORS)
def test_sound_of_another_rate_is_resampled_first(extractor):
    low = sound_of(harmonics(140, number=20, amplitude=0.5))
    high = Sound.of(harmonics(140, number=20, amplitude=0.5, rate=44_100), 44_100)
    one, other = all_of(extractor, low)[5:-5], all_of(extractor, high)[5:-5]
    names = list(extractor.names)
    for name, most in (("log_f0", 0.001), ("energy", 0.05), ("mfcc1", 30.0), ("mfcc2", 30.0)):
        column = names.index(name)
        assert np.abs(one[:, column] - other[:, column]).max() < most, name
    with pytest.raises(DataError, match="sound of 16000 Hz, not of 44100 Hz"):
        all_of(extractor, Sound(low.samples, 44_100))
