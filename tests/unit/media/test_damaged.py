"""Damaged and hostile media files: a reason in words, and no other file or address is opened."""

import os
import shutil
import socket
import subprocess
import sys
from contextlib import contextmanager

import numpy as np
import pytest

from tests import synthetic
from visualspeech.corpora.check import check_recording
from visualspeech.corpora.check_settings import CheckSettings
from visualspeech.corpora.records import Utterance
from visualspeech.errors import RejectedUtterance
from visualspeech.media import decoding, reading

READERS = {
    "probe": reading.probe,
    "scan": reading.scan_video,
    "frames": lambda path: list(reading.read_frames(path)),
    "audio": lambda path: reading.read_audio(path, 16_000),
    "stream": lambda path: list(reading.stream_audio(path, 16_000)),
}


def small(path, seconds=0.6, **arguments):
    return synthetic.record(path, seconds, frames=synthetic.pictures(round(seconds * 25), 32, 48), **arguments)


def checked(path):
    utterance = Utterance("u1", "s", str(path), "hello there")
    return check_recording(utterance, lambda text: [], CheckSettings())


def replaced(path, old, new, last=False):
    data = path.read_bytes()
    at = data.rfind(old) if last else data.find(old, 200)
    path.write_bytes(data[:at] + new + data[at + len(old) :])
    return path


@pytest.mark.parametrize("suffix", ["mp4", "mkv"])
def test_a_tag_that_is_not_utf8_is_no_error(tmp_path, suffix):
    path = small(tmp_path / f"a.{suffix}", tag="AndrX")
    replaced(path, b"AndrX", b"Andr\xe9", last=True)
    assert b"Andr\xe9" in path.read_bytes()
    for read in READERS.values():
        read(path)


def test_an_unknown_video_codec_is_a_reason(tmp_path):
    path = replaced(small(tmp_path / "a.mp4"), b"avc1", b"zzzz", last=True)
    for name in ("probe", "scan", "frames"):
        with pytest.raises(RejectedUtterance, match="unknown video codec") as error:
            READERS[name](path)
        assert error.value.remedy
    assert checked(path).rejected.reason == "unknown video codec"


def test_an_unknown_audio_codec_is_a_reason(tmp_path):
    path = replaced(small(tmp_path / "a.mkv"), b"A_AAC", b"A_ZZZ")
    assert reading.probe(path).audio_rate == 0
    for name in ("audio", "stream"):
        with pytest.raises(RejectedUtterance, match="unknown audio codec"):
            READERS[name](path)


@pytest.mark.parametrize("rate", [1, 2**31 - 1])
def test_absurd_sample_rates_are_rejected(tmp_path, rate):
    import soundfile

    path = tmp_path / "a.wav"
    soundfile.write(path, np.zeros(16_000), 16_000)
    data = bytearray(path.read_bytes())
    data[24:28] = rate.to_bytes(4, "little")
    path.write_bytes(data)
    with pytest.raises(RejectedUtterance, match="sample rate|unreadable"):
        reading.read_audio(path, 16_000)


def test_absurd_frame_rates_and_sizes_are_rejected(tmp_path, monkeypatch):
    path = small(tmp_path / "a.mp4")
    monkeypatch.setattr(decoding, "MAX_FRAME_RATE", 24.0)
    with pytest.raises(RejectedUtterance, match="states 25 frames per second"):
        reading.probe(path)
    monkeypatch.setattr(decoding, "MAX_FRAME_RATE", 1000.0)
    monkeypatch.setattr(decoding, "MAX_PIXELS", 32 * 48 - 1)
    with pytest.raises(RejectedUtterance, match="48 x 32 pixels"):
        reading.probe(path)


def test_sound_that_is_not_a_number_is_silence(tmp_path):
    import soundfile

    sound = synthetic.hum(0.6)
    sound[2000:3000], sound[4000:5000] = np.nan, np.inf
    soundfile.write(tmp_path / "a.wav", sound, 16_000, subtype="FLOAT")
    assert np.isfinite(reading.read_audio(tmp_path / "a.wav", 16_000)).all()


def test_sound_of_eight_channels_is_averaged(tmp_path):
    """In a process of its own: reading beyond the memory of a frame ends the process, not only the test."""
    import av

    path, channels = tmp_path / "a.mkv", np.linspace(0.1, 0.8, 8)
    with av.open(str(path), "w") as out:
        stream = out.add_stream("pcm_s16le", rate=16_000, layout="7.1")
        sound = np.tile(np.round(channels * 32767).astype(np.int16), 9600)
        for start in range(0, 9600, 960):
            frame = av.AudioFrame.from_ndarray(sound[None, start * 8 : (start + 960) * 8], format="s16", layout="7.1")
            frame.sample_rate, frame.pts = 16_000, start
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    script = f"from visualspeech.media.reading import read_audio; print(read_audio({str(path)!r}, 16000).mean())"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert float(done.stdout) == pytest.approx(channels.mean(), abs=1e-3)


PLAYLISTS = {
    "concat": "ffconcat version 1.0\nfile other.mp4\n",
    "hls": "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{address}\n#EXT-X-ENDLIST\n",
    "hls of a file": "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nother.mp4\n#EXT-X-ENDLIST\n",
    "sdp": "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nt=0 0\nm=video 5004 RTP/AVP 96\n"
    "a=rtpmap:96 H264/90000\n",
}


@contextmanager
def server_that_nobody_calls():
    """The port of a server; fails where the block opened a connection to it."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield server.getsockname()[1]
        server.settimeout(0.05)
        with pytest.raises(TimeoutError):
            server.accept()


@pytest.mark.parametrize("suffix", ["mp4", "m3u8", "sdp"])
@pytest.mark.parametrize("kind", PLAYLISTS)
def test_lists_of_other_files_open_none_of_them(tmp_path, kind, suffix):
    small(tmp_path / "other.mp4")
    path = tmp_path / f"list.{suffix}"
    with server_that_nobody_calls() as port:
        path.write_text(PLAYLISTS[kind].format(address=f"http://127.0.0.1:{port}/a.mp4"))
        for read in READERS.values():
            with pytest.raises(RejectedUtterance, match="unreadable media file"):
                read(path)


@pytest.mark.parametrize(
    "scheme", ["http://127.0.0.1:{port}/a.mp4", "concat:{file}", "subfile,,start,0,end,0,,:{file}"]
)
def test_addresses_are_names_of_files(tmp_path, monkeypatch, scheme):
    monkeypatch.chdir(tmp_path)
    small(tmp_path / "a.mp4")
    with server_that_nobody_calls() as port:
        name = scheme.format(port=port, file="a.mp4")
        for read in READERS.values():
            with pytest.raises(RejectedUtterance, match="does not exist"):
                read(name)


@pytest.mark.parametrize(
    "name", ["%03d.mp4", "a b.mp4", "file:x.mp4", "é中.mp4", "caf\udce9.mp4", "-i.mp4", "{x}.mp4", "a#b?c.mp4"]
)
def test_odd_names_are_opened(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    source = small(tmp_path / "source.mkv")
    shutil.copy(source, tmp_path / name)
    for path in (name, tmp_path / name):
        assert reading.scan_video(path).frames == 15


def test_what_is_no_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.mp4")
    for path in (tmp_path / "pipe.mp4", tmp_path, "/dev/zero"):
        with pytest.raises(RejectedUtterance, match="is no file"):
            reading.probe(path)


@pytest.mark.parametrize(("name", "codecs"), [("a.mkv", ("libx264", "aac")), ("a.avi", ("mpeg4", "mp2"))])
def test_a_damaged_last_frame_is_no_truncation(tmp_path, name, codecs):
    import av

    path = synthetic.record(tmp_path / name, 2.0, codecs=codecs, audio_rate=48000)
    with av.open(str(path)) as container:
        last = max((packet for packet in container.demux(video=0) if packet.size), key=lambda packet: packet.pos)
    data = bytearray(path.read_bytes())
    data[last.pos + 8 : last.pos + last.size] = b"\xff" * (last.size - 8)
    path.write_bytes(data)
    found = checked(path)
    assert found.rejected is None, found.rejected
    assert any("damaged frame" in finding.finding for finding in found.findings), found.findings


@pytest.mark.parametrize("suffix", ["mp4", "mkv", "avi", "mpg"])
def test_flipped_bytes_are_read_or_rejected(tmp_path, suffix):
    codecs = {"avi": ("mpeg4", "mp2"), "mpg": ("mpeg1video", "mp2")}.get(suffix, ("libx264", "aac"))
    source = small(tmp_path / f"a.{suffix}", 0.4, codecs=codecs, audio_rate=48000)
    random, data = np.random.default_rng(5), source.read_bytes()
    for _ in range(12):
        damaged = bytearray(data)
        for at in random.integers(0, len(data), 20):
            damaged[at] = random.integers(256)
        (tmp_path / f"b.{suffix}").write_bytes(damaged)
        for read in READERS.values():
            try:
                read(tmp_path / f"b.{suffix}")
            except RejectedUtterance as error:
                assert error.reason and error.remedy
