"""Video and sound files, through PyAV: frames in, sound in, MP4 out. No system ffmpeg is needed."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.storage import replacing

UNREADABLE = "Play the file in a media player; copy or convert it again (H.264 video and AAC sound in MP4 is safe)."


@dataclass(frozen=True)
class MediaInfo:
    """What a container says of itself: frame rate in Hz, size in pixels, sound rate in Hz (0: no audio stream)."""

    rate: float
    width: int
    height: int
    audio_rate: int
    duration: float


def probe(path: str | Path) -> MediaInfo:
    """Read the headers of a recording.

    Raises
    ------
    RejectedUtterance
        The file is missing, empty, no media file, or has no video stream.
    """
    try:
        with av.open(str(path)) as container:
            if not container.streams.video:
                raise RejectedUtterance("no video stream", "Give the recording's video file.")
            video = container.streams.video[0]
            audio = container.streams.audio[0] if container.streams.audio else None
            rate = video.average_rate or video.guessed_rate or 0
            return MediaInfo(
                rate=float(rate),
                width=video.codec_context.width,
                height=video.codec_context.height,
                audio_rate=audio.rate if audio else 0,
                duration=float(container.duration or 0) / av.time_base,
            )
    except (av.FFmpegError, OSError) as error:
        raise RejectedUtterance(f"unreadable video file ({_short(error)})", UNREADABLE) from error


def read_frames(path: str | Path) -> Iterator[np.ndarray]:
    """Yield the frames of a video as contiguous RGB arrays, (height, width, 3) uint8, one at a time.

    Raises
    ------
    RejectedUtterance
        The stream cannot be decoded to its end.
    """
    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            # One decoding thread: the same pixels and the same cost whatever the machine.
            stream.codec_context.thread_count = 1
            for frame in container.decode(stream):
                # PyAV pads rows; detectors that take raw pointers read garbage unless the array is contiguous.
                yield np.ascontiguousarray(frame.to_ndarray(format="rgb24"))
    except (av.FFmpegError, OSError, IndexError) as error:
        raise RejectedUtterance(f"unreadable video stream ({_short(error)})", UNREADABLE) from error


def read_audio(path: str | Path, rate: int) -> np.ndarray:
    """The sound of a recording as mono float32 in [-1, 1] at ``rate`` Hz, shape (samples,).

    Raises
    ------
    RejectedUtterance
        There is no audio stream, or it cannot be decoded.
    """
    try:
        with av.open(str(path)) as container:
            if not container.streams.audio:
                raise RejectedUtterance("no audio stream", "Record with sound, or mux the sound into the video file.")
            resampler = av.AudioResampler(format="flt", layout="mono", rate=rate)
            chunks = [out.to_ndarray()[0] for frame in container.decode(audio=0) for out in resampler.resample(frame)]
            chunks += [out.to_ndarray()[0] for out in resampler.resample(None)]
    except (av.FFmpegError, OSError) as error:
        raise RejectedUtterance(f"unreadable audio stream ({_short(error)})", UNREADABLE) from error
    return np.concatenate(chunks).astype(np.float32) if chunks else np.zeros(0, np.float32)


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
    from fractions import Fraction

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
