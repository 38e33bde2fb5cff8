"""Recordings, read through PyAV: frames and sound at one constant rate. No system ffmpeg is needed.

Time in a recording counts from its first picture; sound before it is left out. Every reader here sees a recording at
one constant frame rate, the stream's average: where the time stamps vary, a frame is what the screen shows at its
middle, ``(i + 0.5) / rate``, so a slow stretch repeats pictures and a fast one drops some. A damaged packet costs its
picture, not the recording: the last good one stays. So a recording has the same number of frames whenever it is read.
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
    audio_stream,
    decoded,
    finite,
    frame_rate,
    laid_out,
    opened,
    origin,
    part,
    pictures,
    sound_chunks,
    sound_pieces,
    upright,
    video_stream,
)


@dataclass(frozen=True)
class MediaInfo:
    """What a container says of itself.

    Frame rate in Hz (the average where it varies), size in pixels as shown, sound rate in Hz (0: no audio stream);
    seconds from the first picture to the end of the recording and of its video stream (0: the header does not say), and
    seconds of sound before the first picture, which are left out.
    """

    rate: float
    width: int
    height: int
    audio_rate: int
    duration: float
    video_duration: float = 0.0
    early_sound: float = 0.0


def probe(path: str | Path) -> MediaInfo:
    """Read the headers of a recording.

    Raises
    ------
    RejectedUtterance
        The file is missing, empty, no media file, has no video stream or no frame rate.
    """
    with opened(path) as container:
        video = video_stream(container)
        audio = container.streams.audio[0] if container.streams.audio else None
        width, height = video.codec_context.width, video.codec_context.height
        if _turned(container, video):
            width, height = height, width
        rate, begin = frame_rate(video), origin(container)
        whole = float(container.duration or 0) / av.time_base
        sound = audio.start_time * audio.time_base if audio and audio.start_time is not None else begin
        # An AVI without its index is measured by what is left; its header counts the pictures.
        seconds = video.frames / rate if container.format.name == "avi" else (video.duration or 0) * video.time_base
        return MediaInfo(
            rate=rate,
            width=width,
            height=height,
            audio_rate=(audio.rate or 0) if audio else 0,
            duration=max(0.0, whole + float(container.start_time or 0) / av.time_base - begin) if whole else 0.0,
            video_duration=float(seconds),
            early_sound=max(0.0, begin - float(sound)),
        )


def _turned(container, stream) -> bool:
    """Whether the recording lies on its side; only such containers can say so, and only a picture tells."""
    if not container.format.name.startswith(("mov", "matroska")):
        return False
    first = next((frame for frame in decoded(container, stream, 0.0) if frame is not None), None)
    return first is not None and round(first.rotation / 90) % 2 == 1


def read_frames(path: str | Path, start: float = 0.0, end: float = 0.0) -> Iterator[np.ndarray]:
    """Yield the frames of a video, upright, as contiguous RGB arrays, (height, width, 3) uint8, one at a time.

    Parameters
    ----------
    path : the recording
    start, end : the part wanted, in seconds from the first picture; it begins at the frame border nearest to ``start``
        and holds ``frames_in(end - start, rate)`` frames. An ``end`` of 0 means to the recording's end.

    Raises
    ------
    RejectedUtterance
        The file cannot be opened, or not one of its pictures can be decoded.
    """
    for frame in pictures(path, start, end):
        # PyAV pads rows; detectors that take raw pointers read garbage unless the array is contiguous.
        yield np.ascontiguousarray(upright(frame.to_ndarray(format="rgb24"), frame.rotation))


def read_audio(path: str | Path, rate: int, start: float = 0.0, end: float = 0.0) -> np.ndarray:
    """The sound of a recording as mono float32 in [-1, 1] at ``rate`` Hz, shape (samples,).

    The sound begins with the first picture that :func:`read_frames` gives for the same ``start`` and ``end``. Sound
    that is missing inside the stream is silence.

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or nothing of it can be decoded.
    """
    with opened(path) as container:
        audio = audio_stream(container)
        video_rate = frame_rate(container.streams.video[0]) if container.streams.video else 0.0
        # Without pictures, milliseconds are borders fine enough.
        video_rate = video_rate or 1000.0
        first, frames = part(start, end, video_rate)
        begin = origin(container) + first
        seconds = frames / video_rate if frames else np.inf
        wanted = takewhile(
            lambda frame: frame is None or frame.time is None or frame.time < begin + seconds,
            decoded(container, audio, first),
        )
        samples = laid_out(sound_pieces(wanted, rate, begin), rate, round(seconds * rate) if frames else 0)
    if samples is None:
        raise RejectedUtterance("unreadable audio stream (nothing in it can be decoded)", UNREADABLE)
    return samples


def stream_audio(path: str | Path, rate: int) -> Iterator[np.ndarray]:
    """The sound of a recording as :func:`read_audio` gives it, a second or more at a time, whatever its length.

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or nothing of it can be decoded.
    """
    kept: list[np.ndarray] = []
    place = done = ready = 0  # samples: where the next chunk belongs, how far there is sound, how far it was given out
    nothing = True
    with opened(path) as container:
        audio = audio_stream(container)
        for begin, samples in sound_chunks(decoded(container, audio, 0.0), rate, origin(container)):
            nothing = False
            place = place if begin is None else round(begin * rate)
            late = samples[max(0, done - place) :]
            if place > done and len(late):
                kept.append(np.zeros(place - done, np.float32))
            if len(late):
                kept.append(late.astype(np.float32))
                done = max(place, done) + len(late)
            place += len(samples)
            if done - ready >= rate:
                yield finite(np.concatenate(kept))
                kept, ready = [], done
    if nothing:
        raise RejectedUtterance("unreadable audio stream (nothing in it can be decoded)", UNREADABLE)
    if kept:
        yield finite(np.concatenate(kept))


@dataclass(frozen=True)
class VideoScan:
    """What a full decoding of a recording shows.

    Parameters
    ----------
    times : time of each decoded picture in seconds from the first, shape (pictures,)
    damaged : times of pictures that could not be decoded, or only in part, shape (damaged,)
    frames : number of frames that :func:`read_frames` yields for the same part
    change : largest mean change of brightness between successive pictures, in grey levels
    digest : of the decoded pictures
    """

    times: np.ndarray
    damaged: np.ndarray
    frames: int
    change: float
    digest: str


def scan_video(path: str | Path, start: float = 0.0, end: float = 0.0) -> VideoScan:
    """Decode the part of a recording that :func:`read_frames` would give, and report on it.

    Raises
    ------
    RejectedUtterance
        The file cannot be opened, or not one of its pictures can be decoded.
    """
    times: list[float] = []
    damaged: list[float] = []
    content = hashlib.sha256()
    change, before = 0.0, None

    def looked_at(items):
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

    frames = sum(1 for _ in pictures(path, start, end, looked_at))
    return VideoScan(np.array(times), np.array(damaged), frames, change, content.hexdigest()[:32])


def _luma(frame) -> np.ndarray:
    """Brightness of a picture, (height, width) uint8, without converting colours where the format allows."""
    if frame.format.name.startswith(("yuv", "nv12", "gray")) and frame.format.components[0].bits == 8:
        plane = frame.planes[0]
        rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
        return np.ascontiguousarray(rows[: frame.height, : frame.width])
    return np.ascontiguousarray(frame.to_ndarray(format="gray"))
