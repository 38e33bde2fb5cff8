"""Writing of MP4 video files from frames and sound through PyAV."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path

import av
import numpy as np

from visualspeech.storage.files import replacing


def write_video(
    path: str | Path,
    frames: Iterator[np.ndarray],
    rate: float,
    audio: np.ndarray | Iterable[np.ndarray] | None = None,
    audio_rate: int = 48000,
    metadata: dict[str, str] | None = None,
    preset: str = "medium",
) -> None:
    """Write RGB frames and mono sound as an H.264/AAC MP4; the same input gives the same bytes.

    Frames and blocks of sound are consumed as the file needs them, so memory does not grow with the duration, and both
    are interleaved in the file.

    Parameters
    ----------
    frames : (height, width, 3) uint8 RGB, all of one size, with even width and height
    rate : frame rate in Hz
    audio : float samples (n,) in [-1, 1], or consecutive blocks of them; None for a video without sound
    audio_rate : sample rate in Hz
    metadata : tags of the file
    preset : of x264; a faster one makes larger files of the same quality

    Raises
    ------
    StorageError
        The file cannot be written.
    """
    rate = Fraction(rate).limit_denominator(100_000)
    with (
        replacing(Path(path)) as temporary,
        av.open(str(temporary), "w", options={"movflags": "+use_metadata_tags+faststart"}) as out,
    ):
        out.metadata.update(metadata or {})
        video = None
        sound = out.add_stream("aac", rate=audio_rate, layout="mono") if audio is not None else None
        audio_frames = _audio_frames([audio] if isinstance(audio, np.ndarray) else audio or (), audio_rate)
        audio_frame = next(audio_frames, None)
        for number, frame in enumerate(frames, start=1):
            if video is None:
                # With its macroblock tree, x264 reads uninitialised memory at some widths, and the bytes vary.
                options = {"crf": "18", "preset": preset, "x264-params": "no-mbtree=1"}
                video = out.add_stream("libx264", rate=rate, options=options)
                video.thread_count = 1
                video.height, video.width = frame.shape[:2]
                video.pix_fmt = "yuv420p"
            out.mux(video.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")))
            while audio_frame is not None and audio_frame.pts < number / rate * audio_rate:
                out.mux(sound.encode(audio_frame))
                audio_frame = next(audio_frames, None)
        if video is not None:
            out.mux(video.encode(None))
        while audio_frame is not None:
            out.mux(sound.encode(audio_frame))
            audio_frame = next(audio_frames, None)
        if sound is not None:
            out.mux(sound.encode(None))


def _audio_frames(blocks: Iterable[np.ndarray], rate: int, size: int = 1024) -> Iterator[av.AudioFrame]:
    """Mono float sound in frames of ``size`` samples, the frame size of AAC."""
    start, left = 0, np.zeros(0, np.float32)
    for last, block in chain(((False, block) for block in blocks), [(True, left)]):
        left = np.concatenate([left, np.asarray(block, np.float32)])
        while len(left) >= size or (last and len(left)):
            frame = av.AudioFrame.from_ndarray(left[None, :size].copy(), format="fltp", layout="mono")
            frame.sample_rate, frame.pts = rate, start
            yield frame
            start, left = start + size, left[size:]
