import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tomllib

import pytest

from tests.paths import REPOSITORY
from tests.unit.animation import speakers
from visualspeech.animation.bundle import DESCRIPTION
from visualspeech.cli import main
from visualspeech.media.reading import probe
from visualspeech.speech.spoken import speak_text


@pytest.fixture(scope="module")
def speaker(tmp_path_factory):
    return speakers.make(tmp_path_factory.mktemp("speaker") / "made")


def told(capsys, *arguments):
    """Exit status and what is said on standard error."""
    try:
        status = main(["speak", *map(str, arguments)])
    except SystemExit as left:
        status = left.code
    return status, capsys.readouterr().err


def test_a_text_becomes_a_video(speaker, tmp_path, capsys):
    path = tmp_path / "out.mp4"
    assert told(capsys, "--model", speaker, "--text", "Hello.", "-o", path, "--quiet") == (0, "")
    assert probe(path).audio_rate == 22050


def test_a_recording_with_its_text_becomes_a_video(speaker, tmp_path, capsys):
    import soundfile

    speech = next(iter(speak_text("The boys buy a map.")))
    sound, text = tmp_path / "said.wav", tmp_path / "said.txt"
    soundfile.write(sound, speech.samples, speech.rate)
    text.write_text("The boys buy a map.")
    path = tmp_path / "out.mp4"
    status, _ = told(capsys, "--model", speaker, "--audio", sound, "--text-file", text, "-o", path)
    assert status == 0
    assert probe(path).duration == pytest.approx(len(speech.samples) / speech.rate, abs=0.1)
    status, said = told(capsys, "--model", speaker, "--audio", sound, "-o", tmp_path / "heard.mp4")
    assert status == 0 and "the lips follow the sound of the recording (model F-4-mel)" in said
    assert probe(tmp_path / "heard.mp4").duration == probe(path).duration
    # Without a model that reads sound, phones are recognised.
    about = json.loads((speaker / DESCRIPTION).read_text())
    del about["parts"]["sound"]
    mute = shutil.copytree(speaker, tmp_path / "mute")
    (mute / DESCRIPTION).write_text(json.dumps(about))
    status, said = told(capsys, "--model", mute, "--audio", sound, "-o", tmp_path / "phones.mp4")
    assert status == 0 and "the lips follow recognised phones; for better ones, give its text" in said
    assert probe(tmp_path / "phones.mp4").duration == probe(path).duration


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (["--text", "?! ..."], 2, "no word to pronounce"),
        (["--text", "Hello.", "--voice", "martian"], 2, "no voice"),
        (["--text", "Hello.", "--speed", "20"], 2, "at least 80 and at most 450"),
        ([], 2, "nothing to say"),
        (["--text", "a", "--text-file", "b.txt"], 2, "give one of them"),
        (["--text-file", "nowhere.txt"], 2, "nowhere.txt: No such file"),
        (["--audio", "nowhere.wav"], 1, "nowhere.wav: the file does not exist"),
        (["--audio", "nowhere.wav", "--text", " "], 2, "no word to pronounce"),
        (["--audio", "nowhere.wav", "--text", "Hello."], 1, "nowhere.wav: the file does not exist"),
        (["--text", "Hello.", "-o", "out.avi"], 2, "ends in .mp4"),
        (["--text", "Hello.", "--model", "nowhere"], 2, "--model nowhere does not exist"),
        (["--text", "Hello.", "--model", "/usr"], 1, "holds no speaker.json"),
        (["--text", "Hello.", "--seed", "-1"], 2, "--seed"),
        (["--text", "Hello.", "-o", "/proc/nowhere/out.mp4"], 1, "cannot write /proc/nowhere/out.mp4"),
        (["--nonsense"], 2, "unrecognized arguments"),
    ],
)
def test_mistakes_are_told_in_a_sentence(speaker, tmp_path, capsys, monkeypatch, arguments, status, said):
    monkeypatch.chdir(tmp_path)
    found, error = told(capsys, "--model", speaker, "-o", "out.mp4", "--quiet", *arguments)
    assert found == status and said in error, error
    assert "Traceback" not in error and not list(tmp_path.iterdir())


def test_a_sound_without_these_words_is_told(speaker, tmp_path, capsys):
    import numpy as np
    import soundfile

    sound = tmp_path / "tone.wav"
    soundfile.write(sound, 0.3 * np.sin(np.arange(4000) / 5), 16_000)
    text = "This sentence is much too long to be said in a quarter of a second, whoever speaks."
    status, error = told(capsys, "--model", speaker, "--audio", sound, "--text", text, "-o", tmp_path / "out.mp4")
    assert status == 1 and "tone.wav: the words of the transcript" in error and "Listen to it" in error


def contents(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir()) if path.is_file()}


def test_an_output_never_replaces_an_input(speaker, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("mine.mp4", "said.mp4"):
        (tmp_path / name).write_text("Hello.")
    (tmp_path / "hard.mp4").hardlink_to("mine.mp4")
    (tmp_path / "soft.mp4").symlink_to("mine.mp4")
    (tmp_path / "model").symlink_to(speaker)
    (tmp_path / "part.mp4").hardlink_to(speaker / "model.safetensors")
    before, parts = contents(tmp_path), contents(speaker)
    (tmp_path / "sub").mkdir()
    audio, model = ["--model", speaker, "--audio", "mine.mp4"], ["--model", "model", "--text", "Hello."]
    for arguments, outputs, said in [
        (
            audio,
            ["mine.mp4", "./mine.mp4", tmp_path / "mine.mp4", "sub/../mine.mp4", "hard.mp4", "soft.mp4"],
            "--audio",
        ),
        (["--model", speaker, "--text-file", "said.mp4"], ["said.mp4"], "--text-file"),
        (model, ["model/new.mp4", speaker / "new.mp4", "part.mp4", "model/sub/x.mp4"], "a part of the speaker"),
    ]:
        for output in outputs:
            status, error = told(capsys, *arguments, "-o", output)
            assert status == 2 and said in error and "give another name" in error, error
    assert contents(tmp_path) == before and contents(speaker) == parts


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (["-o", "x" * 252 + ".mp4"], 2, "has 256 bytes; give one of at most 255"),
        (["-o", "x" * 296 + ".mp4"], 2, "has 300 bytes; give one of at most 255"),
        (["-o", "y" * 256 + "/x.mp4"], 2, "the name of a folder at most 255"),
        (["-o", "y/" * 2500 + "x.mp4"], 2, "a path has at most 4000 bytes"),
        (["-o", "pipe.mp4"], 2, "is a device or pipe"),
        (["-o", "file/x.mp4"], 1, "cannot write file/x.mp4"),
        (["-o", "\udce9.mp4"], 2, "not UTF-8"),
        (["--text", "a\ud800"], 2, "is not UTF-8; give it in a UTF-8 terminal"),
        (["--text", "a\udce9"], 2, "is not UTF-8"),
        (["--text", "a\x00b"], 2, "the control character U+0000"),
        (["--text", "a\x1bb"], 2, "the control character U+001B"),
        (["--text", "a" * 100_000], 2, "has 100,000 letters; give words of at most 1000"),
        (["--text", "a " * 600_000], 2, "has 1,200,000 characters; give at most 1,000,000"),
        (["--text", "🙂🙂"], 2, "no word to pronounce"),
        (["--text", "مرحبا"], 2, "no word to pronounce"),
        (["--text", "Hi.", "--seed", "9" * 24], 2, "give a number from 0 to 999999999"),
        (["--text", "Hi.", "--speed", "9" * 24], 2, "at least 80 and at most 450"),
        (["--text", "Hi.", "--pitch", "101"], 2, "at least 0 and at most 100"),
        (["--text", "Hi.", "--pitch", "-1"], 2, "at least 0 and at most 100"),
        (["--text", "Hi.", "--voice", "x" * 5000], 2, "at most 64 characters"),
        (["--text", "Hi.", "--voice", "../x"], 2, "speak.voice.voice"),
        (["--text", "Hi.", "--voice", "\ud800"], 2, "speak.voice.voice"),
        (["--text", "Hi.", "--model", "file"], 2, "is a file; give the folder"),
        (["--text-file", "."], 2, "Is a directory"),
        (["--text-file", "binary"], 2, "it is not UTF-8 text (byte 1)"),
        (["--text-file", "huge"], 2, "more than 4,000,000 bytes"),
        (["--text-file", "nul"], 2, "the control character U+0000"),
        (["--audio", "http://127.0.0.1:9/x.wav"], 1, "the file does not exist"),
        (["--audio", "pipe:0"], 1, "the file does not exist"),
        (["--audio", "concat:file|file"], 1, "the file does not exist"),
        (["--audio", "."], 1, "not a regular file"),
        (["--audio", "pipe.mp4"], 1, "not a regular file"),
        (["--audio", "x" * 300], 1, "File name too long"),
    ],
    ids=lambda value: ascii(value)[:60],
)
def test_extreme_command_lines(speaker, tmp_path, capsys, monkeypatch, arguments, status, said):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe.mp4")
    for name, data in {"file": b"Hello.", "binary": b"a\xff", "huge": b"a " * 2_100_000, "nul": b"a\0b"}.items():
        (tmp_path / name).write_bytes(data)
    given = [] if set(arguments) & {"--text", "--text-file", "--audio"} else ["--text", "Hello."]
    before = sorted(tmp_path.iterdir())
    found, error = told(capsys, "--model", speaker, "-o", "out.mp4", "--quiet", *given, *arguments)
    assert found == status and said in error, error
    assert error.startswith("visualspeech: ") and error.count("\n") == 1 and len(error) < 6000, error
    assert sorted(tmp_path.iterdir()) == before and "codec" not in error


def test_standard_input_is_checked_as_a_file_is(speaker, tmp_path, capsys, monkeypatch):
    for data, said in ((b"", "no word to pronounce"), (b"Andr\xe9", "it is not UTF-8 text (byte 4)")):
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))
        status, error = told(capsys, "--model", speaker, "--text-file", "-", "-o", tmp_path / "out.mp4")
        assert status == 2 and said in error


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.001, "too short for speech"), (0.15, "too short"), (2, "no speech"), (45, "no speech")]
)
@pytest.mark.parametrize("level", [0.01, 0.3])
def test_noise_and_a_click_are_no_speech(speaker, tmp_path, capsys, seconds, said, level):
    import numpy as np
    import soundfile

    noise = np.random.default_rng(1).normal(size=round(16_000 * seconds))
    soundfile.write(tmp_path / "noise.wav", np.clip(level * noise, -1, 1), 16_000)
    status, error = told(
        capsys, "--model", speaker, "--audio", tmp_path / "noise.wav", "-o", tmp_path / "x.mp4", "--quiet"
    )
    assert status == 1 and said in error and [path.name for path in tmp_path.iterdir()] == ["noise.wav"]


def test_the_command_is_installed_with_the_package():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert project["scripts"] == {"visualspeech": "visualspeech.cli:main"}
    done = subprocess.run(
        [sys.executable, "-m", "visualspeech", "--help"], capture_output=True, text=True, cwd=REPOSITORY
    )
    assert done.returncode == 0 and "speak" in done.stdout


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGINT, signal.SIGTERM])
def test_a_signal_is_answered_in_a_sentence_and_leaves_nothing(speaker, tmp_path, number):
    if signal.getsignal(number) == signal.SIG_IGN:
        pytest.skip("this signal is ignored here, as under nohup")
    text = "The boys buy a map of the long road to the sea. " * 20
    process = subprocess.Popen(
        [sys.executable, "-m", "visualspeech", "speak", "--model", speaker, "--text", text, "-o", tmp_path / "out.mp4"],
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    while process.poll() is None and not list(tmp_path.glob(".partial.*")):
        time.sleep(0.01)
    for _ in range(2):
        process.send_signal(number)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 128 + number
    assert said.splitlines()[-1] == "visualspeech: stopped; nothing was written." and "Traceback" not in said
    assert not list(tmp_path.iterdir())
