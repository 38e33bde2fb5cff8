"""Recordings of every kind are read at one constant rate, parts agree with the whole, and damage costs little."""

import av
import numpy as np
import pytest

from tests import synthetic
from visualspeech.errors import RejectedUtterance
from visualspeech.media import decoding, encoding, reading


def decoded(path):
    """The pictures as the decoder gives them, without this project's reading."""
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return synthetic.record(tmp_path_factory.mktemp("media") / "whole.mp4", 2.0)


@pytest.mark.parametrize(
    ("name", "codecs", "audio_rate"),
    [
        ("a.mp4", ("libx264", "aac"), 16000),
        ("a.mkv", ("libx264", "aac"), 44100),
        ("a.avi", ("mpeg4", "mp2"), 48000),
        ("a.mpg", ("mpeg1video", "mp2"), 44100),
        ("a.ts", ("libx264", "aac"), 48000),
        ("a.webm", ("libvpx", "libopus"), 48000),
    ],
)
def test_containers_give_all_frames_and_sound_in_time(tmp_path, name, codecs, audio_rate):
    """A click in the fifth of ten frames is heard there, whatever the container adds in front."""
    sound = np.zeros(audio_rate, np.float32)
    click = slice(int(0.5 * audio_rate), int(0.52 * audio_rate))
    sound[click] = 0.8 * np.sin(2 * np.pi * 1000 * np.arange(click.stop - click.start) / audio_rate)
    path = synthetic.record(tmp_path / name, 1.0, codecs=codecs, audio=sound, audio_rate=audio_rate)
    info = reading.probe(path)
    assert (info.rate, info.width, info.height, info.audio_rate) == (25.0, 128, 96, audio_rate)
    frames = list(reading.read_frames(path))
    assert len(frames) == 25 and all(frame.flags.c_contiguous for frame in frames)
    np.testing.assert_array_equal(frames, decoded(path))
    heard = reading.read_audio(path, 16000)
    assert heard.dtype == np.float32 and 0.9 < len(heard) / 16000 < 1.15
    centre = np.average(np.arange(len(heard)), weights=heard.astype(float) ** 2) / 16000
    assert centre == pytest.approx(0.51, abs=0.03)


@pytest.mark.parametrize(("start", "end"), [(0.0, 1.0), (0.4, 1.2), (0.413, 1.2), (1.6, 0.0), (1.52, 9.0)])
def test_a_part_is_cut_out_of_the_whole(recording, start, end):
    first = round(start * 25)
    last = min(50, first + round((end - first / 25) * 25)) if end else 50
    frames = list(reading.read_frames(recording, start, end))
    np.testing.assert_array_equal(frames, decoded(recording)[first:last])
    assert reading.scan_video(recording, start, end).frames == len(frames)
    whole = reading.read_audio(recording, 16000)
    samples = reading.read_audio(recording, 16000, start, end)
    if end and end < 2:
        assert len(samples) == len(frames) * 640
    expected = whole[first * 640 :][: len(samples)]
    # The resampler starts anew within the part, so its first milliseconds may differ.
    np.testing.assert_allclose(samples[:-200], expected[:-200], atol=1e-4)


@pytest.mark.parametrize("name", ["long.mp4", "long.ts"])
def test_a_late_part_is_sought_and_is_the_same(tmp_path, name):
    """Seeking must land on the same pictures as decoding from the beginning."""
    frames = synthetic.pictures(25 * 32, 48, 64)
    path = synthetic.record(tmp_path / name, 32.0, frames=frames)
    np.testing.assert_array_equal(list(reading.read_frames(path, 28.0, 28.4)), decoded(path)[700:710])
    whole = reading.read_audio(path, 16000)
    part = reading.read_audio(path, 16000, 28.0, 30.0)
    np.testing.assert_allclose(part[800:31000], whole[28 * 16000 :][800:31000], atol=2e-2)


def test_variable_rate_becomes_constant_by_the_time_stamps(tmp_path):
    """Each frame of the constant rate shows what a screen shows at its middle, found here the slow way."""
    steps = np.random.default_rng(3).choice([1, 1, 2, 3], 40) / 30
    times = np.r_[0, np.cumsum(steps)]
    path = synthetic.record(tmp_path / "v.mp4", float(times[-1]), rate=30, times=times)
    rate = reading.probe(path).rate
    pictures = decoded(path)
    assert len(pictures) == 41
    length = times[-1] + 1 / rate
    middles = np.arange(0.5, length * rate) / rate
    expected = [pictures[max(index for index, time in enumerate(times) if time <= middle)] for middle in middles]
    frames = list(reading.read_frames(path))
    assert len(frames) == reading.scan_video(path).frames
    np.testing.assert_array_equal(frames, expected[: len(frames)])
    assert abs(len(frames) / rate - length) <= 0.5 / rate


def test_the_number_of_frames_is_that_of_the_scan_after_damage(tmp_path):
    """Bytes in the middle are overwritten: pictures are lost, frames are not."""
    path = synthetic.record(tmp_path / "a.mpg", 2.0, codecs=("mpeg1video", "mp2"), audio_rate=44100)
    data = bytearray(path.read_bytes())
    data[len(data) // 3 : len(data) // 3 + 300] = bytes(300)
    path.write_bytes(data)
    frames = list(reading.read_frames(path))
    scan = reading.scan_video(path)
    assert len(frames) == scan.frames >= 45
    assert len(list(reading.read_frames(path))) == scan.frames


def test_truncated_video_ends_early_and_does_not_raise(tmp_path):
    path = synthetic.truncated(synthetic.record(tmp_path / "a.mkv", 2.0), 0.6)
    frames = list(reading.read_frames(path))
    assert 10 < len(frames) == reading.scan_video(path).frames < 50
    assert 0 < len(reading.read_audio(path, 16000)) < 32000


def test_phone_recordings_are_turned_upright(tmp_path):
    """A quarter turn counterclockwise brings the right edge of the stored picture to the top."""
    picture = np.zeros((96, 128, 3), np.uint8)
    picture[:, 96:] = 255
    path = synthetic.record(tmp_path / "r.mp4", 0.4, frames=[picture] * 10, rotation=90)
    info = reading.probe(path)
    assert (info.width, info.height) == (96, 128)
    frame = next(reading.read_frames(path))
    assert frame.shape == (128, 96, 3) and frame.flags.c_contiguous
    assert frame[:24].mean() > 230 and frame[48:].mean() < 25


def test_channels_are_averaged_and_stay_within_full_scale(tmp_path):
    path = tmp_path / "stereo.wav"
    tone = np.sin(2 * np.pi * 440 * np.arange(16000) / 16000)
    with av.open(str(path), "w") as out:
        stream = out.add_stream("pcm_s16le", rate=16000, layout="stereo")
        both = np.round(np.stack([tone, 0.5 * tone], axis=1) * 32767).astype(np.int16).reshape(1, -1)
        frame = av.AudioFrame.from_ndarray(both, format="s16", layout="stereo")
        frame.sample_rate, frame.pts = 16000, 0
        out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    np.testing.assert_allclose(reading.read_audio(path, 16000), 0.75 * tone, atol=1e-3)


def test_sound_before_the_first_picture_is_left_out(tmp_path):
    path = synthetic.record(tmp_path / "late.mp4", 2.0, late=0.5)
    whole = synthetic.hum(2.0)[8000:]
    samples = reading.read_audio(path, 16000)
    assert reading.probe(path).early_sound == pytest.approx(0.5, abs=0.01)
    assert len(list(reading.read_frames(path))) == 50
    assert np.corrcoef(samples[: len(whole)], whole[: len(samples)])[0, 1] > 0.95


@pytest.mark.parametrize("content", [b"", b"no video at all" * 300, bytes(range(256)) * 40])
def test_what_is_no_video_is_rejected_in_words(tmp_path, content):
    path = tmp_path / "x.mp4"
    path.write_bytes(content)
    for read in (reading.probe, reading.scan_video, lambda name: list(reading.read_frames(name))):
        with pytest.raises(RejectedUtterance, match="unreadable media file") as error:
            read(path)
        assert error.value.remedy and str(tmp_path) not in error.value.reason


def test_what_is_not_there_is_rejected_in_words(tmp_path):
    with pytest.raises(RejectedUtterance, match="does not exist"):
        reading.probe(tmp_path / "x.mp4")
    with pytest.raises(RejectedUtterance, match="no audio stream"):
        reading.read_audio(synthetic.record(tmp_path / "mute.mp4", 0.4, audio=np.zeros(0)), 16000)
    with pytest.raises(RejectedUtterance, match="no frame of this segment"):
        list(reading.read_frames(synthetic.record(tmp_path / "short.mp4", 0.4), 5.0, 6.0))


def test_written_videos_are_read_back_and_repeat(tmp_path):
    frames = synthetic.pictures(20)
    sound = synthetic.hum(0.8, 48000)
    for name in ("1.mp4", "2.mp4"):
        encoding.write_video(tmp_path / name, iter(frames), 25.0, sound, 48000, {"comment": "synthetic"})
    assert (tmp_path / "1.mp4").read_bytes() == (tmp_path / "2.mp4").read_bytes()
    back = np.array(list(reading.read_frames(tmp_path / "1.mp4")), float)
    assert back.shape == (20, 96, 128, 3)
    assert np.abs(back - np.array(frames, float)).mean() < 3
    with av.open(str(tmp_path / "1.mp4")) as container:
        assert container.metadata["comment"] == "synthetic"
    heard = reading.read_audio(tmp_path / "1.mp4", 48000)
    assert np.corrcoef(heard[: len(sound)], sound)[0, 1] > 0.95


@pytest.mark.parametrize("leap", [3600.0, -3.0])
def test_clocks_that_leap_are_set_right(leap):
    """An hour of repeated pictures, or none, would be the answer to damaged time stamps."""
    frames = [type("Frame", (), {"time": time, "width": 4, "height": 4})() for time in np.arange(200) / 25]
    for frame in frames[100:]:
        frame.time += leap
    timed = list(decoding._timed(frames, 25.0, 0.0))
    np.testing.assert_allclose([time for time, _ in timed], np.arange(200) / 25, atol=1e-9)


def test_pictures_of_another_size_are_left_out():
    frames = [
        type("Frame", (), {"time": index / 25, "width": width, "height": 4})() for index, width in enumerate([4, 8, 4])
    ]
    assert [frame is None for _, frame in decoding._timed(frames, 25.0, 0.0)] == [False, True, False]


def test_sound_is_written_beside_the_pictures_that_it_belongs_to(tmp_path):
    """Given in pieces or as one, the same bytes; and no packet lies far from those of the other stream."""
    sound = np.random.default_rng(0).normal(0, 0.1, 3 * 16000).astype(np.float32)
    paths = tmp_path / "pieces.mp4", tmp_path / "whole.mp4"
    for path, audio in zip(paths, (iter(np.split(sound, [5, 5000, 30000])), sound), strict=True):
        encoding.write_video(path, (np.full((32, 48, 3), i, np.uint8) for i in range(75)), 25, audio, 16000)
    assert paths[0].read_bytes() == paths[1].read_bytes()
    with av.open(str(paths[0])) as file:
        packets = [
            (packet.pos, packet.stream.type, float(packet.pts * packet.time_base))
            for packet in file.demux()
            if packet.size
        ]
    assert np.allclose(reading.read_audio(paths[0], 16000)[: len(sound)].std(), sound.std(), rtol=0.1)
    heard = shown = 0.0
    for _, kind, time in sorted(packets):
        heard, shown = (time, shown) if kind == "audio" else (heard, max(shown, time))
        assert abs(heard - shown) < 1.5


@pytest.mark.parametrize("name", ["a.mp4", "a.mkv", "a.ts"])
def test_streamed_sound_is_that_of_the_whole(tmp_path, name):
    sound = np.random.default_rng(0).normal(0, 0.1, 5 * 16000).astype(np.float32)
    path = synthetic.record(tmp_path / name, 5.0, audio=sound, audio_rate=16000)
    parts = list(reading.stream_audio(path, 22050))
    assert len(parts) > 3 and np.array_equal(np.concatenate(parts), reading.read_audio(path, 22050))
    with pytest.raises(RejectedUtterance, match="does not exist"):
        next(reading.stream_audio(tmp_path / "nowhere.wav", 16000))
    encoding.write_video(tmp_path / "mute.mp4", iter(np.zeros((3, 32, 48, 3), np.uint8)), 25)
    with pytest.raises(RejectedUtterance, match="no audio stream"):
        next(reading.stream_audio(tmp_path / "mute.mp4", 16000))
