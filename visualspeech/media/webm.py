"""Writing of WebM video files (VP9 and Opus) from frames and sound through PyAV."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import chain
from pathlib import Path

import av
import numpy as np

from visualspeech.errors import StorageError
from visualspeech.storage.files import replacing

OPUS_RATE = 48000  # Hz, the one rate at which every player decodes Opus
_OPUS_FRAME = 960  # samples
VIDEO, SOUND = "libvpx-vp9", "libopus"


def write_webm(
    path: str | Path,
    frames: Iterator[np.ndarray],
    rate: float,
    audio: Iterable[np.ndarray],
    audio_rate: int,
    metadata: dict[str, str] | None = None,
) -> None:
    """Write RGB frames and mono sound as a VP9/Opus WebM; the same input gives the same bytes.

    Frames and blocks of sound are consumed as the file needs them, so memory does not grow with the duration.

    Parameters
    ----------
    frames : (height, width, 3) uint8 RGB, all of one size, with even width and height
    rate : frame rate in Hz
    audio : consecutive blocks of float samples in [-1, 1]
    audio_rate : sample rate in Hz; the sound is resampled to :data:`OPUS_RATE`
    metadata : tags of the file

    Raises
    ------
    StorageError
        The file cannot be written, or PyAV was built without these codecs.
    """
    lacking = [name for name in (VIDEO, SOUND) if name not in av.codec.codecs_available]
    if lacking:
        raise StorageError(
            f"cannot write {path}: this installation of PyAV lacks {' and '.join(lacking)}. Install the wheel of PyAV "
            "(pip install --force-reinstall --only-binary av av), or write an MP4."
        )
    rate = Fraction(rate).limit_denominator(100_000)
    # Without the flag, the file gets random identifiers.
    with replacing(Path(path)) as temporary, av.open(str(temporary), "w", options={"fflags": "+bitexact"}) as out:
        out.metadata.update(metadata or {})
        video, sound = None, out.add_stream(SOUND, rate=OPUS_RATE, layout="mono")
        blocks = _resampled(audio, audio_rate)
        block = next(blocks, None)
        for number, frame in enumerate(frames, start=1):
            if video is None:
                options = {"crf": "24", "deadline": "good", "cpu-used": "5"}
                video = out.add_stream(VIDEO, rate=rate, options=options)
                video.bit_rate, video.thread_count, video.pix_fmt = 0, 1, "yuv420p"
                video.height, video.width = frame.shape[:2]
            out.mux(video.encode(av.VideoFrame.from_ndarray(np.ascontiguousarray(frame), format="rgb24")))
            while block is not None and block.pts < number / rate * OPUS_RATE:
                out.mux(sound.encode(block))
                block = next(blocks, None)
        if video is not None:
            out.mux(video.encode(None))
        while block is not None:
            out.mux(sound.encode(block))
            block = next(blocks, None)
        out.mux(sound.encode(None))


def _resampled(blocks: Iterable[np.ndarray], rate: int) -> Iterator[av.AudioFrame]:
    """Mono float sound in frames that the encoder takes."""
    resampler = av.AudioResampler(format="flt", layout="mono", rate=OPUS_RATE, frame_size=_OPUS_FRAME)
    position = done = 0
    for block in chain(blocks, [None]):
        given = None
        if block is not None:
            if not len(block):
                continue
            given = av.AudioFrame.from_ndarray(np.asarray(block, np.float32)[None], format="fltp", layout="mono")
            given.sample_rate, given.pts, given.time_base = rate, position, Fraction(1, rate)
            position += len(block)
        for frame in resampler.resample(given):
            frame.pts, frame.time_base = done, Fraction(1, OPUS_RATE)
            done += frame.samples
            yield frame
