"""Backgrounds of one's own: a clip is prepared, checked and spoken on, through the command line."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time

import cv2
import numpy as np
import pytest

from tests import synthetic
from tests.unit.animation import speakers
from tests.unit.animation.faces import draw
from tests.unit.face import heads, openface
from visualspeech import Speaker
from visualspeech.animation.background import Background
from visualspeech.animation.backgrounds import ABOUT, head_in, load_background, prepare_background
from visualspeech.animation.bundle import FILES, SpeakerBundle
from visualspeech.cli import main
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.media.encoding import write_video
from visualspeech.media.reading import probe, read_frames
from visualspeech.provenance import file_digest

RATE = 25.0


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """A folder with the speaker ``made``, clips of drawn faces, and their landmarks as OpenFace writes them."""
    folder = tmp_path_factory.mktemp("clips")
    speakers.make(folder / "made")
    points = heads.record(50, seed=4, mouth=2).points
    other = points.copy()
    other[:, 48:68] += (0, 14)  # a longer chin
    other[:, 4:13] += (0, 25)
    add(folder, "same", points)
    add(folder, "other", other)
    add(folder, "short", points[:10])
    add(folder, "large", points, scale=2)
    add(folder, "fast", points, rate=50.0)
    add(folder, "lost", points, seen=30)
    write_video(folder / "unseen.mp4", (draw(one) for one in points), RATE)
    (folder / "text.mp4").write_text("no video")
    return folder


def add(folder, name, points, scale=1, rate=RATE, seen=None):
    """Write a clip of a drawn face and its landmarks, those of the first ``seen`` frames."""
    size = (scale * heads.SIZE[0], scale * heads.SIZE[1])
    drawn = (cv2.resize(draw(one), size, interpolation=cv2.INTER_CUBIC) for one in points)
    write_video(folder / f"{name}.mp4", drawn, rate)
    openface.write(folder / "of" / f"{name}.csv", openface.rows(scale * points[:seen], rate=rate))


def prepared(clips, target, *names, **given):
    settings = LandmarkSettings(source="csv", folder=str(clips / "of"))
    return prepare_background(
        target, clips / "made", [clips / f"{name}.mp4" for name in names], landmarks=settings, **given
    )


def told(capsys, *arguments):
    """Exit status and what is said on standard error."""
    try:
        status = main([*map(str, arguments)])
    except SystemExit as left:
        status = left.code
    return status, capsys.readouterr().err


@pytest.fixture(scope="module")
def same(clips):
    prepared(clips, clips / "bg", "same")
    return clips / "bg"


def test_a_clip_becomes_a_background(clips, same):
    found = Background.load(same / "background.h5")
    assert len(found) == 50 and found.names == ("same",) and found.media == ("same.mp4",) and found.rate == RATE
    drawn = next(read_frames(clips / "same.mp4"))
    assert np.abs(found.frame(0).astype(int) - drawn).mean() < 1.5
    truth = heads.record(50, seed=4, mouth=2).points
    assert np.abs(found.landmarks - truth).mean() < 0.5
    assert sorted(path.name for path in same.iterdir()) == ["background.h5", ABOUT]


def test_the_speaker_speaks_on_it(clips, same, tmp_path, capsys):
    bundle = SpeakerBundle.load(clips / "made")
    before = load_background(bundle, clips / "made", same)
    assert len(before.background) == 50 and before.trained is bundle.trained
    assert before.speaker.head is bundle.speaker.head  # frames of the same size, the same camera
    path = tmp_path / "out.mp4"
    given = ["--model", clips / "made", "--text", "Hello.", "-o", path, "--quiet"]
    assert told(capsys, "speak", *given, "--background", same) == (0, "")
    frames = list(read_frames(path))
    # Above the eyes the video shows the clip, not the speaker's own background.
    top = int(before.background.landmarks[0, 17:27, 1].min()) - 10
    assert np.abs(frames[0][:top].astype(int) - before.background.frame(0)[:top]).mean() < 3


def test_a_clip_of_another_size_has_a_camera_of_its_own(clips, tmp_path):
    prepared(clips, tmp_path / "bg", "large")
    bundle = SpeakerBundle.load(clips / "made")
    before = load_background(bundle, clips / "made", tmp_path / "bg")
    assert before.background.size == (720, 576)
    head = before.speaker.head
    assert head.focal == pytest.approx(2 * bundle.speaker.head.focal) and head.centre.tolist() == [360, 288]
    np.testing.assert_array_equal(head.points3d, bundle.speaker.head.points3d)
    # The same face at twice the size lies at the same distance.
    prepared(clips, tmp_path / "bg1", "same")
    small = Background.load(tmp_path / "bg1" / "background.h5")
    np.testing.assert_allclose(before.background.pose.translation, small.pose.translation, rtol=0.02, atol=2)
    assert head_in(bundle.speaker.head, heads.SIZE) is bundle.speaker.head


def test_several_clips_and_parts_of_them(clips, tmp_path):
    shutil.copy(clips / "same.mp4", tmp_path / "same.mp4")
    settings = LandmarkSettings(source="csv", folder=str(clips / "of"))
    videos = [clips / "same.mp4", tmp_path / "same.mp4"]
    found = prepare_background(tmp_path / "bg", clips / "made", videos, 0.4, 1.6, settings)
    assert found.names == ("same", "same-2") and len(found) == 60
    truth = heads.record(50, seed=4, mouth=2).points[10:40]
    assert np.abs(found.landmarks[:30] - truth).mean() < 0.5


@pytest.mark.parametrize(
    ("names", "status", "said"),
    [
        (["other"], 1, "other.mp4: the face is not this speaker's: its points lie"),
        (["short"], 1, "short.mp4: only 0.40 s of video. Give at least 1 s."),
        (["lost"], 1, "lost.mp4: no face in 20 of 50 frames; landmarks of lost.csv"),
        (["text"], 1, "text.mp4: "),
        (["unseen"], 1, "unseen.mp4: no landmark file"),
        (["same", "large"], 1, "large.mp4 has (720, 576) pixels at 25 Hz, the first background recording (360, 288)"),
        (["same", "fast"], 1, "fast.mp4 has (360, 288) pixels at 50 Hz"),
        (["nowhere"], 1, "nowhere.mp4: the file does not exist. Give the path of a video file."),
        (["same", "--start", "2", "--end", "1"], 2, "--start and --end: give seconds"),
        (["same", "--start", "nan"], 2, "--start and --end: give seconds"),
        (["same", "--start", "1.5"], 1, "same.mp4: only 0.50 s of video"),
        (["same", "--start", "90"], 1, "same.mp4: only 0.00 s of video"),
        (["same", "--landmarks", "nowhere"], 2, "--landmarks nowhere is no folder"),
        (["same", "--tracker", "drawn:Mine"], 2, "--landmarks and --tracker are both given"),
        (["same", "--model", "of"], 1, "of is no speaker: it holds no speaker.json"),
        (["same", "--model", "nowhere"], 2, "--model nowhere does not exist"),
        (["same", "-o", "made"], 2, "--output made is a folder that holds files; give a new or an empty one"),
        (["same", "-o", "made/bg"], 2, "--output made/bg is a part of the speaker made"),
        (["same", "-o", "text.mp4"], 2, "--output text.mp4 is not a folder"),
        (["same", "-o", "/proc/nowhere/bg"], 1, "cannot write /proc/nowhere/bg"),
        (["same", "-o", "x" * 256], 2, "has 256 bytes; give one of at most 255"),
    ],
)
def test_what_cannot_be_prepared_is_told_in_a_sentence(clips, capsys, monkeypatch, names, status, said):
    monkeypatch.chdir(clips)
    first = next((i for i, one in enumerate(names) if one.startswith("-")), len(names))
    videos = [f"{name}.mp4" for name in names[:first]]
    given = ["--model", "made", "--landmarks", "of", "-o", "new", "--quiet", *names[first:]]
    before = sorted(clips.iterdir())
    found, error = told(capsys, "background", "--video", *videos, *given)
    assert found == status and said in error, error
    assert error.startswith("visualspeech: ") and error.count("\n") == 1
    assert sorted(clips.iterdir()) == before


def test_without_landmarks_of_ones_own_the_tracker_looks_for_a_face(clips, tmp_path, capsys):
    synthetic.record(tmp_path / "patch.mp4", 2.0)
    status, error = told(
        capsys, "background", "--model", clips / "made", "--video", tmp_path / "patch.mp4", "-o", tmp_path / "bg"
    )
    assert status == 1 and "patch.mp4: no face in any frame" in error and not (tmp_path / "bg").exists()


def test_a_tracker_of_ones_own_gives_the_landmarks(clips, tmp_path, monkeypatch, capsys):
    np.save(tmp_path / "points.npy", heads.record(50, seed=4, mouth=2).points)
    (tmp_path / "drawn.py").write_text(
        "import numpy as np\nclass Mine:\n    def __init__(self, settings, video):\n"
        "        self.points = np.load('points.npy')\n"
        "    def next(self, frame, number):\n        return self.points[number]\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    given = ["background", "--model", clips / "made", "--video", clips / "unseen.mp4", "-o", "bg", "--quiet"]
    assert told(capsys, *given, "--tracker", "drawn:Mine") == (0, "")
    found = load_background(SpeakerBundle.load(clips / "made"), clips / "made", tmp_path / "bg").background
    assert np.abs(found.landmarks - np.load("points.npy")).mean() < 0.5
    for tracker, said in {
        "nowhere:Mine": "there is no module nowhere", "drawn:Yours": "the module drawn has no Yours", "a b": "tracker",
    }.items():  # fmt: skip
        status, error = told(capsys, *given[:-2], "other", "--quiet", "--tracker", tracker)
        assert status == 2 and said in error and error.count("\n") == 1
    assert not (tmp_path / "other").exists()


def test_a_program_speaks_before_it_too(clips, same):
    speaker = Speaker.load(clips / "made")
    assert speaker.before(same).say("Hello.").bundle.background.names == ("same",)
    one = speaker.bundle.background.names[0]
    assert speaker.before(one).bundle.background.names == (one,)
    with pytest.raises(SettingError, match=one):
        speaker.before("nobody")


def test_a_background_of_another_speaker_is_refused(clips, same, tmp_path):
    other = speakers.make(tmp_path / "other", seed=5)
    with pytest.raises(DataError, match="bg was prepared for another speaker than .*other"):
        load_background(SpeakerBundle.load(other), other, same)


def test_damaged_and_foreign_folders_are_refused(clips, same, tmp_path):
    bundle, model = SpeakerBundle.load(clips / "made"), clips / "made"
    with pytest.raises(StorageError, match="is no background: it holds no background.json. Give a folder that"):
        load_background(bundle, model, tmp_path)
    copy = shutil.copytree(same, tmp_path / "copy")
    about = json.loads((copy / ABOUT).read_text())
    for text, said in [
        ("{", "it is no JSON"),
        ("{}", "does not describe a background"),
        (json.dumps(about | {"version": 9}), "is a background of version 9"),
        (json.dumps(about | {"speaker": {}}), "`speaker` in its settings"),
        (json.dumps(about | {"module": "os"}), "module"),
        (json.dumps(about | {"background": "0" * 12}), "it was changed after it was prepared"),
    ]:
        (copy / ABOUT).write_text(text)
        with pytest.raises(StorageError, match=said):
            load_background(bundle, model, copy)
    # Somebody who makes the digest fit still gets nothing but frames and numbers that have been checked.
    (copy / "background.h5").write_bytes((model / FILES["aam"]).read_bytes())
    (copy / ABOUT).write_text(json.dumps(about | {"background": file_digest(copy / "background.h5")}))
    with pytest.raises(StorageError, match="cannot read .*background.h5"):
        load_background(bundle, model, copy)
    (copy / "background.h5").unlink()
    with pytest.raises(StorageError, match="lacks background.h5"):
        load_background(bundle, model, copy)


def test_a_recording_of_the_speaker_is_named(clips, tmp_path, capsys):
    given = ["speak", "--model", clips / "made", "--text", "Hello.", "-o", tmp_path / "a.mp4", "--quiet"]
    assert told(capsys, *given, "--background", "r1") == (0, "")
    status, error = told(capsys, *given, "--background", "r7")
    assert status == 2 and "the background has no recording r7; there are r0, r1" in error
    status, error = told(capsys, *given, "--background", tmp_path / "nowhere")
    assert status == 1 and "nowhere is no background" in error


def test_nothing_is_written_into_a_background(clips, same, capsys):
    before = sorted(same.iterdir())
    given = ["speak", "--model", clips / "made", "--text", "Hello.", "--background", same]
    for output in (["-o", same / "a.mp4"], ["--frames", same / "png"], ["--frames", same]):
        status, error = told(capsys, *given, *output)
        assert status == 2 and ("lies in the folder of --background" in error or "holds files" in error), error
    assert sorted(same.iterdir()) == before


def test_a_double_blink_is_told(clips, tmp_path, capsys):
    points = heads.record(50, seed=4, mouth=2).points
    for frame in (10, 14):
        middle = points[frame, 36:48, 1].mean()
        points[frame, 36:48, 1] = middle + 0.1 * (points[frame, 36:48, 1] - middle)
    add(tmp_path, "blinking", points)
    status, said = told(
        capsys, "background", "--model", clips / "made", "--video", tmp_path / "blinking.mp4", "--landmarks",
        tmp_path / "of", "-o", tmp_path / "bg",
    )  # fmt: skip
    assert status == 0 and "blinking.mp4: 1 double blink, which will be seen again and again" in said
    assert "bg holds 50 frames of 360 by 288 pixels at 25 Hz" in said
    assert probe(tmp_path / "blinking.mp4").rate == RATE


def test_a_background_that_is_stopped_leaves_nothing(clips, tmp_path):
    points = heads.record(1000, seed=4, mouth=2).points
    add(tmp_path, "long", points)
    before = sorted(tmp_path.iterdir())
    process = subprocess.Popen(
        [sys.executable, "-m", "visualspeech", "background", "--model", clips / "made", "--video",
         tmp_path / "long.mp4", "--landmarks", tmp_path / "of", "-o", tmp_path / "bg"],
        stderr=subprocess.PIPE, text=True, env={**os.environ},
    )  # fmt: skip
    while process.poll() is None and not list(tmp_path.glob(".partial.*")):
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=20)
    assert process.returncode == 128 + signal.SIGTERM and "Traceback" not in said
    assert sorted(tmp_path.iterdir()) == before
