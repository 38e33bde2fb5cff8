"""Decoding by time: the frames and the sound of a recording or of a segment of it, whatever its container."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.timing import frames_in

UNREADABLE = "Play the file in a media player; copy or convert it again (H.264 video and AAC sound in MP4 is safe)."
MIN_SOUND_GAP = 0.04  # seconds; longer gaps in the sound are filled with silence, shorter ones are closed
MIN_SEEK_TIME = 20.0  # seconds; segments that begin earlier are decoded from the beginning of the recording
MAX_GAP = 10.0  # seconds; a time stamp further ahead is treated as an error
SEEK_MARGIN = 12.0  # seconds before the segment to seek to: containers without an index need a key frame in between


@contextmanager
def open_media(path: str | Path) -> Iterator:
    """An opened container; errors of opening and reading it become a :class:`RejectedUtterance`."""
    try:
        with av.open(str(path)) as container:
            yield container
    except FileNotFoundError as error:
        raise RejectedUtterance("the file does not exist", "Correct its name, or bring the file back.") from error
    except (av.FFmpegError, OSError) as error:
        empty = Path(path).is_file() and Path(path).stat().st_size == 0
        reason = "empty: 0 bytes" if empty else short_message(error)
        raise RejectedUtterance(f"unreadable media file ({reason})", UNREADABLE) from error


def video_stream(container):
    """The video stream of a container, ready to decode.

    Raises
    ------
    RejectedUtterance
        There is none, or it has no frame rate.
    """
    if not container.streams.video:
        raise RejectedUtterance("no video stream", "Give the recording's video file.")
    stream = container.streams.video[0]
    if not frame_rate(stream):
        raise RejectedUtterance("no frame rate in the video file", UNREADABLE)
    # With one decoding thread pixels and cost are the same on every machine.
    stream.codec_context.thread_count = 1
    return stream


def audio_stream(container):
    """The audio stream of a container.

    Raises
    ------
    RejectedUtterance
        There is none.
    """
    if not container.streams.audio:
        raise RejectedUtterance("no audio stream", "Record with sound, or mux the sound into the video file.")
    return container.streams.audio[0]


def frame_rate(stream) -> float:
    """Frames per second, the average if it varies; 0 if the container does not state it."""
    return float(stream.average_rate or stream.guessed_rate or 0)


def origin(container) -> float:
    """Time stamp of the first frame in seconds; of the first sound if there is no video."""
    for stream in (*container.streams.video[:1], *container.streams.audio[:1]):
        if stream.start_time is not None:
            return float(stream.start_time * stream.time_base)
    return 0.0


def to_frame_borders(start: float, end: float, rate: float) -> tuple[float, int]:
    """Start in seconds, moved to a frame border, and number of frames (0: to the end) of a segment of a recording.

    From a border on, the times ``(i + 0.5) / rate`` lie far from the time stamps, where rounding would decide.
    """
    first = np.floor(start * rate + 0.5) / rate
    return float(first), max(1, frames_in(end - first, rate)) if end else 0


def decode_stream(container, stream, first: float) -> Iterator:
    """Frames of a stream from ``first`` seconds after its beginning, or a little before; None for a damaged packet."""
    if first >= MIN_SEEK_TIME and stream.start_time is not None:
        with suppress(av.FFmpegError, OSError):  # streams without seeking are decoded from the beginning
            container.seek(stream.start_time + int((first - SEEK_MARGIN) / stream.time_base), stream=stream)
    try:
        for packet in container.demux(stream):
            try:
                yield from packet.decode()
            except (av.FFmpegError, OSError):
                yield None
    except (av.FFmpegError, OSError):  # the file ends in the middle of a packet
        yield None


def constant_rate_frames(path, start: float, end: float, inspect=iter) -> Iterator:
    """Decoded frames of a segment of a recording, at its constant frame rate.

    Parameters
    ----------
    start, end : seconds from the first frame; an ``end`` of 0 means to the recording's end
    inspect : a generator that receives (time, frame or None) of all that is decoded and yields it unchanged

    Raises
    ------
    RejectedUtterance
        The file cannot be opened, or no frame of the segment can be decoded.
    """
    with open_media(path) as container:
        stream = video_stream(container)
        rate = frame_rate(stream)
        first, frames = to_frame_borders(start, end, rate)
        timed = _timed(decode_stream(container, stream, first), rate, origin(container))
        count = 0
        for frame in _held(inspect(timed), rate, first, frames):
            count += 1
            yield frame
    if not count:
        raise RejectedUtterance(
            "unreadable video stream (no frame of this segment can be decoded)",
            f"{UNREADABLE} If the corpus gives start and end, check that they lie inside the recording.",
        )


def _timed(frames: Iterable, rate: float, origin: float) -> Iterator[tuple[float, object]]:
    """(seconds from the first frame, frame), ascending; None for a frame whose size is not that of the first.

    A time stamp that is missing or not later than the last one is replaced by that of one frame later. Where the clock
    jumps, the following time stamps are corrected by the jump.
    """
    last, size = None, None
    for frame in frames:
        due = 0.0 if last is None else last + 1.0 / rate
        if frame is None:
            yield due, None
            continue
        stamp = due + origin if frame.time is None else frame.time
        if last is not None and _clock_jumps(stamp - origin - due):
            origin = stamp - due
        time = stamp - origin
        last = due if last is not None and time <= last else time
        size = size or (frame.width, frame.height)
        yield last, frame if (frame.width, frame.height) == size else None


def _clock_jumps(seconds: float) -> bool:
    """Whether a deviation is a reset of the clock, as in joined recordings or damaged files."""
    return not -1.0 < seconds < MAX_GAP


def _held(timed: Iterable[tuple[float, object]], rate: float, first: float, frames: int) -> Iterator:
    """The frame on screen at ``first + (i + 0.5) / rate``: each decoded frame is shown until the next one."""
    index, shown, time_shown = 0, None, 0.0
    for time, frame in timed:
        if frame is None:
            continue
        while shown is not None and first + (index + 0.5) / rate < time:
            yield shown
            index += 1
            if index == frames:
                return
        shown, time_shown = frame, time
    while shown is not None and first + (index + 0.5) / rate < time_shown + 1.0 / rate:
        yield shown
        index += 1
        if index == frames:
            return


def audio_chunks(frames: Iterable, rate: int, origin: float) -> Iterator[tuple[float | None, np.ndarray]]:
    """(start, mono samples at ``rate`` Hz) of each audio frame.

    The start, in seconds from ``origin``, is given only where a stretch of sound without gaps begins; else it is None.
    """
    resampler, begin, due, layout = None, None, 0.0, None

    def mixed(out) -> np.ndarray:
        # Channels are averaged here because the resampler's own mix to mono can exceed full scale.
        return out.to_ndarray().mean(axis=0)

    for frame in frames:
        if frame is None:
            continue
        time = due if frame.time is None else frame.time - origin
        if resampler is not None and _clock_jumps(time - due):
            origin, time = origin + time - due, due
        if (
            resampler is None
            or abs(time - due) > MIN_SOUND_GAP
            or layout != (frame.format.name, frame.layout.name, frame.rate)
        ):
            if resampler is not None:
                yield from ((None, mixed(out)) for out in resampler.resample(None))
            resampler, begin = av.AudioResampler(format="fltp", layout=frame.layout, rate=rate), time
            due, layout = time, (frame.format.name, frame.layout.name, frame.rate)
            yield begin, np.zeros(0, np.float32)
        due += frame.samples / frame.rate
        yield from ((None, mixed(out)) for out in resampler.resample(frame))
    if resampler is not None:
        yield from ((None, mixed(out)) for out in resampler.resample(None))


def gapless_stretches(frames: Iterable, rate: int, origin: float) -> Iterator[tuple[float, np.ndarray]]:
    """(seconds from ``origin``, mono samples at ``rate`` Hz) of each stretch of sound without gaps."""
    begin, chunks = None, []
    for start, samples in audio_chunks(frames, rate, origin):
        if start is not None:
            if begin is not None:
                yield begin, np.concatenate(chunks)
            begin, chunks = start, []
        chunks.append(samples)
    if begin is not None:
        yield begin, np.concatenate(chunks)


def with_silence(stretches: Iterable[tuple[float, np.ndarray]], rate: int, length: int) -> np.ndarray | None:
    """Stretches of sound (start in seconds, samples) joined by silence, shape (samples,); None if there are none.

    Parameters
    ----------
    length : maximum number of samples; 0 for no limit
    """
    starts = [(round(begin * rate), samples) for begin, samples in stretches]
    if not starts:
        return None
    whole = max(0, max(start + len(samples) for start, samples in starts))
    result = np.zeros(min(whole, length) if length else whole, np.float32)
    for start, samples in starts:
        to = slice(max(start, 0), max(0, start + len(samples)))
        fitting = samples[max(0, -start) :][: max(0, len(result) - to.start)]
        result[to.start : to.start + len(fitting)] = fitting
    return finite(result)


def finite(samples: np.ndarray) -> np.ndarray:
    """Samples with NaN and infinity set to 0: damaged packets of floating-point codecs decode to any value."""
    return np.nan_to_num(samples, copy=False, nan=0.0, posinf=0.0, neginf=0.0)


def upright(array: np.ndarray, rotation: float) -> np.ndarray:
    """A frame (height, width, ...) as a player shows it: phones record sideways and store the rotation in degrees."""
    return np.rot90(array, round(rotation / 90) % 4)


def short_message(error: BaseException) -> str:
    """The reason of an error in a few words, without error number and path."""
    message = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return message.splitlines()[0]
