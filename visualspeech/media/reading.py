"""Reading of recordings through PyAV: frames and sound at one constant rate. No system ffmpeg is needed.

Time in a recording counts from its first frame; earlier sound is left out. All functions here read a recording at one
constant frame rate, the average of the stream: frame ``i`` is what is on screen at ``(i + 0.5) / rate``. Where time
stamps vary, frames are therefore repeated or dropped. A frame that cannot be decoded is replaced by the last good one.
A recording thus has the same number of frames whenever it is read.
"""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.media.decoding import (
    UNREADABLE,
    audio_chunks,
    audio_stream,
    constant_rate_frames,
    decode_stream,
    finite,
    frame_rate,
    gapless_stretches,
    open_media,
    origin,
    to_frame_borders,
    upright,
    video_stream,
    with_silence,
)

#: Containers whose header states the duration, which outlives a truncation.
HEADERS = ("mov", "matroska", "avi", "asf", "flv")


@dataclass(frozen=True)
class MediaInfo:
    """What the headers of a recording state.

    Parameters
    ----------
    rate : frame rate in Hz, the average if it varies
    width, height : size in pixels as shown
    audio_rate : sample rate in Hz; 0 if there is no audio stream, or none that can be decoded
    duration, video_duration : seconds from the first frame to the end of the recording and of its video stream; 0 if
        the header does not state them
    early_sound : seconds of sound before the first frame, which are left out
    announced : whether the header states the durations; else they are those of what is left of the file
    """

    rate: float
    width: int
    height: int
    audio_rate: int
    duration: float
    video_duration: float = 0.0
    early_sound: float = 0.0
    announced: bool = False


def probe(path: str | Path) -> MediaInfo:
    """What the headers of a recording state.

    Raises
    ------
    RejectedUtterance
        The file is missing, empty or not a media file, or has no video stream or no frame rate.
    """
    with open_media(path) as container:
        video = video_stream(container)
        audio = container.streams.audio[0] if container.streams.audio else None
        codec = audio.codec_context if audio else None
        width, height = video.codec_context.width, video.codec_context.height
        if _is_sideways(container, video):
            width, height = height, width
        rate, begin = frame_rate(video), origin(container)
        whole = float(container.duration or 0) / av.time_base
        times = (audio.start_time, audio.time_base) if audio else (None, None)
        sound = begin if None in times else times[0] * times[1]
        # FFmpeg takes the duration of an AVI without index from what is left of it; the header has the frame count.
        stated = float(video.duration or 0) * float(video.time_base or 0)
        return MediaInfo(
            rate=rate,
            width=width,
            height=height,
            audio_rate=(codec.sample_rate or 0) if codec else 0,
            duration=max(0.0, whole + float(container.start_time or 0) / av.time_base - begin) if whole else 0.0,
            video_duration=video.frames / rate if container.format.name == "avi" else stated,
            early_sound=max(0.0, begin - float(sound)),
            announced=container.format.name.startswith(HEADERS),
        )


def sound_rate(path: str | Path) -> int:
    """Sample rate of the sound of a file, with or without video, in Hz; 0 if there is no sound.

    Raises
    ------
    RejectedUtterance
        The file is missing, empty or not a media file.
    """
    with open_media(path) as container:
        audio = container.streams.audio[0] if container.streams.audio else None
        return (audio.codec_context.sample_rate or 0) if audio and audio.codec_context else 0


def _is_sideways(container, stream) -> bool:
    """Whether the recording is rotated by 90 degrees; only MOV and Matroska can be, and only a decoded frame tells."""
    if not container.format.name.startswith(("mov", "matroska")):
        return False
    first = next((frame for frame in decode_stream(container, stream, 0.0) if frame is not None), None)
    return first is not None and round(first.rotation / 90) % 2 == 1


def read_frames(path: str | Path, start: float = 0.0, end: float = 0.0) -> Iterator[np.ndarray]:
    """Yield the frames of a video, upright, as contiguous RGB arrays, (height, width, 3) uint8, one at a time.

    Parameters
    ----------
    path : the recording
    start, end : segment to read, in seconds from the first frame; it begins at the frame border nearest to ``start``
        and has ``frames_in(end - start, rate)`` frames. An ``end`` of 0 means to the recording's end.

    Raises
    ------
    RejectedUtterance
        The file cannot be opened, or no frame of the segment can be decoded.
    """
    for frame in constant_rate_frames(path, start, end):
        # PyAV pads rows, and detectors that take raw pointers need a contiguous array.
        yield np.ascontiguousarray(upright(frame.to_ndarray(format="rgb24"), frame.rotation))


def read_audio(path: str | Path, rate: int, start: float = 0.0, end: float = 0.0) -> np.ndarray:
    """The sound of a recording as mono float32 in [-1, 1] at ``rate`` Hz, shape (samples,).

    The sound begins with the first frame of :func:`read_frames` for the same ``start`` and ``end``. Gaps in the stream
    are filled with silence.

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or nothing of it can be decoded.
    """
    with open_media(path) as container:
        audio = audio_stream(container)
        video_rate = frame_rate(container.streams.video[0]) if container.streams.video else 0.0
        # Without video, borders of milliseconds are fine enough.
        video_rate = video_rate or 1000.0
        first, frames = to_frame_borders(start, end, video_rate)
        begin = origin(container) + first
        seconds = frames / video_rate if frames else np.inf
        wanted = takewhile(
            lambda frame: frame is None or frame.time is None or frame.time < begin + seconds,
            decode_stream(container, audio, first),
        )
        samples = with_silence(gapless_stretches(wanted, rate, begin), rate, round(seconds * rate) if frames else 0)
    if samples is None:
        raise RejectedUtterance("unreadable audio stream (nothing in it can be decoded)", UNREADABLE)
    return samples


def stream_audio(path: str | Path, rate: int) -> Iterator[np.ndarray]:
    """Yield the sound of a recording as :func:`read_audio` returns it, in blocks of at least a second.

    Memory does not grow with the duration.

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or nothing of it can be decoded.
    """
    kept: list[np.ndarray] = []
    position = done = yielded = 0  # samples: start of the next chunk, end of the sound so far, end of what was yielded
    empty = True
    with open_media(path) as container:
        audio = audio_stream(container)
        for begin, samples in audio_chunks(decode_stream(container, audio, 0.0), rate, origin(container)):
            empty = False
            position = position if begin is None else round(begin * rate)
            new = samples[max(0, done - position) :]
            if position > done and len(new):
                kept.append(np.zeros(position - done, np.float32))
            if len(new):
                kept.append(new.astype(np.float32))
                done = max(position, done) + len(new)
            position += len(samples)
            if done - yielded >= rate:
                yield finite(np.concatenate(kept))
                kept, yielded = [], done
    if empty:
        raise RejectedUtterance("unreadable audio stream (nothing in it can be decoded)", UNREADABLE)
    if kept:
        yield finite(np.concatenate(kept))


@dataclass(frozen=True)
class VideoScan:
    """Result of the full decoding of a segment of a recording.

    Parameters
    ----------
    times : times of the D decoded frames in seconds from the first, shape (D,)
    damaged : times of the frames that could not be decoded, or only in part, shape (damaged,)
    frames : number of frames that :func:`read_frames` yields for the same segment
    change : largest mean absolute difference between successive decoded frames, in grey levels
    digest : of the decoded frames
    """

    times: np.ndarray
    damaged: np.ndarray
    frames: int
    change: float
    digest: str


def scan_video(path: str | Path, start: float = 0.0, end: float = 0.0) -> VideoScan:
    """Decode a segment of a recording, given as for :func:`read_frames`, and report on it.

    Raises
    ------
    RejectedUtterance
        The file cannot be opened, or no frame of the segment can be decoded.
    """
    times: list[float] = []
    damaged: list[float] = []
    content = hashlib.sha256()
    change, before = 0.0, None

    def inspect(items):
        nonlocal change, before
        for time, frame in items:
            inside = time >= start - 0.05
            if inside and (frame is None or frame.is_corrupt):
                damaged.append(time)
            if inside and frame is not None:
                times.append(time)
                luma = _luma(frame)
                content.update(luma)
                small = luma[::4, ::4].astype(np.int16)
                if before is not None and before.shape == small.shape:
                    change = max(change, float(np.abs(small - before).mean()))
                before = small
            yield time, frame

    frames = sum(1 for _ in constant_rate_frames(path, start, end, inspect))
    return VideoScan(np.array(times), np.array(damaged), frames, change, content.hexdigest()[:32])


def _luma(frame) -> np.ndarray:
    """Brightness of a frame, (height, width) uint8; colours are converted only if the format requires it."""
    if frame.format.name.startswith(("yuv", "nv12", "gray")) and frame.format.components[0].bits == 8:
        plane = frame.planes[0]
        rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
        return np.ascontiguousarray(rows[: frame.height, : frame.width])
    return np.ascontiguousarray(frame.to_ndarray(format="gray"))
