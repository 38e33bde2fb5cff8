"""Log-mel spectra of a sound at any times, and what a recording's level and channel add to them.

The unit is decibel, so that a gain adds a constant to all bands and a channel (microphone, room, line) one constant to
each band. Both are removed by subtracting the mean of each band over the recording's speech. Speech is what lies within
some decibels of the loud parts: a mean over everything would depend on how long the speaker pauses and on the noise in
the pauses.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from visualspeech.speech.sound import BLOCK, Sound, spans

FFT_SIZE = 2048  # points of the Fourier transform; at 16 kHz a bin every 7.8 Hz, so that no narrow band is empty
FLOOR_DB = -100.0  # power in a band, relative to full scale, below which everything is silence; about 16-bit rounding
LOUD = 95.0  # percentile of the levels of all frames that stands for the loud parts of a recording
_AT_A_TIME = 500  # frames that are transformed at a time, 8 MB
_HISTOGRAM = np.arange(FLOOR_DB, 60.0, 0.5)  # dB; lower borders of the classes of levels


def mel(hertz):
    """Pitch in mel of a frequency (O'Shaughnessy 1987)."""
    return 2595 * np.log10(1 + np.asarray(hertz, np.float64) / 700)


def hertz_of(mels):
    """The inverse of :func:`mel`."""
    return 700 * (10 ** (np.asarray(mels, np.float64) / 2595) - 1)


def mel_filters(bands: int, low_hz: float, high_hz: float, rate: float) -> np.ndarray:
    """Triangular filters, equally wide in mel, each with a peak of 1, (``FFT_SIZE`` // 2 + 1, bands)."""
    borders = hertz_of(np.linspace(mel(low_hz), mel(high_hz), bands + 2))
    bins = np.arange(FFT_SIZE // 2 + 1)[:, None] * rate / FFT_SIZE
    rising = (bins - borders[:-2]) / np.diff(borders)[:-1]
    falling = (borders[2:] - bins) / np.diff(borders)[1:]
    return np.maximum(np.minimum(rising, falling), 0)


@dataclass(frozen=True)
class MelBands:
    """A filter bank and its window.

    Parameters
    ----------
    bands : number of bands
    low_hz, high_hz : borders of the lowest and the highest band
    window : seconds of a Hann window
    """

    bands: int
    low_hz: float
    high_hz: float
    window: float

    def spectra(self, sound: Sound, times: np.ndarray) -> np.ndarray:
        """Power of each band in dB relative to full scale, (T, bands) float64, in windows around ``times`` (T,) s.

        Outside the recording there is digital silence. Times are ascending; a part of the sound is read at a time.
        """
        filters = mel_filters(self.bands, self.low_hz, self.high_hz, sound.rate)
        size = max(2, round(self.window * sound.rate))
        shape = np.hanning(size + 1)[:size]
        firsts = np.round(np.asarray(times) * sound.rate).astype(np.int64) - size // 2
        result = np.empty((len(times), self.bands))
        # Far apart, fewer of them are read at a time.
        apart = (times[-1] - times[0]) / len(times) if len(times) else 0.0
        for begin, end in spans(len(times), max(1, int(min(_AT_A_TIME, BLOCK / max(apart, 1e-9))))):
            own = firsts[begin:end]
            samples = sound.between(int(own[0]), int(own[-1]) + size)
            frames = np.lib.stride_tricks.sliding_window_view(samples, size)[own - own[0]]
            power = np.abs(np.fft.rfft(frames * shape, FFT_SIZE)) ** 2 / (shape**2).sum()
            result[begin:end] = 10 * np.log10(np.maximum(power @ filters, 10 ** (FLOOR_DB / 10)))
        return result


@dataclass(frozen=True)
class BandStatistics:
    """Mean and standard deviation of each band over the speech of a recording.

    Parameters
    ----------
    mean, deviation : (bands,) dB
    """

    mean: np.ndarray
    deviation: np.ndarray


def band_statistics(sound: Sound, bands: MelBands, step: float, speech_range: float) -> BandStatistics:
    """Statistics of a recording's speech, in one pass that holds a part of the sound in memory.

    Parameters
    ----------
    step : seconds between spectra
    speech_range : dB below the loud parts (their :data:`LOUD` percentile) down to which sound counts as speech
    """
    counts = np.zeros(len(_HISTOGRAM))
    sums, squares = np.zeros((2, len(_HISTOGRAM), bands.bands))
    for times in _grid(sound, step):
        spectra = bands.spectra(sound, times)
        level = 10 * np.log10((10 ** (spectra / 10)).sum(axis=1))
        number = np.clip(np.searchsorted(_HISTOGRAM, level, side="right") - 1, 0, None)
        counts += np.bincount(number, minlength=len(counts))
        np.add.at(sums, number, spectra)
        np.add.at(squares, number, spectra**2)
    loud = int(np.searchsorted(np.cumsum(counts), LOUD / 100 * counts.sum()))
    speech = _HISTOGRAM >= _HISTOGRAM[loud] - speech_range
    total = counts[speech].sum()
    mean = sums[speech].sum(axis=0) / total
    return BandStatistics(mean, np.sqrt(np.maximum(squares[speech].sum(axis=0) / total - mean**2, 0)))


def levels(sound: Sound, step: float) -> np.ndarray:
    """Level in dB relative to full scale between 200 and 6800 Hz every ``step`` seconds, (T,) float32, at least one."""
    bands = MelBands(20, 200.0, 6800.0, 0.025)
    found = [(10 ** (bands.spectra(sound, times) / 10)).sum(axis=1) for times in _grid(sound, step)]
    return (10 * np.log10(np.concatenate(found))).astype(np.float32)


def _grid(sound: Sound, step: float) -> Iterator[np.ndarray]:
    """Times at the middle of every ``step`` seconds of a sound, at least one, some seconds of them at a time."""
    for first, last in spans(max(1, int(sound.seconds / step)), max(1, int(BLOCK / step))):
        yield (np.arange(first, last) + 0.5) * step
