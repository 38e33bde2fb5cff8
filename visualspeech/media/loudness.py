"""Loudness of sound by EBU R 128 (ITU-R BS.1770), measured by FFmpeg's filter ``ebur128``."""

from collections.abc import Sequence

import av
import numpy as np

#: Largest sample that is left after a gain, which keeps the lossy encoder from clipping: -1 dB.
PEAK = 10 ** (-1 / 20)
_SILENT = -69.0  # LUFS; the filter's gate is at -70
_KEY = "lavfi.r128.I"


def integrated_loudness(samples: np.ndarray, rate: int) -> float:
    """Integrated loudness in LUFS of mono sound (n,) in [-1, 1]; minus infinity for silence.

    Sound shorter than the 400 ms that the measure needs is taken as repeated.
    """
    samples = np.asarray(samples, np.float32)
    if not len(samples) or not np.any(samples):
        return -np.inf
    samples = np.tile(samples, -(-rate // (2 * len(samples))))
    graph = av.filter.Graph()
    source = graph.add_abuffer(sample_rate=rate, format="flt", layout="mono")
    meter, sink = graph.add("ebur128", "metadata=1"), graph.add("abuffersink")
    source.link_to(meter)
    meter.link_to(sink)
    graph.configure()
    frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples[None]), format="flt", layout="mono")
    frame.sample_rate, frame.pts = rate, 0
    source.push(frame)
    source.push(None)
    found = -np.inf
    while True:
        try:
            found = float(sink.pull().metadata.get(_KEY, found))
        except (av.EOFError, av.BlockingIOError):
            return found if found > _SILENT else -np.inf


def common_loudness(sounds: Sequence[tuple[np.ndarray, int]], target: float) -> float:
    """The loudness in LUFS that all sounds can have without clipping: the target, or less.

    Parameters
    ----------
    sounds : samples (n,) in [-1, 1] and their rate in Hz; silent ones do not count
    target : wanted loudness in LUFS
    """
    possible = [target]
    for samples, rate in sounds:
        loudness = integrated_loudness(samples, rate)
        if np.isfinite(loudness):
            possible.append(loudness + 20 * np.log10(PEAK / np.abs(samples).max()))
    return float(min(possible))


def at_loudness(samples: np.ndarray, rate: int, target: float) -> np.ndarray:
    """The same sound with another loudness in LUFS; silence stays as it is."""
    loudness = integrated_loudness(samples, rate)
    if not np.isfinite(loudness):
        return np.asarray(samples, np.float32)
    return (np.asarray(samples, np.float32) * np.float32(10 ** ((target - loudness) / 20))).astype(np.float32)
