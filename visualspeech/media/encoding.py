"""Video files, written through PyAV: frames and sound in, MP4 out. The bytes repeat from run to run."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path

import av
import numpy as np

from visualspeech.storage import replacing


def write_video(
    path: str | Path,
    frames: Iterator[np.ndarray],
    rate: float,
    audio: np.ndarray | Iterable[np.ndarray] | None = None,
    audio_rate: int = 48000,
    metadata: dict[str, str] | None = None,
    preset: str = "medium",
) -> None:
    """Write RGB frames (height, width, 3) uint8, all of one even size, and mono float sound as H.264/AAC MP4.

    Frames are taken one at a time, and sound given in pieces as the pictures need it: memory does not grow with the
    length, and a player finds both side by side in the file. The bytes repeat from run to run.
    ``preset`` is x264's: a faster one makes larger files of the same quality.
    """
    rate = Fraction(rate).limit_denominator(100_000)
    with (
        replacing(Path(path)) as temporary,
        av.open(str(temporary), "w", options={"movflags": "+use_metadata_tags+faststart"}) as out,
    ):
        out.metadata.update(metadata or {})
        video = None
        sound = out.add_stream("aac", rate=audio_rate, layout="mono") if audio is not None else None
        heard = _sound_frames([audio] if isinstance(audio, np.ndarray) else audio or (), audio_rate)
        due = next(heard, None)
        for number, picture in enumerate(frames, start=1):
            if video is None:
                # With its macroblock tree x264 reads memory it did not write at some widths: bytes do not repeat.
                options = {"crf": "18", "preset": preset, "x264-params": "no-mbtree=1"}
                video = out.add_stream("libx264", rate=rate, options=options)
                video.thread_count = 1
                video.height, video.width = picture.shape[:2]
                video.pix_fmt = "yuv420p"
            out.mux(video.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24")))
            while due is not None and due.pts < number / rate * audio_rate:
                out.mux(sound.encode(due))
                due = next(heard, None)
        if video is not None:
            out.mux(video.encode(None))
        while due is not None:
            out.mux(sound.encode(due))
            due = next(heard, None)
        if sound is not None:
            out.mux(sound.encode(None))


def _sound_frames(pieces: Iterable[np.ndarray], rate: int, size: int = 1024) -> Iterator[av.AudioFrame]:
    """Mono float sound in frames of ``size`` samples, as AAC takes them."""
    start, left = 0, np.zeros(0, np.float32)
    for last, piece in chain(((False, piece) for piece in pieces), [(True, left)]):
        left = np.concatenate([left, np.asarray(piece, np.float32)])
        while len(left) >= size or (last and len(left)):
            frame = av.AudioFrame.from_ndarray(left[None, :size].copy(), format="fltp", layout="mono")
            frame.sample_rate, frame.pts = rate, start
            yield frame
            start, left = start + size, left[size:]
