"""What ``visualspeech speak`` writes: containers, sizes, frames and timings; each output is whole or absent."""

import json
import os
import signal
import subprocess
import sys
import time

import av
import cv2
import numpy as np
import pytest

from tests.unit.animation import speakers
from tests.unit.test_cli import contents, told
from visualspeech.media.reading import probe, read_audio, read_frames


@pytest.fixture(scope="module")
def speaker(tmp_path_factory):
    return speakers.make(tmp_path_factory.mktemp("speaker") / "made")


def hello(speaker, *more):
    return ["--model", speaker, "--text", "Hello, I buy a map.", "--quiet", *more]


@pytest.mark.parametrize(
    ("name", "codecs", "rate"),
    [("a.mp4", {"h264", "aac"}, 22050), ("a.mov", {"h264", "aac"}, 22050), ("a.WEBM", {"vp9", "opus"}, 48000)],
)
def test_the_suffix_chooses_the_container(speaker, tmp_path, capsys, name, codecs, rate):
    assert told(capsys, *hello(speaker, "-o", tmp_path / name)) == (0, "")
    with av.open(str(tmp_path / name)) as file:
        found = {stream.codec_context.codec.canonical_name for stream in file.streams}
        tags = {key.lower(): value for key, value in file.metadata.items()}
    assert found == codecs and probe(tmp_path / name).audio_rate == rate
    assert tags["synthetic"] == "yes" and "SYNTHETIC" in tags["comment"]
    loud = np.abs(read_audio(tmp_path / name, 16000)) > 0.05
    assert 0.3 < np.flatnonzero(loud)[0] / 16000 < 0.6


@pytest.mark.parametrize(
    ("size", "expected", "said"),
    [
        ("180x144", (180, 144), ""),
        ("144", (180, 144), ""),
        ("300X300", (300, 300), ""),
        ("576", (720, 576), "--size is larger than the recorded 360 by 288 pixels"),
    ],
)
def test_the_size_of_the_video(speaker, tmp_path, capsys, size, expected, said):
    path = tmp_path / "a.mp4"
    given = [one for one in hello(speaker, "-o", path, "--size", size) if said == "" or one != "--quiet"]
    status, error = told(capsys, *given)
    assert status == 0 and said in error
    frame = next(read_frames(path))
    assert frame.shape[1::-1] == expected
    if size == "300X300":  # the frames of 360 x 288 are 240 high, between bars of 30
        assert frame[:26].max() < 30 and frame[-26:].max() < 30 and frame[40:200].mean() > 60


def test_frames_are_those_of_the_video_with_its_sound_beside_them(speaker, tmp_path, capsys):
    import soundfile

    given = hello(speaker, "-o", tmp_path / "a.mp4", "--frames", tmp_path / "png", "--timings", tmp_path / "t.json")
    assert told(capsys, *given) == (0, "")
    names = sorted(path.name for path in (tmp_path / "png").iterdir())
    video = list(read_frames(tmp_path / "a.mp4"))
    assert names == [*(f"{number:06d}.png" for number in range(1, len(video) + 1)), "sound.wav"]
    for number in (0, len(video) // 2, len(video) - 1):
        png = cv2.imread(str(tmp_path / "png" / names[number]))[:, :, ::-1]
        assert np.abs(png.astype(float) - video[number]).mean() < 4
    sound, rate = soundfile.read(tmp_path / "png" / "sound.wav")
    assert rate == 22050 and len(sound) / rate == pytest.approx(len(video) / 25, abs=0.001)
    data = json.loads((tmp_path / "t.json").read_text())
    assert (data["frames"], data["rate"], data["text"]) == (len(video), 25, "Hello, I buy a map.")
    assert [one["label"] for one in data["words"]] == ["hello", "i", "buy", "a", "map"]
    assert data["phones"][0]["label"] == "sil" and data["phones"][-1]["end"] <= data["seconds"]


def test_frames_alone_need_no_video(speaker, tmp_path, capsys):
    (tmp_path / "png").mkdir()  # an empty folder may be there
    assert told(capsys, *hello(speaker, "--frames", tmp_path / "png", "--size", "96x64")) == (0, "")
    assert [path.name for path in tmp_path.iterdir()] == ["png"]
    assert cv2.imread(str(tmp_path / "png" / "000001.png")).shape == (64, 96, 3)


def test_timings_of_a_recording(speaker, tmp_path, capsys):
    import shutil

    import soundfile

    from visualspeech.animation.bundle import DESCRIPTION
    from visualspeech.speech.spoken import speak_text

    speech = next(iter(speak_text("The boys buy a map.")))
    soundfile.write(tmp_path / "said.wav", speech.samples, speech.rate)
    given = ["--model", speaker, "--audio", tmp_path / "said.wav", "-o", tmp_path / "a.mp4", "--quiet"]
    status, error = told(capsys, *given, "--timings", tmp_path / "t.json")
    assert status == 2 and "--timings: the lips follow the sound alone" in error
    assert sorted(path.name for path in tmp_path.iterdir()) == ["said.wav"]
    assert told(capsys, *given, "--text", "The boys buy a map.", "--timings", tmp_path / "t.json") == (0, "")
    words = json.loads((tmp_path / "t.json").read_text())["words"]
    assert [one["label"] for one in words] == ["the", "boys", "buy", "a", "map"]
    truth = {one.label: one.start for one in speech.alignment.words if one.label != "sil"}
    assert all(abs(one["start"] - truth[one["label"]]) < 0.1 for one in words)
    mute = shutil.copytree(speaker, tmp_path / "mute")
    about = json.loads((mute / DESCRIPTION).read_text())
    del about["parts"]["sound"]
    (mute / DESCRIPTION).write_text(json.dumps(about))
    given[1] = mute
    assert told(capsys, *given, "--timings", tmp_path / "r.json") == (0, "")
    recognised = json.loads((tmp_path / "r.json").read_text())
    assert recognised["words"] == [] and len(recognised["phones"]) > 8 and recognised["text"] == ""


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        ([], 2, "there is nothing to write; give --output, --frames or both"),
        (["--timings", "t.json"], 2, "there is nothing to write"),
        (["-o", "a.avi"], 2, "--output a.avi: videos are written as MP4, MOV or WebM; give a name that ends in .mp4"),
        (["-o", "a"], 2, "ends in .mp4, .mov or .webm"),
        (["-o", "a.mp4", "--size", "361x288"], 2, "--size 361x288: videos need even sizes; give 362 or 360"),
        (["-o", "a.mp4", "--size", "145"], 2, "give 146 or 144 instead of 145"),
        (["-o", "a.mp4", "--size", "0x0"], 2, "0 is not from 64 to 4096 pixels"),
        (["-o", "a.mp4", "--size", "100000"], 2, "100000 is not from 64 to 4096"),
        (["-o", "a.mp4", "--size", "9" * 500], 2, "give WIDTHxHEIGHT"),
        (["-o", "a.mp4", "--size", "-2"], 2, "--size"),
        (["-o", "a.mp4", "--size", "1x2x3"], 2, "give WIDTHxHEIGHT, such as 640x480, or a height"),
        (["-o", "a.mp4", "--size", "large"], 2, "--size large: give WIDTHxHEIGHT"),
        (["-o", "a.mp4", "--size", "²x²"], 2, "give WIDTHxHEIGHT"),
        (["-o", "a.mp4", "--size", ""], 2, "give WIDTHxHEIGHT"),
        (["-o", "a.mp4", "--timings", "a.mp4"], 2, "--output and --timings are both a.mp4; give two names"),
        (["-o", "a.mp4", "--timings", "./a.mp4"], 2, "--output and --timings are both"),
        (["-o", "a.mp4", "--frames", "a.mp4"], 2, "--output and --frames are both a.mp4"),
        (["-o", "d/a.mp4", "--frames", "d"], 2, "--output d/a.mp4 lies in the folder of --frames"),
        (["--frames", "d", "--timings", "d/t.json"], 2, "--timings d/t.json lies in the folder of --frames"),
        (["--frames", "full"], 2, "--frames full is a folder that holds files; give a new or an empty one"),
        (["--frames", "file"], 2, "--frames file is not a folder"),
        (["--frames", "."], 2, "--frames . is no name of a file or folder"),
        (["--frames", "link"], 2, "--frames link is not a folder"),
        (["--frames", "/proc/nowhere/d"], 1, "cannot write /proc/nowhere/d"),
        (["-o", "a.mp4", "--timings", "/proc/nowhere/t"], 1, "cannot write /proc/nowhere/t"),
        (["-o", "a.mp4", "--timings", "full"], 2, "--timings full is a folder; give the name of a file"),
        (["-o", "a.mp4", "--timings", "x" * 300], 2, "--timings: the name of the file has 300 bytes"),
        (["-o", "a.mp4", "--background", ""], 0, ""),
        (["-o", "a.mp4", "--background", "full"], 1, "full is no background: it holds no background.json"),
        (["-o", "full/a.mp4", "--frames", "speaker/png"], 2, "--frames speaker/png is a part of the speaker"),
        (["-o", "a.mp4", "--frames", "speaker"], 2, "--frames speaker is not a folder"),
    ],
    ids=lambda value: ascii(value)[:50],
)
def test_mistakes_are_told_in_a_sentence(speaker, tmp_path, capsys, monkeypatch, arguments, status, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("keep")
    (tmp_path / "file").write_text("keep")
    (tmp_path / "link").symlink_to("full")
    (tmp_path / "speaker").symlink_to(speaker)
    before = sorted(tmp_path.rglob("*"))
    found, error = told(capsys, *hello("speaker", *arguments))
    assert found == status and said in error, error
    if status:
        assert error.count("\n") == 1 and error.startswith("visualspeech: ")
        assert sorted(tmp_path.rglob("*")) == before


def test_an_output_never_replaces_an_input(speaker, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "said.txt").write_text("Hello.")
    parts = contents(speaker)
    given = ["--model", speaker, "--text-file", "said.txt", "-o", "a.mp4"]
    status, error = told(capsys, *given, "--timings", "said.txt")
    assert status == 2 and "is the file of --text-file, which would be replaced" in error
    status, error = told(capsys, *given, "--timings", speaker / "t.json")
    assert status == 2 and "a part of the speaker" in error
    assert contents(speaker) == parts and [path.name for path in tmp_path.iterdir()] == ["said.txt"]


def test_a_disk_that_is_full_leaves_nothing(speaker, tmp_path, capsys, monkeypatch):
    import errno

    from visualspeech.animation import frame_files

    def full(self, data):
        raise OSError(errno.ENOSPC, "No space left on device", str(self))

    given = hello(speaker, "-o", tmp_path / "a.mp4", "--frames", tmp_path / "png", "--timings", tmp_path / "t.json")
    monkeypatch.setattr(frame_files.Path, "write_bytes", full)
    status, error = told(capsys, *given)
    assert status == 1 and "No space left on device" in error and "Traceback" not in error, error
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("wait", [0.0, 0.4])
def test_a_signal_leaves_nothing_of_any_output(speaker, tmp_path, wait):
    text = "The boys buy a map of the long road to the sea. " * 20
    process = subprocess.Popen(
        [sys.executable, "-m", "visualspeech", "speak", "--model", speaker, "--text", text, "-o",
         tmp_path / "out.webm", "--frames", tmp_path / "png", "--timings", tmp_path / "t.json"],
        stderr=subprocess.PIPE, text=True, env={**os.environ},
    )  # fmt: skip
    while process.poll() is None and not list(tmp_path.glob(".partial.*/000001.png")):
        time.sleep(0.01)
    time.sleep(wait)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 128 + signal.SIGTERM
    assert said.splitlines()[-1] == "visualspeech: stopped; nothing was written." and "Traceback" not in said
    assert not list(tmp_path.iterdir())
