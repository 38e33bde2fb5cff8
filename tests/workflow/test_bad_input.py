"""Bad recordings and bad settings, through the command line: a sentence each, the corpus goes on, no traceback."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests import synthetic
from tests.paths import REPOSITORY
from tests.workflow.running import TINY, command, of_coding, of_system, snakemake
from visualspeech.media.reading import read_audio, read_frames
from visualspeech.storage.tables import read_table

pytestmark = pytest.mark.xdist_group("workflow")

GOOD = 9


def frames_of(path, count=None):
    return list(read_frames(path))[:count]


def remake(source, target, frames=None, audio=None, **options):
    """A recording like ``source`` with other pictures or sound."""
    frames = frames_of(source) if frames is None else frames
    audio = read_audio(source, 16_000) if audio is None else audio
    synthetic.record(target, frames=frames, audio=audio, **options)


def two_faces(frame):
    """The same speaker a second time, smaller, in front of a wider background."""
    import cv2

    height, width = frame.shape[:2]
    small = cv2.resize(frame, (width * 3 // 4, height * 3 // 4))
    wide = np.full((height, width + small.shape[1], 3), 90, np.uint8)
    wide[:, :width] = frame
    wide[-small.shape[0] :, width:] = small
    return wide[:, : wide.shape[1] // 2 * 2]


def covered(frames, first, last):
    """Frames in which the face is hidden behind grey paper."""
    return [np.full_like(frame, 128) if first <= i < last else frame for i, frame in enumerate(frames)]


@pytest.fixture(scope="module")
def recordings(tiny_run):
    """The good recordings of the tiny corpus: (path, transcript), sorted."""
    found = sorted((tiny_run / "results" / "tiny" / "recordings").rglob("*.mp4"))
    return [(path, path.with_suffix(".txt").read_text()) for path in found]


@pytest.fixture(scope="module")
def findings(recordings, tmp_path_factory):
    """Findings of one run over a folder of good recordings and every kind of bad one: id -> (level, sentences)."""
    folder = tmp_path_factory.mktemp("bad")
    root = folder / "clips"
    root.mkdir()

    def add(name, source, transcript=None, suffix=".mp4"):
        path, said = source
        target = root / f"{name}{suffix}"
        if transcript is not False:
            target.with_suffix(".txt").write_text(said if transcript is None else transcript)
        return path, target

    for number, source in enumerate(recordings[:GOOD]):
        shutil.copy(*add(f"good{number}", source))
    spare = recordings[GOOD:]
    path, target = add("truncated", spare[0])
    shutil.copy(path, target)
    synthetic.truncated(target)
    add("empty", spare[0])[1].touch()
    add("nonsense", spare[0])[1].write_bytes(b"this is no video" * 100)
    path, target = add("mute", spare[0])
    synthetic.record(target, frames=frames_of(path), audio=np.zeros(0))
    path, target = add("silence", spare[0])
    remake(path, target, audio=np.zeros_like(read_audio(path, 16_000)))
    path, target = add("tone", spare[0])
    length = len(read_audio(path, 16_000))
    remake(path, target, audio=0.3 * np.sin(2 * np.pi * 440 * np.arange(length) / 16_000).astype(np.float32))
    path, target = add("othersentence", spare[0], spare[1][1] + " " + spare[2][1])
    shutil.copy(path, target)
    path, target = add("emptytext", spare[0], "")
    shutil.copy(path, target)
    path, target = add("notext", spare[0], False)
    shutil.copy(path, target)
    path, target = add("covered", spare[0])
    remake(path, target, frames=covered(frames_of(path), 0, 10_000))
    # Moving pictures of a face that no detector of upright faces finds.
    path, target = add("noface", spare[0])
    remake(path, target, frames=[np.ascontiguousarray(frame[::-1]) for frame in frames_of(path)])
    path, target = add("hidden", spare[1])
    remake(path, target, frames=covered(frames_of(path), 20, 24))
    path, target = add("twofaces", spare[1])
    remake(path, target, frames=[two_faces(frame) for frame in frames_of(path)])
    path, target = add("variable", spare[1])
    frames = frames_of(path)
    times = np.arange(len(frames)) / 25 + 0.012 * np.sin(np.arange(len(frames)))
    remake(path, target, frames=frames, times=list(times - times[0]))
    path, target = add("telephone", spare[2])
    remake(path, target, audio=read_audio(path, 8000), audio_rate=8000)
    corpus = {"name": "bad", "adapter": "folder", "root": str(root), "consent": "Nobody's face."}
    overlay = folder / "bad.yaml"
    overlay.write_text(yaml.safe_dump({"corpora": [corpus], "max_rejected_share": 0.9, "shards": 2}))
    done = snakemake(folder, "pose", configfiles=(overlay,))
    assert done.returncode == 0, done.stdout[-6000:]
    assert "Traceback" not in done.stdout
    result: dict[str, list[tuple[str, str, str]]] = {}
    table = read_table(
        folder / "results" / "bad" / "findings.tsv", ("id", "stage", "level", "file", "finding", "remedy")
    )
    for row in table.itertuples():
        result.setdefault(row.id, []).append((row.level, row.finding, row.remedy))
    result["accepted"] = set(read_table(folder / "results" / "bad" / "utterances.tsv")["id"])
    return result


REJECTED = {
    "truncated": "truncated|unreadable",
    "empty": "unreadable|empty|no bytes",
    "nonsense": "unreadable",
    "mute": "no audio stream",
    "silence": "silent audio",
    "tone": "without speech",
    "othersentence": "transcript|words",
    "emptytext": "empty",
    "notext": "no transcript",
    "covered": "single colour|frozen",
    "noface": "no face",
}
WARNED = {"variable": "variable frame rate", "telephone": "8 kHz"}


@pytest.mark.parametrize("name", REJECTED)
def test_unusable_recordings_are_rejected_with_reason_and_remedy(name, findings):
    rejections = [(finding, remedy) for level, finding, remedy in findings[name] if level == "reject"]
    assert rejections and name not in findings["accepted"]
    finding, remedy = rejections[0]
    assert any(word in finding for word in REJECTED[name].split("|")), finding
    assert len(remedy) > 10


@pytest.mark.parametrize("name", WARNED)
def test_odd_recordings_are_used_and_reported(name, findings):
    assert name in findings["accepted"]
    assert any(level == "warn" and WARNED[name] in finding for level, finding, _ in findings[name])


def test_frames_without_a_face_are_reported(findings):
    assert findings["hidden"]


def test_two_faces_are_reported(findings):
    assert any("faces in one frame" in finding for _, finding, _ in findings["twofaces"]), findings["twofaces"]


def test_the_corpus_goes_on_with_the_good_recordings(findings):
    assert {f"good{number}" for number in range(GOOD)} <= findings["accepted"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (of_coding(aam={"shap": {"energy": 0.9}}), "unknown setting `codings.aam51.aam.shap`. Did you mean `shape`?"),
        ({"corpora": [{"name": "x", "adapter": "folder", "root": "/nowhere/at/all"}]}, "/nowhere/at/all"),
        ({"corpora": [{"name": "x", "adapter": "folder"}]}, "root"),
        ({"corpora": ["griid"]}, "Did you mean `grid`?"),
        ({"systems": ["fan2051"]}, "`systems.0: fan2051` is not known. Did you mean `fan2015"),
        ({"shards": 0}, "`shards: 0`"),
        (of_system(models={"nets": {"letters": ["FXB"]}}), "FXB"),
        (
            of_coding(aam={"shape": {"components": 93}}),
            "`codings.aam51.aam.shape.components: 93` is more than there can be",
        ),
        (of_coding(aam={"texture": {"components": 300}}), "300 images give 299 at most"),
        (of_system(trajectories={"models": ["FB-16", "FB-17"]}), "trajectories.models.1: FB-17` is no model of"),
        ({"speak": {"model": "FB-17"}}, "`speak.model: FB-17` is no model of fan2015. Did you mean `FB-16`?"),
        ({"speak": {"sentences": ["Fine.", "?!"]}}, "no word to pronounce in '?!', text 2 of speak.sentences"),
        ({"speak": {"file": "nowhere.txt"}}, "cannot read the sentences of nowhere.txt: No such file"),
        ({"speak": {"background": ["nobody"]}}, "`speak.background: nobody` is no utterance of the corpus"),
        ({"speak": {"voice": {"voice": "martian"}}}, "eSpeak NG has no voice 'martian'; give an English one"),
    ],
)
def test_bad_settings_fail_before_any_job(settings, said, tmp_path):
    overlay = tmp_path / "bad.yaml"
    overlay.write_text(yaml.safe_dump(settings))
    done = snakemake(tmp_path, "all", configfiles=(TINY, overlay))
    assert done.returncode != 0
    assert said in done.stdout
    assert "Traceback" not in done.stdout and "rule " not in done.stdout


def test_two_utterances_with_one_id_fail_before_any_job(tmp_path):
    for folder in ("a", "b"):
        (tmp_path / "clips" / folder).mkdir(parents=True)
    rows = ["file\ttranscript\tid", "a/one.mp4\thello\tsame", "b/one.mp4\thello\tsame"]
    for folder in ("a", "b"):
        (tmp_path / "clips" / folder / "one.mp4").write_bytes(b"x")
    (tmp_path / "clips" / "table.tsv").write_text("\n".join(rows) + "\n")
    corpus = {"name": "x", "adapter": "folder", "root": str(tmp_path / "clips"), "table": "table.tsv"}
    (tmp_path / "x.yaml").write_text(yaml.safe_dump({"corpora": [corpus]}))
    done = snakemake(tmp_path, "all", configfiles=(tmp_path / "x.yaml",))
    assert done.returncode != 0 and "two utterances have one id" in done.stdout and "Traceback" not in done.stdout


def test_too_many_rejected_utterances_stop_the_run(tmp_path):
    (tmp_path / "clips").mkdir()
    for number in range(4):
        (tmp_path / "clips" / f"{number}.mp4").write_bytes(b"no video")
        (tmp_path / "clips" / f"{number}.txt").write_text("hello there")
    corpus = {"name": "x", "adapter": "folder", "root": str(tmp_path / "clips"), "consent": "none"}
    (tmp_path / "x.yaml").write_text(yaml.safe_dump({"corpora": [corpus]}))
    done = snakemake(tmp_path, "all", configfiles=(tmp_path / "x.yaml",))
    assert done.returncode != 0
    assert "4 of 4 utterances cannot be used" in done.stdout and "Traceback" not in done.stdout
    assert "rule align_speech" not in done.stdout


def test_a_read_only_results_folder_is_a_sentence(tmp_path):
    if os.geteuid():
        (tmp_path / "results").mkdir(mode=0o555)
    else:
        # Root may write into any folder but into those that the kernel makes up.
        (tmp_path / "results").symlink_to("/sys")
    done = snakemake(tmp_path, "all")
    assert done.returncode != 0
    assert "cannot write to the results folder" in done.stdout, done.stdout
    assert "Permission denied" in done.stdout or "Operation not permitted" in done.stdout  # by the kind of folder
    assert "Traceback" not in done.stdout and "rule " not in done.stdout


def test_a_full_disk_is_a_sentence(tmp_path):
    """A limit on the size of files stands for the disk: writing past it fails in the same way."""
    limited = f"ulimit -f 40; trap '' XFSZ; exec {' '.join(map(str, command(tmp_path, 'alignment')))}"
    done = subprocess.run(["bash", "-c", limited], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    assert done.returncode != 0
    assert "cannot write" in done.stdout and "disk is not full" in done.stdout, done.stdout[-3000:]
    assert "Traceback" not in done.stdout
    left = [path for path in Path(tmp_path, "results").rglob("*.mp4") if "partial" not in str(path)]
    assert left == []


def test_the_repository_has_no_unsafe_reader():
    unsafe = ("import pickle", "torch.load(", "allow_pickle=True", "shell=True", "yaml.load(")
    sources = [
        path
        for folder in ("visualspeech", "workflow")
        for path in (REPOSITORY / folder).rglob("*")
        if path.suffix in (".py", ".smk")
    ]
    assert {path.suffix for path in sources} >= {".py", ".smk"}
    for path in [REPOSITORY / "Snakefile", *sources]:
        text = path.read_text()
        assert not [word for word in unsafe if word in text], path
