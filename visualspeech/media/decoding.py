"""Decoding by time: the frames and the sound of a recording or of a segment of it, whatever its container."""

import os
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
MAX_FRAME_RATE = 1000.0  # Hz; damaged headers state millions, and each frame up to the next time stamp is repeated
SAMPLE_RATES = (1000, 1_000_000)  # Hz; each second of a damaged header's few samples becomes a second of sound
MAX_PIXELS = 2**26  # of a frame, 8192 x 8192; a damaged header states more than memory holds

#: Containers that hold a recording themselves. Playlists, session descriptions and image sequences are left out: they
#: name other files and addresses, which FFmpeg would open.
CONTAINERS = frozenset(
    "aac,ac3,aiff,amr,ape,apng,asf,ast,au,av1,avi,caf,dirac,dsf,dts,dtshd,dv,eac3,flac,flv,gif,gxf,h261,h263,h264,hevc,"
    "g722,gsm,iff,ilbc,ircam,ivf,live_flv,loas,lxf,m4v,matroska,matroska,webm,mjpeg,mlp,mov,mp4,m4a,3gp,3g2,mj2,mp3,mpc,mpc8,mpeg,mpegts,"
    "mpegvideo,mpjpeg,mxf,nistsphere,nsv,nut,obu,ogg,oma,paf,pva,pvf,qcp,rm,rso,sbc,sds,sox,swf,tak,truehd,tta,ty,vc1,vc1test,vivo,voc,vvc,"
    "w64,wav,wsd,wtv,wv,yuv4mpegpipe".split(",")
)
#: FFmpeg takes the rest of the address literally after ``file:``, and opens no other protocol, whatever a file says.
LOCAL = {"protocol_whitelist": "file", "format_whitelist": ",".join(sorted(CONTAINERS))}


@contextmanager
def open_media(path: str | Path) -> Iterator:
    """An opened container; errors of opening and reading it become a :class:`RejectedUtterance`.

    Only the local file of this name is opened: no address, and no file that the file names. Text in it that is not
    UTF-8 is no error.
    """
    local = os.fspath(path)
    local = local if os.path.isabs(local) else os.path.join(os.getcwd(), local)
    try:
        # A pipe would block, and a device never ends.
        if not os.path.isfile(local):
            missing = "is no file" if os.path.exists(local) else "does not exist"
            raise RejectedUtterance(f"the file {missing}", "Correct its name, or bring the file back.")
        with _opened(local) as container:
            yield container
    except (av.FFmpegError, OSError) as error:
        empty = os.path.isfile(local) and os.path.getsize(local) == 0
        reason = "empty: 0 bytes" if empty else short_message(error)
        raise RejectedUtterance(f"unreadable media file ({reason})", UNREADABLE) from error


def _opened(path: str):
    """The container of a local file; see :func:`open_media`."""
    try:
        return av.open(f"file:{path}", container_options=LOCAL, metadata_errors="replace")
    except av.error.ArgumentError as error:
        reason = "it is no recording, or a list of other files, which are not opened"
        raise RejectedUtterance(f"unreadable media file ({reason})", UNREADABLE) from error


def video_stream(container):
    """The video stream of a container, ready to decode.

    Raises
    ------
    RejectedUtterance
        There is none, its codec is not known, or its frame rate or size is missing or absurd.
    """
    if not container.streams.video:
        raise RejectedUtterance("no video stream", "Give the recording's video file.")
    stream = container.streams.video[0]
    codec, rate = stream.codec_context, frame_rate(stream)
    if codec is None:
        raise RejectedUtterance("unknown video codec", UNREADABLE)
    if not rate:
        raise RejectedUtterance("no frame rate in the video file", UNREADABLE)
    if rate > MAX_FRAME_RATE:
        raise RejectedUtterance(f"the header states {rate:.4g} frames per second", UNREADABLE)
    if codec.width * codec.height > MAX_PIXELS:
        raise RejectedUtterance(f"frames of {codec.width} x {codec.height} pixels are too large", UNREADABLE)
    # With one decoding thread pixels and cost are the same on every machine.
    codec.thread_count = 1
    return stream


def audio_stream(container):
    """The audio stream of a container.

    Raises
    ------
    RejectedUtterance
        There is none, its codec is not known, or its sample rate is absurd.
    """
    if not container.streams.audio:
        raise RejectedUtterance("no audio stream", "Record with sound, or mux the sound into the video file.")
    stream = container.streams.audio[0]
    if stream.codec_context is None:
        raise RejectedUtterance("unknown audio codec", UNREADABLE)
    rate = stream.codec_context.sample_rate
    if rate and not _is_sample_rate(rate):  # some containers leave it to the decoder
        raise RejectedUtterance(f"the header states a sample rate of {rate} Hz", UNREADABLE)
    return stream


def _is_sample_rate(rate: int) -> bool:
    lowest, highest = SAMPLE_RATES
    return lowest <= rate <= highest


def frame_rate(stream) -> float:
    """Frames per second, the average if it varies; 0 if the container does not state it."""
    return float(stream.average_rate or stream.guessed_rate or 0)


def origin(container) -> float:
    """Time stamp of the first frame in seconds; of the first sound if there is no video."""
    for stream in (*container.streams.video[:1], *container.streams.audio[:1]):
        if stream.start_time is not None and stream.time_base:
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
    if first >= MIN_SEEK_TIME and stream.start_time is not None and stream.time_base:
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
        with np.errstate(all="ignore"):  # damaged packets of floating-point codecs decode to any value
            samples = out.to_ndarray()
            return samples.mean(axis=0) if out.format.is_planar else samples.reshape(-1, out.layout.nb_channels).mean(1)

    for frame in frames:
        if frame is None or not _is_sample_rate(frame.rate):
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
            # PyAV reads a plane too many of planar frames with eight channels, beyond the memory of the frame.
            order = "flt" if frame.layout.nb_channels >= 8 else "fltp"
            resampler, begin = av.AudioResampler(format=order, layout=frame.layout, rate=rate), time
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
