"""Small recordings made on the spot, good and bad, for tests. Functions only: every call writes its own file.

A recording shows a moving light patch on grey; its sound is a hum with syllables, which a voice detector takes for
speech. Nothing here is a face or a word.
"""

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np


def pictures(count: int, height: int = 96, width: int = 128) -> list[np.ndarray]:
    """RGB pictures (height, width, 3) uint8 of a moving patch; the n-th is brighter than the one before."""
    grid_y, grid_x = np.mgrid[:height, :width]
    frames = []
    for index in range(count):
        patch = np.exp(-((grid_x - 20 - index) ** 2 + (grid_y - height / 2) ** 2) / 200)
        frames.append(np.repeat((60 + index % 100 + 80 * patch).astype(np.uint8)[..., None], 3, axis=2))
    return frames


def hum(seconds: float, rate: int = 16_000, pitch: float = 120.0) -> np.ndarray:
    """Voice-like sound, float32 in [-1, 1]: harmonics under formants, four syllables a second, soft noise."""
    time = np.arange(round(seconds * rate)) / rate
    voice = np.zeros_like(time)
    for harmonic in range(1, int(min(4000, rate / 2) / pitch)):
        frequency = harmonic * pitch
        weight = sum(np.exp(-(((frequency - formant) / 150) ** 2)) for formant in (600, 1200, 2500)) + 0.02
        voice += weight * np.sin(2 * np.pi * frequency * time + harmonic)
    # No two syllables are equally loud: equal peaks would look clipped.
    syllables = np.clip(np.sin(2 * np.pi * 4 * time), 0, None) ** 0.5 * (1 - 0.5 * time / seconds)
    noise = np.random.default_rng(1).normal(size=len(time))
    return (0.5 * voice * syllables / np.abs(voice).max() + 0.001 * noise).astype(np.float32)


def record(
    path: Path,
    seconds: float = 1.0,
    rate: float = 25.0,
    audio: np.ndarray | None = None,
    audio_rate: int = 16_000,
    times: Sequence[float] | None = None,
    frames: Sequence[np.ndarray] | None = None,
    codecs: tuple[str, str] = ("libx264", "aac"),
    rotation: int = 0,
    options: dict[str, str] | None = None,
    late: float = 0.0,
    tag: str = "",
) -> Path:
    """Write a recording and return its path; the suffix says the container.

    Parameters
    ----------
    audio : mono sound; without it :func:`hum`; an empty array writes no audio stream
    times : time stamp of each picture in seconds, where the frame rate is to vary
    frames : the pictures, where the moving patch will not do
    rotation : degrees that a player is to turn the pictures, counterclockwise
    late : seconds after the sound that the pictures begin
    tag : title in the file's metadata
    """
    audio = hum(seconds, audio_rate) if audio is None else audio
    frames = pictures(len(times) if times is not None else round(seconds * rate)) if frames is None else frames
    times = np.arange(len(frames)) / rate if times is None else times
    clock = 90_000
    with av.open(str(path), "w", options=options or {}) as out:
        out.metadata.update({"title": tag} if tag else {})
        video = out.add_stream(codecs[0], rate=Fraction(rate).limit_denominator(1001))
        video.thread_count = 1
        video.pix_fmt = "yuv420p"
        video.height, video.width = frames[0].shape[:2]
        video.codec_context.time_base = (
            Fraction(1, clock) if codecs[0] == "libx264" else 1 / video.codec_context.framerate
        )
        if rotation:
            video.set_display_rotation(rotation)
        sound = out.add_stream(codecs[1], rate=audio_rate, layout="mono") if len(audio) else None
        for picture, time in zip(frames, times, strict=True):
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")
            frame.time_base = video.codec_context.time_base
            frame.pts = round((time + late) / frame.time_base)
            out.mux(video.encode(frame))
        out.mux(video.encode(None))
        if sound is not None:
            for packet in _sound_packets(sound, audio, audio_rate):
                out.mux(packet)
    return path


def _sound_packets(stream, audio: np.ndarray, rate: int):
    resampler = av.AudioResampler(
        format=stream.format.name, layout="mono", rate=rate, frame_size=stream.frame_size or 1152
    )
    frame = av.AudioFrame.from_ndarray(np.asarray(audio, np.float32)[None], format="fltp", layout="mono")
    frame.sample_rate, frame.pts = rate, 0
    for piece in [*resampler.resample(frame), *resampler.resample(None), None]:
        yield from stream.encode(piece)


def truncated(path: Path, share: float = 0.5) -> Path:
    """Cut a file down to a share of its bytes, in place."""
    data = path.read_bytes()
    path.write_bytes(data[: int(len(data) * share)])
    return path
