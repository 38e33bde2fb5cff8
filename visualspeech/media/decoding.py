"""Decoding by time: the pictures and the sound of a recording, or of a part of it, whatever its container does."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.timing import frames_in

UNREADABLE = "Play the file in a media player; copy or convert it again (H.264 video and AAC sound in MP4 is safe)."
SOUND_GAP = 0.04  # seconds of missing sound from which on it is filled with silence instead of closed up
SEEK_FROM = 20.0  # seconds into a recording from which on seeking pays
LONGEST_GAP = 10.0  # seconds; a time stamp further ahead is taken for an error
BEFORE = 12.0  # seconds to land before the part: containers without an index need a key frame in between


@contextmanager
def opened(path: str | Path) -> Iterator:
    """A container, with every error of opening and reading it as a :class:`RejectedUtterance`."""
    try:
        with av.open(str(path)) as container:
            yield container
    except FileNotFoundError as error:
        raise RejectedUtterance("the file does not exist", "Correct its name, or bring the file back.") from error
    except (av.FFmpegError, OSError) as error:
        empty = Path(path).is_file() and Path(path).stat().st_size == 0
        said = "empty: 0 bytes" if empty else short(error)
        raise RejectedUtterance(f"unreadable media file ({said})", UNREADABLE) from error


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
    # One decoding thread: the same pixels and the same cost whatever the machine.
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
    """Pictures per second, on average where it varies; 0 where the container does not say."""
    return float(stream.average_rate or stream.guessed_rate or 0)


def origin(container) -> float:
    """Time stamp of the first picture, in seconds; of the first sound where there is no picture."""
    for stream in (*container.streams.video[:1], *container.streams.audio[:1]):
        if stream.start_time is not None:
            return float(stream.start_time * stream.time_base)
    return 0.0


def part(start: float, end: float, rate: float) -> tuple[float, int]:
    """First second, at a frame border, and number of frames (0: to the end) of a part of a recording.

    Borders keep the times of the frames away from the changes of picture, where rounding would decide.
    """
    first = np.floor(start * rate + 0.5) / rate
    return float(first), max(1, frames_in(end - first, rate)) if end else 0


def decoded(container, stream, first: float) -> Iterator:
    """Frames of a stream from ``first`` seconds after its beginning, or a little before; None for a damaged packet."""
    if first >= SEEK_FROM and stream.start_time is not None:
        with suppress(av.FFmpegError, OSError):  # what cannot be sought is decoded from its beginning
            container.seek(stream.start_time + int((first - BEFORE) / stream.time_base), stream=stream)
    try:
        for packet in container.demux(stream):
            try:
                yield from packet.decode()
            except (av.FFmpegError, OSError):
                yield None
    except (av.FFmpegError, OSError):  # the file ends in the middle of a packet
        yield None


def pictures(path, start: float, end: float, looked_at=iter) -> Iterator:
    """The decoded picture of each frame of a part of a recording.

    ``looked_at`` sees (time, picture or None) of all that is decoded, and passes it on.
    """
    with opened(path) as container:
        stream = video_stream(container)
        rate = frame_rate(stream)
        first, frames = part(start, end, rate)
        timed = _timed(decoded(container, stream, first), rate, origin(container))
        count = 0
        for picture in _held(looked_at(timed), rate, first, frames):
            count += 1
            yield picture
    if not count:
        raise RejectedUtterance(
            "unreadable video stream (not one picture of this part can be decoded)",
            f"{UNREADABLE} Where the corpus gives start and end, check that they lie inside the recording.",
        )


def _timed(frames: Iterable, rate: float, origin: float) -> Iterator[tuple[float, object]]:
    """(seconds from the first picture, frame), ascending; None for a frame whose size is not that of the first.

    A stamp that is missing or not after the last is taken for one frame later; where the clock leaps, it is set right.
    """
    last, size = None, None
    for frame in frames:
        due = 0.0 if last is None else last + 1.0 / rate
        if frame is None:
            yield due, None
            continue
        stamp = due + origin if frame.time is None else frame.time
        if last is not None and _leaps(stamp - origin - due):
            origin = stamp - due
        time = stamp - origin
        last = due if last is not None and time <= last else time
        size = size or (frame.width, frame.height)
        yield last, frame if (frame.width, frame.height) == size else None


def _leaps(seconds: float) -> bool:
    """Whether a clock that is off by so much was set anew, as where recordings were joined or bytes are damaged."""
    return not -1.0 < seconds < LONGEST_GAP


def _held(timed: Iterable[tuple[float, object]], rate: float, first: float, frames: int) -> Iterator:
    """What a screen shows at ``first + (i + 0.5) / rate``: each picture until the next one comes."""
    index, shown, time_shown = 0, None, 0.0
    for time, picture in timed:
        if picture is None:
            continue
        while shown is not None and first + (index + 0.5) / rate < time:
            yield shown
            index += 1
            if index == frames:
                return
        shown, time_shown = picture, time
    while shown is not None and first + (index + 0.5) / rate < time_shown + 1.0 / rate:
        yield shown
        index += 1
        if index == frames:
            return


def sound_chunks(frames: Iterable, rate: int, origin: float) -> Iterator[tuple[float | None, np.ndarray]]:
    """Mono samples at ``rate``, frame by frame; with the seconds from ``origin`` where a gapless stretch begins."""
    resampler, begin, due, kind = None, None, 0.0, None

    def mixed(out) -> np.ndarray:
        # Channels are averaged here: the resampler's own mixing to mono can exceed full scale.
        return out.to_ndarray().mean(axis=0)

    for frame in frames:
        if frame is None:
            continue
        time = due if frame.time is None else frame.time - origin
        if resampler is not None and _leaps(time - due):
            origin, time = origin + time - due, due
        if (
            resampler is None
            or abs(time - due) > SOUND_GAP
            or kind != (frame.format.name, frame.layout.name, frame.rate)
        ):
            if resampler is not None:
                yield from ((None, mixed(out)) for out in resampler.resample(None))
            resampler, begin = av.AudioResampler(format="fltp", layout=frame.layout, rate=rate), time
            due, kind = time, (frame.format.name, frame.layout.name, frame.rate)
            yield begin, np.zeros(0, np.float32)
        due += frame.samples / frame.rate
        yield from ((None, mixed(out)) for out in resampler.resample(frame))
    if resampler is not None:
        yield from ((None, mixed(out)) for out in resampler.resample(None))


def sound_pieces(frames: Iterable, rate: int, origin: float) -> Iterator[tuple[float, np.ndarray]]:
    """(seconds from ``origin``, mono samples at ``rate``) of each stretch of sound without a gap."""
    begin, chunks = None, []
    for start, samples in sound_chunks(frames, rate, origin):
        if start is not None:
            if begin is not None:
                yield begin, np.concatenate(chunks)
            begin, chunks = start, []
        chunks.append(samples)
    if begin is not None:
        yield begin, np.concatenate(chunks)


def laid_out(pieces: Iterable[tuple[float, np.ndarray]], rate: int, length: int) -> np.ndarray | None:
    """All pieces at their places, silence between, cut to ``length`` samples where that is not 0; None without any."""
    placed = [(round(begin * rate), samples) for begin, samples in pieces]
    if not placed:
        return None
    whole = max(0, max(place + len(samples) for place, samples in placed))
    result = np.zeros(min(whole, length) if length else whole, np.float32)
    for place, samples in placed:
        to = slice(max(place, 0), max(0, place + len(samples)))
        fitting = samples[max(0, -place) :][: max(0, len(result) - to.start)]
        result[to.start : to.start + len(fitting)] = fitting
    return finite(result)


def finite(samples: np.ndarray) -> np.ndarray:
    """Samples without infinity: damaged packets of floating-point codecs may decode to anything."""
    return np.nan_to_num(samples, copy=False, nan=0.0, posinf=0.0, neginf=0.0)


def upright(array: np.ndarray, rotation: float) -> np.ndarray:
    """A picture (height, width, ...) as a player shows it: phones record lying and note the turn in degrees."""
    return np.rot90(array, round(rotation / 90) % 4)


def short(error: BaseException) -> str:
    """An error in a few words, without numbers and paths."""
    said = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return said.splitlines()[0]
