import av
import numpy as np
import pytest

from visualspeech.errors import StorageError
from visualspeech.media import webm
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.media.webm import write_webm

RATE = 25.0


def frames(count=20):
    ys, xs = np.mgrid[:64, :96]
    for index in range(count):
        yield np.stack([(xs + 4 * index) % 256, ys * 3 % 256, np.full_like(xs, 90)], axis=2).astype(np.uint8)


def tone(seconds=0.8, rate=22050):
    return (0.4 * np.sin(2 * np.pi * 300 * np.arange(round(seconds * rate)) / rate)).astype(np.float32)


def blocks(sound, size=5000):
    return (sound[start : start + size] for start in range(0, len(sound), size))


def test_pictures_sound_and_tags_come_back(tmp_path):
    write_webm(tmp_path / "a.webm", frames(), RATE, blocks(tone()), 22050, {"synthetic": "yes", "title": "A title"})
    with av.open(str(tmp_path / "a.webm")) as file:
        names = {stream.codec_context.name.removeprefix("lib") for stream in file.streams}
        assert names in ({"vp9", "opus"}, {"vpx-vp9", "opus"})
        tags = {key.lower(): value for key, value in file.metadata.items()}
        assert tags["synthetic"] == "yes" and tags["title"] == "A title"
    seen = list(read_frames(tmp_path / "a.webm"))
    assert len(seen) == 20 and probe(tmp_path / "a.webm").rate == RATE
    error = np.abs(np.stack(seen).astype(float) - np.stack(list(frames())))
    assert error.mean() < 8  # chroma is halved


def test_sound_is_in_time(tmp_path):
    rate = 22050
    sound = np.zeros(round(0.8 * rate), np.float32)
    sound[round(0.4 * rate) :] = tone(0.4)
    write_webm(tmp_path / "a.webm", frames(), RATE, blocks(sound), rate)
    heard = read_audio(tmp_path / "a.webm", 16000)
    loud = np.flatnonzero(np.abs(heard) > 0.1)[0] / 16000
    assert abs(loud - 0.4) < 0.01 and abs(len(heard) / 16000 - 0.8) < 0.05


def test_the_same_input_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        write_webm(tmp_path / f"{name}.webm", frames(), RATE, blocks(tone(), 1000), 22050, {"title": "x"})
    assert (tmp_path / "a.webm").read_bytes() == (tmp_path / "b.webm").read_bytes()


def test_what_fails_leaves_nothing(tmp_path, monkeypatch):
    def broken():
        yield from frames(3)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        write_webm(tmp_path / "a.webm", broken(), RATE, blocks(tone()), 22050)
    monkeypatch.setattr(webm, "VIDEO", "libnothing")
    with pytest.raises(StorageError, match="this installation of PyAV lacks libnothing. Install the wheel of PyAV"):
        write_webm(tmp_path / "a.webm", frames(), RATE, blocks(tone()), 22050)
    assert not list(tmp_path.iterdir())
