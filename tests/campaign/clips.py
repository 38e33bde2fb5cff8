"""Recordings that a camera, a download or an enemy might give: hostile variants of a good recording."""

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import av
import numpy as np

from tests import synthetic
from visualspeech.media.reading import read_audio, read_frames

_CODECS = (
    ("mp4", "libx264", "aac"), ("mkv", "libx264", "pcm_f32le"), ("avi", "mpeg4", "mp2"), ("mpg", "mpeg1video", "mp2"),
    ("webm", "libvpx", "libopus"), ("mov", "mjpeg", "pcm_s16le"), ("ts", "mpeg2video", "aac"), ("mkv", "ffv1", "flac"),
)  # fmt: skip
_TEXTS = (
    "#EXTM3U\n#EXT-X-TARGETDURATION:2\n#EXTINF:2,\nhttp://127.0.0.1:9/a.ts\n#EXT-X-ENDLIST\n",
    "ffconcat version 1.0\nfile /etc/passwd\n",
    "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 9 RTP/AVP 96\n",
    "<html><body>404</body></html>",
    "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "",
    "x",
)


def clip(number: int, source: Path, folder: Path, rng: random.Random) -> tuple[Path, str]:
    """Write a hostile recording with a transcript beside it; returns its path and what it is."""
    make = rng.choices(list(_KINDS), weights=list(_KINDS.values()))[0]
    path, what = make(folder / f"clip{number:05d}", source, rng)
    transcript, how = _transcript(source.with_suffix(".txt").read_text(), rng)
    if transcript is not None:
        path.with_suffix(".txt").write_bytes(transcript)
    return path, f"{what}; {how}"


def _flipped(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    data = bytearray(source.read_bytes())
    # The header decides most, and is a small part of the file.
    end = rng.choice([64, 4000, len(data)])
    count = rng.choice([1, 3, 30, 1000])
    for _ in range(count):
        data[rng.randrange(min(end, len(data)))] = rng.randrange(256)
    return _written(stem.with_suffix(".mp4"), data), f"{count} bytes changed in the first {end}"


def _cut(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    data = source.read_bytes()
    first, last = sorted(rng.sample(range(len(data)), 2))
    if rng.random() < 0.5:
        return _written(stem.with_suffix(".mp4"), data[:last]), f"ends after {last} of {len(data)} bytes"
    middle = b"" if rng.random() < 0.5 else bytes(last - first)
    return _written(stem.with_suffix(".mp4"), data[:first] + middle + data[last:]), f"bytes {first}-{last} are lost"


def _tagged(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    data = source.read_bytes()
    tags = [tag for tag in (b"avc1", b"mp4a", b"avcC", b"esds", b"moov", b"stts", b"mdhd", b"hdlr") if tag in data]
    tag, other = rng.choice(tags), rng.choice([b"zzzz", b"hev1", b"av01", b"Opus", bytes(4), b"free"])
    return _written(stem.with_suffix(".mp4"), data.replace(tag, other)), f"{tag.decode()} became {other!r}"


def _named(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    data = source.read_bytes()
    word = b"Synthetic"
    foreign = bytes(rng.choice(b"\xe9\xff\xc3\x80\xa0") for _ in word)
    return _written(stem.with_suffix(".mp4"), data.replace(word, foreign)), "a tag that is not UTF-8"


def _foreign(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    suffix = rng.choice([".mp4", ".mpg", ".mkv", ".avi"])
    if rng.random() < 0.2:
        size = rng.choice([100, 100_000])
        return _written(stem.with_suffix(suffix), rng.randbytes(size)), f"{size} random bytes"
    text = rng.choice(_TEXTS)
    return _written(stem.with_suffix(suffix), text.encode()), f"a text in place of a video: {text[:20]!r}"


def _linked(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    target = rng.choice(["/dev/zero", "/nowhere", str(stem.with_suffix(".mp4")), "/etc/hostname"])
    path = stem.with_suffix(".mp4")
    path.symlink_to(target)
    return path, f"a link to {target if target[1:4] in ('dev', 'now', 'etc') else 'itself'}"


def _recoded(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    suffix, video, audio = rng.choice(_CODECS)
    rate = rng.choice([25, 24, 30, 50]) if suffix != "mpg" else 25
    audio_rate = 48_000 if audio in ("libopus", "mp2") else rng.choice([8000, 16_000, 44_100])
    sound, what = _sound(source, audio_rate, rng)
    frames, shown = _frames(source, rng)
    path = stem.with_suffix(f".{suffix}")
    try:
        synthetic.record(
            path, rate=rate, frames=frames, audio=sound, audio_rate=audio_rate, codecs=(video, audio),
            late=rng.choice([0, 0, 0.5]), rotation=rng.choice([0, 0, 90]) if suffix == "mov" else 0,
        )  # fmt: skip
    except (av.FFmpegError, OSError, ValueError) as error:  # this encoder does not take these frames or this sound
        return _written(path, b""), f"could not be written ({type(error).__name__})"
    return path, f"{suffix} of {video} and {audio}, {shown} at {rate} Hz, {what} at {audio_rate} Hz"


def _sound(source: Path, rate: int, rng: random.Random) -> tuple[np.ndarray, str]:
    speech = read_audio(source, rate)
    kinds: dict[str, Callable[[], np.ndarray]] = {
        "its sound": lambda: speech,
        "no sound": lambda: speech[:0],
        "silence": lambda: np.zeros_like(speech),
        "noise": lambda: np.random.default_rng(rng.randrange(99)).normal(0, 0.2, len(speech)).astype(np.float32),
        "not-a-number sound": lambda: np.full_like(speech, np.nan),
        "loud sound": lambda: np.clip(speech * 1e6, -1, 1),
        "half its sound": lambda: speech[: len(speech) // 2],
        "a tone": lambda: np.sin(np.arange(len(speech)) / 7).astype(np.float32) * 0.3,
    }
    what = rng.choice(list(kinds))
    return kinds[what](), what


def _frames(source: Path, rng: random.Random) -> tuple[list[np.ndarray], str]:
    if rng.random() < 0.3:
        return list(read_frames(source)), "its frames"
    count, height, width = rng.choice([1, 2, 40]), rng.choice([16, 64, 200]), rng.choice([16, 96, 130])
    if rng.random() < 0.3:
        return [np.full((height, width, 3), 90, np.uint8)] * count, f"{count} grey frames of {width}x{height}"
    return synthetic.pictures(count, height, width), f"{count} frames of {width}x{height} without a face"


def _copied(stem: Path, source: Path, rng: random.Random) -> tuple[Path, str]:
    # One byte more at the end makes another file of the same content, which is a duplicate.
    return _written(stem.with_suffix(".mp4"), source.read_bytes() + b"\0"), "the good recording again"


_KINDS = {_flipped: 6, _cut: 3, _tagged: 3, _named: 1, _foreign: 3, _linked: 1, _recoded: 6, _copied: 1}


def _transcript(good: str, rng: random.Random) -> tuple[bytes | None, str]:
    choices: list[tuple[bytes | None, str]] = [
        (b"", "an empty transcript"),
        (None, "no transcript"),
        (b"\xff\xfe" + good.encode("utf-16-le"), "transcript in UTF-16"),
        (good.encode() + " caf\xe9".encode("cp1252"), "transcript in Windows-1252"),
        (rng.randbytes(200), "200 random bytes as transcript"),
        (("word " * 3000).encode(), "a transcript of 3,000 words"),
        (b"a" * 5000, "a transcript of one word of 5,000 letters"),
        ("\u4f60\u597d \u0661\u0662 \U0001f600".encode(), "a transcript in other scripts"),
        (good.encode().replace(b" ", b"\0\x0b"), "control characters in the transcript"),
        (b"two and two are five said she", "another transcript"),
    ]
    return rng.choice(choices) if rng.random() < 0.35 else (good.encode(), "its transcript")


def _written(path: Path, data: bytes | bytearray) -> Path:
    path.write_bytes(bytes(data))
    return path


def described(clips: Iterator[tuple[Path, str]]) -> dict[str, tuple[Path, str]]:
    """Clips by the name of their file without suffix."""
    return {path.stem: (path, what) for path, what in clips}
