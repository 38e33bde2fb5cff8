import signal
import subprocess
import sys
import time
import tomllib

import pytest

from tests.paths import REPOSITORY
from tests.unit.animation import speakers
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
    assert status == 0 and "give what is said with --text" in said
    assert probe(tmp_path / "heard.mp4").duration == probe(path).duration


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
        (["--text", "Hello.", "--model", "nowhere"], 1, "holds no speaker.json"),
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
