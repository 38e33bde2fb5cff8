"""Loudness by EBU R 128, against its definition."""

import numpy as np
import pytest

from tests import synthetic
from visualspeech.media.loudness import PEAK, at_loudness, common_loudness, integrated_loudness

RATE = 48_000


def tone(decibels, seconds=3.0, hertz=997.0, rate=RATE):
    return (10 ** (decibels / 20) * np.sin(2 * np.pi * hertz * np.arange(round(seconds * rate)) / rate)).astype(
        np.float32
    )


def by_definition(samples, rate=RATE):
    """ITU-R BS.1770-4 for one channel at 48 kHz: K-weighting, blocks of 400 ms, gates at -70 LUFS and -10 LU."""
    from scipy.signal import lfilter

    shelf = ([1.53512485958697, -2.69169618940638, 1.19839281085285], [1.0, -1.69065929318241, 0.73248077421585])
    high = ([1.0, -2.0, 1.0], [1.0, -1.99004745483398, 0.99007225036621])
    weighted = lfilter(*high, lfilter(*shelf, samples.astype(float)))
    block, step = rate * 4 // 10, rate // 10
    power = np.array([np.mean(weighted[at : at + block] ** 2) for at in range(0, len(samples) - block + 1, step)])
    loud = -0.691 + 10 * np.log10(np.maximum(power, 1e-12))
    kept = loud > -70
    kept &= loud > -0.691 + 10 * np.log10(power[kept].mean()) - 10
    return -0.691 + 10 * np.log10(power[kept].mean())


@pytest.mark.parametrize("decibels", [-3.0, -20.0, -40.0])
def test_a_tone_has_the_loudness_of_the_standard(decibels):
    # A sine of 997 Hz at full scale in one channel has -3.01 LUFS.
    assert integrated_loudness(tone(decibels), RATE) == pytest.approx(decibels - 3.01, abs=0.1)


def test_pauses_do_not_count():
    """The definition, computed on its own, gives the same figure for a sound with a long pause."""
    sound = np.concatenate([tone(-20), np.zeros(4 * RATE, np.float32), tone(-26, 2.0, 400.0)])
    assert integrated_loudness(sound, RATE) == pytest.approx(by_definition(sound), abs=0.1)
    assert integrated_loudness(sound, RATE) > -27


def test_a_short_sound_and_silence():
    assert integrated_loudness(tone(-20, 0.1), RATE) == pytest.approx(-23.0, abs=0.5)
    assert integrated_loudness(np.zeros(RATE, np.float32), RATE) == integrated_loudness(np.zeros(0), RATE) == -np.inf


def test_sounds_get_one_loudness_without_clipping():
    sounds = [(tone(-30), RATE), (synthetic.hum(2.0), 16_000), (np.zeros(RATE, np.float32), RATE)]
    target = common_loudness(sounds, -23.0)
    assert target == -23.0
    made = [at_loudness(*one, target) for one in sounds]
    assert [integrated_loudness(samples, rate) for samples, (_, rate) in zip(made[:2], sounds, strict=False)] == (
        pytest.approx([-23.0, -23.0], abs=0.1)
    )
    assert not made[2].any()
    # A click among quiet sounds limits what all of them can have.
    click = tone(-40)
    click[RATE] = 0.5
    target = common_loudness([*sounds, (click, RATE)], -23.0)
    assert target < -30 and np.abs(at_loudness(click, RATE, target)).max() == pytest.approx(PEAK, rel=0.02)
