"""The targets `speaker` and `speak`, and the console command with what they write."""

import subprocess
import sys

import av
import pytest

from tests.workflow import running
from tests.workflow.running import planned_rules, snakemake
from visualspeech.media.reading import probe

pytestmark = pytest.mark.xdist_group("workflow")

TEXTS = ["Hello there.", "A big map. Please buy the pie!"]


def overlay(folder, **speak):
    return running.overlay(folder, {"speak": speak}, name="speak.yaml")


@pytest.fixture(scope="module")
def spoken(tiny_run, tmp_path_factory):
    """The finished run with two sentences spoken; it only gains files that no other target makes."""
    files = overlay(tmp_path_factory.mktemp("speak"), sentences=TEXTS, background_seconds=5)
    done = snakemake(tiny_run, "speak", configfiles=files)
    assert done.returncode == 0, done.stdout[-4000:]
    return tiny_run, files


def test_speaking_needs_a_speaker_and_nothing_else_of_a_finished_run(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "speak", configfiles=overlay(tmp_path, sentences=["One.", "Two."]))
    assert {"speak_sentence", "speak"} <= rules <= {"bundle_speaker", "speak_sentence", "speak"}


def test_one_video_a_text_with_sound_and_label(spoken):
    folder, _ = spoken
    for number, text in enumerate(TEXTS, start=1):
        path = folder / "results" / "tiny" / "fan2015" / "spoken" / f"{number:03d}.mp4"
        assert probe(path).audio_rate == 22050 and probe(path).duration > 1
        with av.open(str(path)) as file:
            said = dict(file.metadata)
        assert said["text"] == text and said["synthetic"] == "yes" and "Voice: synthetic" in said["comment"]
        assert "made by this project" in said["consent"]


def test_another_sentence_makes_one_video_only(spoken, tmp_path):
    folder, files = spoken
    assert "Nothing to be done" in snakemake(folder, "speak", configfiles=files).stdout
    changed = overlay(tmp_path, sentences=[TEXTS[0], "Something else."], background_seconds=5)
    done = snakemake(folder, "--dry-run", "speak", configfiles=changed)
    assert done.stdout.count("rule speak_sentence:") == 1 and "rule bundle_speaker:" not in done.stdout


def test_the_console_command_takes_the_folder(spoken, tmp_path):
    folder, _ = spoken
    model = folder / "results" / "tiny" / "fan2015" / "speakers" / "FB-16"
    command = [
        sys.executable,
        "-m",
        "visualspeech",
        "speak",
        "--model",
        model,
        "--text",
        "Hi.",
        "-o",
        tmp_path / "a.mp4",
    ]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert probe(tmp_path / "a.mp4").rate == 25


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"sentences": ["Fine.", "?!"]}, "no word to pronounce in '?!'"),
        ({"sentences": []}, "speak.sentences: []"),
        ({"model": "FBB-77"}, "`speak.model: FBB-77` is no model of fan2015"),
        ({"file": "nowhere.txt"}, "cannot read the sentences of nowhere.txt"),
        ({"sentence": ["a"]}, "Did you mean `sentences`?"),
        ({"voice": {"rate_wpm": 5}}, "speak.voice.rate_wpm: 5"),
    ],
)
def test_bad_settings_fail_before_any_job(settings, said, tmp_path):
    done = snakemake(tmp_path, "speak", configfiles=overlay(tmp_path, **settings))
    assert done.returncode != 0 and said in done.stdout, done.stdout[-2000:]
    assert "Traceback" not in done.stdout and "Job stats" not in done.stdout
