"""Video and sound files, through PyAV: frames in, sound in, MP4 out. No system ffmpeg is needed.

Time in a recording counts from its first picture; sound before it is left out. Every reader here sees a recording at
one constant frame rate, the stream's average: where the time stamps vary, a frame is what the screen shows at its
middle, ``(i + 0.5) / rate``, so a slow stretch repeats pictures and a fast one drops some. A damaged packet costs its
picture, not the recording: the last good one stays. So a recording has the same number of frames whenever it is read.
"""

import hashlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from itertools import takewhile
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.storage import replacing
from visualspeech.timing import frames_in

UNREADABLE = "Play the file in a media player; copy or convert it again (H.264 video and AAC sound in MP4 is safe)."
SOUND_GAP = 0.04  # seconds of missing sound from which on it is filled with silence instead of closed up
SEEK_FROM = 5.0  # seconds into a recording from which on seeking pays


@dataclass(frozen=True)
class MediaInfo:
    """What a container says of itself.

    Frame rate in Hz (the average where it varies), size in pixels, sound rate in Hz (0: no audio stream), duration in
    seconds and number of video frames (0: the header does not say).
    """

    rate: float
    width: int
    height: int
    audio_rate: int
    duration: float
    frames: int = 0


def probe(path: str | Path) -> MediaInfo:
    """Read the headers of a recording.

    Raises
    ------
    RejectedUtterance
        The file is missing, empty, no media file, has no video stream or no frame rate.
    """
    with _opened(path) as container:
        video = _video(container)
        audio = container.streams.audio[0] if container.streams.audio else None
        return MediaInfo(
            rate=_rate(video),
            width=video.codec_context.width,
            height=video.codec_context.height,
            audio_rate=(audio.rate or 0) if audio else 0,
            duration=float(container.duration or 0) / av.time_base,
            frames=video.frames or 0,
        )


def read_frames(path: str | Path, start: float = 0.0, end: float = 0.0) -> Iterator[np.ndarray]:
    """Yield the frames of a video as contiguous RGB arrays, (height, width, 3) uint8, one at a time.

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
    for frame in _at_constant_rate(path, start, end):
        # PyAV pads rows; detectors that take raw pointers read garbage unless the array is contiguous.
        yield np.ascontiguousarray(frame.to_ndarray(format="rgb24"))


def read_audio(path: str | Path, rate: int, start: float = 0.0, end: float = 0.0) -> np.ndarray:
    """The sound of a recording as mono float32 in [-1, 1] at ``rate`` Hz, shape (samples,).

    The sound begins with the first picture that :func:`read_frames` gives for the same ``start`` and ``end``. Sound
    that is missing inside the stream is silence.

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or nothing of it can be decoded.
    """
    with _opened(path) as container:
        if not container.streams.audio:
            raise RejectedUtterance("no audio stream", "Record with sound, or mux the sound into the video file.")
        audio = container.streams.audio[0]
        first, frames, video_rate = 0.0, 0, 0.0
        if container.streams.video:
            video_rate = _rate(container.streams.video[0])
            first, frames = _part(start, end, video_rate)
        origin = _origin(container) + first
        seconds = frames / video_rate if frames else np.inf
        wanted = takewhile(
            lambda frame: frame is None or frame.time is None or frame.time < origin + seconds,
            _decoded(container, audio, first),
        )
        samples = _laid_out(_pieces(wanted, rate, origin), rate, round(seconds * rate) if frames else 0)
    if samples is None:
        raise RejectedUtterance("unreadable audio stream (nothing in it can be decoded)", UNREADABLE)
    return samples


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
            if frame is None or frame.is_corrupt:
                damaged.append(time)
            if frame is not None:
                times.append(time)
                luma = _luma(frame)
                content.update(luma)
                small = luma[::4, ::4].astype(np.int16)
                if before is not None and before.shape == small.shape:
                    change = max(change, float(np.abs(small - before).mean()))
                before = small
            yield time, frame

    frames = sum(1 for _ in _at_constant_rate(path, start, end, looked_at))
    return VideoScan(np.array(times), np.array(damaged), frames, change, content.hexdigest()[:32])


def _luma(frame) -> np.ndarray:
    """Brightness of a picture, (height, width) uint8, without converting colours where the format allows."""
    if frame.format.name.startswith(("yuv", "nv12", "gray")) and frame.format.components[0].bits == 8:
        plane = frame.planes[0]
        if plane.line_size >= plane.width and "yuyv" not in frame.format.name:
            rows = np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)
            return np.ascontiguousarray(rows[: frame.height, : frame.width])
    return np.ascontiguousarray(frame.to_ndarray(format="gray"))


@contextmanager
def _opened(path):
    try:
        with av.open(str(path)) as container:
            yield container
    except FileNotFoundError as error:
        raise RejectedUtterance("the file does not exist", "Correct its name, or bring the file back.") from error
    except (av.FFmpegError, OSError) as error:
        empty = Path(path).is_file() and Path(path).stat().st_size == 0
        said = "empty: 0 bytes" if empty else _short(error)
        raise RejectedUtterance(f"unreadable video file ({said})", UNREADABLE) from error


def _video(container):
    if not container.streams.video:
        raise RejectedUtterance("no video stream", "Give the recording's video file.")
    stream = container.streams.video[0]
    if not _rate(stream):
        raise RejectedUtterance("no frame rate in the video file", UNREADABLE)
    # One decoding thread: the same pixels and the same cost whatever the machine.
    stream.codec_context.thread_count = 1
    return stream


def _rate(stream) -> float:
    return float(stream.average_rate or stream.guessed_rate or 0)


def _origin(container) -> float:
    """Time stamp of the first picture, in seconds; of the first sound where there is no picture."""
    for stream in (*container.streams.video[:1], *container.streams.audio[:1]):
        if stream.start_time is not None:
            return float(stream.start_time * stream.time_base)
    return 0.0


def _part(start: float, end: float, rate: float) -> tuple[float, int]:
    """First second, at a frame border, and number of frames (0: to the end) of a part of a recording.

    Borders keep the times of the frames away from the changes of picture, where rounding would decide.
    """
    first = np.floor(start * rate + 0.5) / rate
    return float(first), max(1, frames_in(end - first, rate)) if end else 0


def _decoded(container, stream, first: float) -> Iterator:
    """Frames of a stream from ``first`` seconds after its beginning, or a little before; None for a damaged packet."""
    if first >= SEEK_FROM and stream.start_time is not None:
        container.seek(stream.start_time + int((first - 1.0) / stream.time_base), stream=stream)
    try:
        for packet in container.demux(stream):
            try:
                yield from packet.decode()
            except (av.FFmpegError, OSError):
                yield None
    except (av.FFmpegError, OSError):  # the file ends in the middle of a packet
        yield None


def _at_constant_rate(path, start: float, end: float, looked_at=iter) -> Iterator:
    """The decoded picture of each frame of a part of a recording.

    ``looked_at`` sees (time, picture or None) of all that is decoded, and passes it on.
    """
    with _opened(path) as container:
        stream = _video(container)
        rate = _rate(stream)
        first, frames = _part(start, end, rate)
        pictures = _timed(_decoded(container, stream, first), rate, _origin(container))
        count = 0
        for picture in _held(looked_at(pictures), rate, first, frames):
            count += 1
            yield picture
    if not count:
        raise RejectedUtterance(
            "unreadable video stream (not one picture of this part can be decoded)",
            f"{UNREADABLE} Where the corpus gives start and end, check that they lie inside the recording.",
        )


def _timed(frames: Iterable, rate: float, origin: float) -> Iterator[tuple[float, object]]:
    """(seconds from the first picture, frame); a stamp that is missing or goes back is one frame after the last."""
    last = -1.0 / rate
    for frame in frames:
        time = last + 1.0 / rate
        if frame is not None:
            if frame.time is not None and frame.time - origin > last:
                time = frame.time - origin
            last = time
        yield time, frame


def _held(pictures: Iterable[tuple[float, object]], rate: float, first: float, frames: int) -> Iterator:
    """What a screen shows at ``first + (i + 0.5) / rate``: each picture until the next one comes."""
    index, shown, time_shown = 0, None, 0.0
    for time, picture in pictures:
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


def _pieces(frames: Iterable, rate: int, origin: float) -> Iterator[tuple[float, np.ndarray]]:
    """(seconds from ``origin``, mono samples at ``rate``) of each stretch of sound without a gap."""
    resampler, chunks, begin, due, kind = None, [], 0.0, 0.0, None
    for frame in frames:
        if frame is None:
            continue
        time = due if frame.time is None else frame.time - origin
        if (
            resampler is None
            or abs(time - due) > SOUND_GAP
            or kind != (frame.format.name, frame.layout.name, frame.rate)
        ):
            if resampler is not None:
                yield begin, _joined(chunks, resampler)
            # Channels are averaged here: the resampler's own mixing to mono can exceed full scale.
            resampler, chunks, begin = av.AudioResampler(format="fltp", layout=frame.layout, rate=rate), [], time
            due, kind = time, (frame.format.name, frame.layout.name, frame.rate)
        due += frame.samples / frame.rate
        chunks.extend(out.to_ndarray().mean(axis=0) for out in resampler.resample(frame))
    if resampler is not None:
        yield begin, _joined(chunks, resampler)


def _joined(chunks: list[np.ndarray], resampler) -> np.ndarray:
    last = [out.to_ndarray().mean(axis=0) for out in resampler.resample(None)]
    return np.concatenate([*chunks, *last]) if chunks or last else np.zeros(0, np.float32)


def _laid_out(pieces: Iterable[tuple[float, np.ndarray]], rate: int, length: int) -> np.ndarray | None:
    """All pieces at their places, silence between, cut to ``length`` samples where that is not 0; None without any."""
    placed = [(round(begin * rate), samples) for begin, samples in pieces]
    if not placed:
        return None
    whole = max(0, max(place + len(samples) for place, samples in placed))
    result = np.zeros(min(whole, length) if length else whole, np.float32)
    for place, samples in placed:
        to = slice(max(place, 0), max(0, place + len(samples)))
        part = samples[max(0, -place) :][: max(0, len(result) - to.start)]
        result[to.start : to.start + len(part)] = part
    return result


def write_video(
    path: str | Path,
    frames: Iterator[np.ndarray],
    rate: float,
    audio: np.ndarray | None = None,
    audio_rate: int = 48000,
    metadata: dict[str, str] | None = None,
) -> None:
    """Write RGB frames (height, width, 3) uint8, all of one even size, and mono float sound as H.264/AAC MP4.

    Frames are taken one at a time, so memory does not grow with the length. The bytes repeat from run to run.
    """
    rate = Fraction(rate).limit_denominator(100_000)
    with (
        replacing(Path(path)) as temporary,
        av.open(str(temporary), "w", options={"movflags": "+use_metadata_tags+faststart"}) as out,
    ):
        out.metadata.update(metadata or {})
        video = None
        sound = out.add_stream("aac", rate=audio_rate, layout="mono") if audio is not None else None
        for picture in frames:
            if video is None:
                video = out.add_stream("libx264", rate=rate, options={"crf": "18", "preset": "medium"})
                video.thread_count = 1
                video.height, video.width = picture.shape[:2]
                video.pix_fmt = "yuv420p"
            out.mux(video.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")))
        if video is not None:
            out.mux(video.encode(None))
        if sound is not None:
            out.mux(list(_encoded_sound(sound, np.asarray(audio, np.float32), audio_rate)))


def _encoded_sound(stream, samples: np.ndarray, rate: int):
    size = 1024
    for start in range(0, len(samples), size):
        frame = av.AudioFrame.from_ndarray(samples[None, start : start + size], format="fltp", layout="mono")
        frame.sample_rate = rate
        frame.pts = start
        yield from stream.encode(frame)
    yield from stream.encode(None)


def _short(error: BaseException) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
