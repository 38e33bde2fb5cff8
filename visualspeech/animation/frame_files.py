"""Files of a talking head: names of videos, sizes of frames, and numbered PNGs with the sound beside them."""

import wave
import zlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from visualspeech.errors import SettingError

#: Suffixes of videos, each a container.
SUFFIXES = (".mp4", ".mov", ".webm")
SOUND = "sound.wav"
MIN_SIDE, MAX_SIDE = 64, 4096  # pixels of a side of a video
_HEADER = 33  # bytes of a PNG before its second chunk


def check_video_name(path: Path, given: str) -> None:
    """Check that the name of a video ends in one of :data:`SUFFIXES`.

    Parameters
    ----------
    given : how the message names it

    Raises
    ------
    SettingError
        It does not.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise SettingError(
            f"{given}: videos are written as MP4, MOV or WebM; give a name that ends in {', '.join(SUFFIXES[:-1])} or "
            f"{SUFFIXES[-1]}."
        )


def check_sides(sides: Sequence[int], given: str) -> None:
    """Check the sides of a video in pixels; parameters and errors as of :func:`check_video_name`."""
    wrong = next((one for one in sides if not MIN_SIDE <= one <= MAX_SIDE), None)
    if wrong is not None:
        raise SettingError(f"{given}: {wrong} is not from {MIN_SIDE} to {MAX_SIDE} pixels.")
    odd = next((one for one in sides if one % 2), None)
    if odd is not None:
        raise SettingError(f"{given}: videos need even sizes; give {odd + 1} or {odd - 1} instead of {odd}.")


def scaled(frame: np.ndarray, size: tuple[int, int] | None) -> np.ndarray:
    """A frame (height, width, 3) uint8 as large as fits into a size (width, height) in pixels; None: as it is."""
    if size is None or frame.shape[1::-1] == tuple(size):
        return frame
    import cv2

    scale = min(size[0] / frame.shape[1], size[1] / frame.shape[0])
    inner = tuple(min(most, max(1, round(side * scale))) for side, most in zip(frame.shape[1::-1], size, strict=True))
    return cv2.resize(frame, inner, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_CUBIC)


def barred(frame: np.ndarray, size: tuple[int, int] | None) -> np.ndarray:
    """A scaled frame in the middle of a size, with black bars beside it; None: as it is."""
    if size is None or frame.shape[1::-1] == tuple(size):
        return frame
    height, width = frame.shape[:2]
    result = np.zeros((size[1], size[0], 3), np.uint8)
    left, top = (size[0] - width) // 2, (size[1] - height) // 2
    result[top : top + height, left : left + width] = frame
    return result


def size_of(size: tuple[int, int] | int | None, recorded: tuple[int, int]) -> tuple[int, int] | None:
    """The size (width, height) of a video: as given, or of a given height with the shape of the recordings."""
    if not isinstance(size, int):
        return size
    return max(2, 2 * round(recorded[0] * size / recorded[1] / 2)), size


def saved(frames: Iterable[np.ndarray], folder: Path, metadata: Mapping[str, str]) -> Iterator[np.ndarray]:
    """Yield the frames, (height, width, 3) uint8 RGB, and write each as ``000001.png`` and so on.

    Parameters
    ----------
    metadata : texts in every file
    """
    import cv2

    for number, frame in enumerate(frames, start=1):
        coded = cv2.imencode(".png", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))[1].tobytes()
        (folder / f"{number:06d}.png").write_bytes(with_texts(coded, metadata))
        yield frame


def with_texts(png: bytes, texts: Mapping[str, str]) -> bytes:
    """A PNG with texts (chunks iTXt of the PNG specification, UTF-8) before its pixels."""
    chunks = []
    for key, text in texts.items():
        data = b"iTXt" + key.encode("latin-1")[:79] + b"\0\0\0\0\0" + text.encode()
        chunks.append((len(data) - 4).to_bytes(4, "big") + data + zlib.crc32(data).to_bytes(4, "big"))
    return png[:_HEADER] + b"".join(chunks) + png[_HEADER:]


def save_sound(blocks: Iterable[np.ndarray], rate: int, path: Path) -> None:
    """Write mono float sound in [-1, 1], in blocks, as 16-bit WAV."""
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        for block in blocks:
            file.writeframes(np.clip(np.rint(block * 32768), -32768, 32767).astype("<i2").tobytes())
