"""The block of log-mel bands: its frames, its normalisation, recordings that say nothing, and files of strangers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import firwin, lfilter

from visualspeech.errors import DamagedFile, DataError, SettingError
from visualspeech.features.blocks.base import Source, restore
from visualspeech.features.blocks.log_mel import LIMIT, LogMel, LogMelSettings, statistics_of
from visualspeech.fields import with_defaults
from visualspeech.speech.sound import RATE, Sound


def fitted(rate=25.0, **settings):
    return LogMel.fit(with_defaults(LogMelSettings, settings), (), iter([Source(10, rate)]))


def speech(seconds=3.0, seed=0):
    """Bursts of noise of changing level and colour, with pauses at both ends, (n,) float64."""
    random = np.random.default_rng(seed)
    parts = []
    for _ in range(round(seconds / 0.1)):
        low = random.uniform(100, 2500)
        taps = firwin(101, [low, low + random.uniform(500, 4000)], pass_zero=False, fs=RATE)
        parts.append(lfilter(taps, 1, random.normal(0, 8000, RATE // 10)) * 10 ** random.uniform(-1, 0))
    parts = [part * 0.01 if number < 4 or number > len(parts) - 5 else part for number, part in enumerate(parts)]
    return np.concatenate(parts)


def stream(block, samples, frames=75, rate=25.0, begin=0.0):
    source = Source(frames, rate, sound=Sound(np.round(samples).astype(np.int16)), begin=begin)
    return next(iter(block.encode([source]))).values


def test_a_frame_holds_the_spectra_of_its_parts_side_by_side():
    samples = speech()
    for rate, per_frame in ((25.0, 4), (50.0, 2), (29.97, 3), (100.0, 1), (120.0, 1), (10.0, 10)):
        block = fitted(rate, normalisation="none")
        assert (block.per_frame, block.layout.dimension) == (per_frame, 28 * per_frame)
        frames = int(3 * rate)
        found = stream(block, samples, frames, rate).reshape(frames * per_frame, 28)
        times = [(frame + (part + 0.5) / per_frame) / rate for frame in range(frames) for part in range(per_frame)]
        sound = Sound(np.round(samples).astype(np.int16))
        assert np.allclose(found, np.clip((block.bands.spectra(sound, np.array(times)) + 50) / 20, -LIMIT, LIMIT))


def test_normalised_bands_have_mean_0_and_variance_1_in_speech():
    block = fitted(speech_range=200.0)  # all of the recording
    values = stream(block, speech()).reshape(-1, 28)
    assert np.abs(values.mean(axis=0)).max() < 0.05 and np.abs(values.std(axis=0) - 1).max() < 0.05
    # Silence beside the speech changes nothing of it: it is not speech.
    block, padding = fitted(), np.random.default_rng(1).normal(0, 5, 5 * RATE)
    longer = np.concatenate([padding, speech(), padding])
    inner = stream(block, longer, 75, begin=5.0)
    assert np.abs(inner - stream(block, speech()))[8:-8].mean() < 0.02


@pytest.mark.parametrize("gain", [0.1, 0.37, 2.0])
def test_the_level_of_a_recording_does_not_matter(gain):
    random = np.random.default_rng(2)
    samples = speech() * 0.5 + random.normal(0, 30, 3 * RATE)
    plain, other = stream(fitted(), samples), stream(fitted(), samples * gain)
    assert np.abs(plain - other).mean() < 0.02 and np.abs(plain).mean() > 0.5


def test_the_channel_of_a_recording_does_not_matter():
    samples = speech() + np.random.default_rng(3).normal(0, 30, 3 * RATE)
    # A channel that takes 20 dB from high frequencies, and one with an echo's comb in miniature.
    for taps in (firwin(31, 1500, fs=RATE) * 0.9 + np.eye(31)[15] * 0.1, np.array([1, 0.5, -0.2])):
        moved = len(taps) // 2
        heard = np.convolve(samples, taps)[moved : moved + len(samples)]
        plain = stream(fitted(normalisation="none"), samples) - stream(fitted(normalisation="none"), heard)
        normalised = stream(fitted(), samples) - stream(fitted(), heard)
        assert np.abs(normalised).mean() < np.abs(plain).mean() / 5


@pytest.mark.parametrize("count", [0, 1, 16, 400, 16_000])
@pytest.mark.parametrize("kind", ["silent", "constant", "one_step", "noise", "full"])
def test_recordings_without_speech_do_not_explode(count, kind):
    random = np.random.default_rng(4)
    samples = {
        "silent": np.zeros(count),
        "constant": np.full(count, 9000.0),
        "one_step": random.integers(-1, 2, count),
        "noise": random.normal(0, 3000, count),
        "full": random.choice([-32768, 32767], count),
    }[kind]
    for normalisation in ("variance", "mean", "none"):
        values = stream(fitted(normalisation=normalisation), samples, max(1, count // 640))
        assert np.isfinite(values).all() and np.abs(values).max() <= LIMIT
    if kind == "noise" and count == 16_000:
        assert stream(fitted(), samples, 25).std() < 2


def test_a_part_of_a_recording_is_that_part_of_all_of_it():
    block, sound = fitted(), Sound(np.round(speech()).astype(np.int16))
    (whole,) = block.encode([Source(75, 25.0, sound=sound)])
    pieces = [Source(count, 25.0, sound=sound, begin=first / 25) for first, count in ((0, 30), (30, 1), (31, 44))]
    found = np.concatenate([one.values for one in block.encode(pieces)])
    assert np.allclose(found, whole.values, atol=1e-5)
    before = statistics_of.cache_info().misses
    list(block.encode(pieces))
    assert statistics_of.cache_info().misses == before  # those of one recording are computed once


def test_without_sound_or_training_it_cannot_be_computed():
    with pytest.raises(DataError, match="log_mel is computed from sound"):
        list(fitted().encode([Source(3, 25.0)]))
    with pytest.raises(DataError, match="no training utterance"):
        LogMel.fit(with_defaults(LogMelSettings, {}), (), iter(()))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"low_hz": 5000}, "low_hz: 5000.*at most 1000"),
        ({"bands": 81}, "bands: 81.*at most 80"),
        ({"high_hz": 9000}, "high_hz: 9000.*at most 8000"),
        ({"normalisation": "global"}, "normalisation: global"),
        ({"step": 0}, "step: 0"),
    ],
)
def test_settings_that_make_no_sense_are_a_sentence(settings, said):
    with pytest.raises(SettingError, match=said):
        LogMelSettings(**settings)


@pytest.mark.parametrize(
    "changes",
    [
        {"per_frame": 0}, {"per_frame": 10**6}, {"bands": 0}, {"bands": 1000}, {"window": 1e-9}, {"step": 0},
        {"low_hz": 7000}, {"high_hz": 100}, {"high_hz": 1e9}, {"bands": 2.5}, {"normalisation": "x"},
        {"more": 1}, {"speech_range": None},
    ],
)  # fmt: skip
def test_states_of_strangers_are_refused(changes):
    _, plain = fitted(high_hz=6000.0).state()
    with pytest.raises(DamagedFile, match="model.safetensors"):
        restore("log_mel", {}, {**plain, **changes}, "model.safetensors")
    assert restore("log_mel", {}, plain) == fitted(high_hz=6000.0)
    assert replace(fitted(), per_frame=3).layout.dimension == 84
