"""Sounds whose features are known: sums of harmonics, vowels, noise."""

import numpy as np
from scipy.signal import lfilter

from visualspeech.speech.sound import RATE, Sound


def sound_of(samples) -> Sound:
    """Samples (n,) in [-1, 1] at 16 kHz."""
    return Sound(np.round(np.clip(samples, -1, 1) * 32767).astype(np.int16))


def harmonics(hertz, seconds=1.0, rate=RATE, number=10, amplitude=0.3) -> np.ndarray:
    """The sum of the first harmonics of an F0 in Hz, a number or one for each sample, (n,)."""
    phase = 2 * np.pi * np.cumsum(np.broadcast_to(hertz, round(seconds * rate))) / rate
    parts = [np.sin(k * phase) / k for k in range(1, number + 1)]
    return amplitude * np.sum(parts, axis=0) / 1.6


def vowel(hertz, formants, seconds=1.0, seed=0) -> np.ndarray:
    """Pulses of an F0 in Hz through resonators at the formants in Hz, with a little noise, (n,)."""
    source = np.zeros(round(seconds * RATE))
    source[np.arange(0, len(source), RATE / hertz).astype(int)] = 1
    source += np.random.default_rng(seed).normal(0, 0.003, len(source))
    for formant in formants:
        radius = np.exp(-np.pi * 80 / RATE)
        source = lfilter([1], [1, -2 * radius * np.cos(2 * np.pi * formant / RATE), radius**2], source)
    return 0.1 * source / source.std()


def noise(seconds=1.0, deviation=0.05, seed=0) -> np.ndarray:
    """White noise, (n,)."""
    return np.random.default_rng(seed).normal(0, deviation, round(seconds * RATE))


def sentence(seconds=2.0, hertz=120.0, seed=0) -> np.ndarray:
    """Vowels, noises and pauses that follow each other at random, (n,)."""
    random = np.random.default_rng(seed)
    parts, total = [], 0.0
    while total < seconds:
        length = random.uniform(0.08, 0.2)
        kind = random.integers(4)
        if kind < 2:
            formants = (random.uniform(300, 800), random.uniform(900, 2200), random.uniform(2300, 3000))
            part = vowel(hertz * random.uniform(0.9, 1.1), formants, length, int(random.integers(1000)))
        else:
            part = noise(length, 0.03 if kind == 2 else 0.0005, int(random.integers(1000)))
        parts.append(part * random.uniform(0.5, 1))
        total += length
    return np.concatenate(parts)[: round(seconds * RATE)]
