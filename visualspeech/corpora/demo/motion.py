"""Random movement of the head and the eyelids and changes of light, drawn from one generator per utterance."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """Head movement, blinks and light of T frames.

    Parameters
    ----------
    rotation : (T, 3) Rodrigues vectors, radians
    translation : (T, 3) canonical pixels
    closed_eyes : (T,) 0 open to 1 closed
    gain : (T, 3) factors on red, green and blue
    slope : relative change of light from the left to the right border of the frame
    """

    rotation: np.ndarray
    translation: np.ndarray
    closed_eyes: np.ndarray
    gain: np.ndarray
    slope: float


def draw(times: np.ndarray, random: np.random.Generator) -> Motion:
    """Random motion at ``times`` (T,) seconds: slow swaying about a position that varies a little per utterance."""
    degrees = np.stack([_sway(times, random, size) for size in (1.6, 2.6, 1.2)], axis=1)
    degrees += random.uniform(-1, 1, 3) * [1.5, 2.5, 1.0]
    translation = np.stack([_sway(times, random, size) for size in (2.0, 1.4, 7.0)], axis=1)
    translation += random.uniform(-1, 1, 3) * [3.0, 2.0, 12.0]
    gain = 1 + 0.006 * _sway(times, random, 1.0)[:, None] + random.uniform(-0.035, 0.035)
    gain = gain * (1 + random.uniform(-0.012, 0.012) * np.array([1.0, 0.0, -1.0]))
    slope = random.uniform(-0.05, 0.05)
    return Motion(np.radians(degrees), translation, _blinks(times, random), gain, slope)


def _sway(times: np.ndarray, random: np.random.Generator, size: float) -> np.ndarray:
    """Smooth random movement (T,): a sum of five sines from 0.12 to 1.1 Hz whose amplitudes fall with frequency."""
    frequencies = np.geomspace(0.12, 1.1, 5) * random.uniform(0.85, 1.15, 5)
    phases = random.uniform(0, 2 * np.pi, 5)
    amplitudes = frequencies**-0.8
    waves = np.sin(2 * np.pi * frequencies[:, None] * times[None] + phases[:, None])
    return size * (amplitudes[:, None] * waves).sum(axis=0) / np.sqrt((amplitudes**2).sum() / 2)


def _blinks(times: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Closure of the eyes (T,), 0 open to 1 closed, with blinks at random intervals."""
    closed = np.zeros(len(times))
    start = random.uniform(0.2, 2.5)
    while start < times[-1]:
        phase = times - start
        lid = np.interp(phase, [0, 0.09, 0.13, 0.32], [0, 1, 1, 0], left=0, right=0)
        closed = np.maximum(closed, lid * lid * (3 - 2 * lid))
        start += random.uniform(1.8, 4.5)
    return closed
