"""What is taken for speech, and the geometry of the decoder's frames."""

import numpy as np

from visualspeech.speech.recognition import DELAY, RATE, STEP, padded, recognise_words, speech_part


def burst(start, end, duration=3.0, level=3000.0):
    """Noise from ``start`` to ``end`` seconds in much quieter noise."""
    random = np.random.default_rng(1)
    times = np.arange(round(duration * RATE)) / RATE
    return np.round(random.normal(0, np.where((times >= start) & (times < end), level, 10.0))).astype(np.int16)


def test_speech_is_where_it_is_loud():
    first, last = speech_part(burst(0.8, 1.7), 0.3, 0.1)
    assert abs(first / RATE - 0.7) < 0.02
    assert abs(last / RATE - 1.8) < 0.02


def test_a_click_is_no_speech():
    samples = burst(0.8, 1.7)
    click = slice(round(0.3 * RATE), round(0.3 * RATE) + 80)
    samples[click] = burst(0.0, 3.0, level=8000)[click]
    assert abs(speech_part(samples, 0.3, 0.0)[0] / RATE - 0.8) < 0.02


def test_a_hum_below_the_voice_is_no_speech():
    samples = burst(0.8, 1.7).astype(float)
    samples += 2000 * np.sin(2 * np.pi * 50 * np.arange(len(samples)) / RATE)
    assert abs(speech_part(samples.astype(np.int16), 0.3, 0.0)[0] / RATE - 0.8) < 0.02


def test_steady_and_short_sounds_are_kept_whole():
    assert speech_part(np.zeros(RATE, np.int16), 0.3, 0.1) == (0, RATE)
    assert speech_part(np.ones(100, np.int16), 0.3, 0.1) == (0, 100)


def test_padding_is_always_the_same_noise():
    samples = np.arange(1000, dtype=np.int16)
    sound = padded(samples, 0.2, 5.0)
    assert sound.dtype == np.int16
    assert len(sound) == len(samples) + 2 * 3200
    assert np.array_equal(sound, padded(samples, 0.2, 5.0))
    assert np.array_equal(sound[3200:4200], samples)
    assert 4 < sound[:3200].std() < 6


def test_a_border_lies_midway_between_the_middles_of_its_frames():
    # Frame k sees the samples k * STEP ... k * STEP + 410; the decoder's windows are 25.625 ms every 10 ms.
    middles = np.arange(5) * STEP + round(0.025625 * RATE) / 2
    assert np.allclose((middles[:-1] + middles[1:]) / 2, np.arange(1, 5) * STEP + DELAY)


def test_too_little_sound_for_the_words():
    words = ["hello"] * 20
    assert recognise_words(burst(0.1, 0.2, 0.3), words, {"hello": [("hh", "ah", "l", "ow")]}, 0.05) is None
