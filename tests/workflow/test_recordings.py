"""Recordings of users, through the command line: any file name, and which jobs a changed recording runs again."""

import os
import shutil

import pytest
import yaml

from tests import synthetic
from tests.workflow.running import snakemake
from visualspeech.corpora.findings import read_findings
from visualspeech.storage.arrays import ArrayReader

pytestmark = pytest.mark.xdist_group("workflow")

NAMES = ["br{ace}s", "{shard}", "a b", "ünï", "x'y\"", "-dash", "~tilde", "100%", "a*b?", "[x]", "new\nline",
         "tab\there", "s3:/mine/in", "http:/mine/{x}", "back\\slash", "你好", "再见", "$(touch pwned)", "`id`", "a;b",
         "#x", os.fsdecode(b"lat\xe9"), "carriage\rreturn"]  # fmt: skip
CHECKS = [f"results/mine/check/{shard}.tsv" for shard in (0, 1)]


def corpus(folder, names=NAMES, **changes):
    """Recordings with odd names, in a folder with an odd name, each a good one; the overlay that selects them."""
    root = folder / "clips {shard}"
    source = synthetic.record(folder / "source.mp4", 1.0)
    for name in names:
        path = root / f"{name}.mp4"
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, path)
        path.with_suffix(".txt").write_text("bin {blue} at f two now")
    one = {"name": "mine", "adapter": "folder", "root": str(root), "consent": "Nobody's face.", **changes}
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump({"corpora": [one], "shards": 2, "max_rejected_share": 1}))
    return root, path


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Working folder, root and overlay of a corpus of which the recordings are checked."""
    folder = tmp_path_factory.mktemp("names")
    root, path = corpus(folder)
    done = snakemake(folder, *CHECKS, configfiles=(path,))
    assert done.returncode == 0 and "Traceback" not in done.stdout, done.stdout[-4000:]
    return folder, root, path


def planned(folder, path, *targets):
    """Rule and shard of each job that a dry run would run, from the paths of the output."""
    done = snakemake(folder, "--dry-run", *(targets or CHECKS), configfiles=(path,))
    assert done.returncode == 0, done.stdout
    outputs = [line for line in done.stdout.splitlines() if line.startswith("    output: ")]
    return {(line.split("/")[2], line.split("/")[3][0]) for line in outputs}


def test_recordings_with_any_name_are_planned_and_checked(checked):
    folder, _, path = checked
    findings = read_findings(*(folder / check for check in CHECKS))
    assert (
        sorted(one.finding for one in findings if one.level == "reject")
        == ["its file name is not UTF-8 text, or holds a carriage return"] * 2
    )
    sounds = 0
    for shard in (0, 1):
        with ArrayReader(folder / f"results/mine/audio/{shard}.h5") as audio:
            sounds += len(audio.ids)
    assert sounds == len(NAMES) - 2
    assert not list(folder.rglob("pwned"))
    done = snakemake(folder, "--dry-run", "all", configfiles=(path,))
    assert done.returncode == 0 and "render_videos" in done.stdout


def test_nothing_is_checked_again_where_nothing_changed(checked):
    folder, _, path = checked
    assert planned(folder, path) == set()


def of_name(name, shards=2):
    from visualspeech.corpora.records import legal_id, shard_of

    return str(shard_of(legal_id(name), shards))


def test_a_recording_that_is_replaced_by_an_older_one_deleted_or_restored_runs_its_shard_again(checked):
    folder, root, path = checked
    recording, kept = root / "br{ace}s.mp4", folder / "kept.mp4"
    again = {("check", of_name("br{ace}s"))}
    shutil.copy2(recording, kept)
    os.utime(recording, ns=(0, kept.stat().st_mtime_ns - 10**15))
    assert planned(folder, path) == again
    recording.unlink()
    recording.symlink_to(folder / "gone.mp4")
    assert planned(folder, path) == again
    assert snakemake(folder, *CHECKS, configfiles=(path,)).returncode == 0
    findings = {one.file: one.finding for one in read_findings(*(folder / check for check in CHECKS))}
    assert "does not exist" in findings[str(recording)]
    recording.unlink()
    shutil.copy2(kept, recording)
    assert planned(folder, path) == again
    assert snakemake(folder, *CHECKS, configfiles=(path,)).returncode == 0
    assert planned(folder, path) == set()


def test_a_changed_transcript_runs_its_shard_again(checked):
    folder, root, path = checked
    text = root / "100%.txt"
    before = text.read_text()
    text.write_text("another one")
    assert planned(folder, path) == {("corpus", "u"), ("check", of_name("100%"))}
    text.write_text(before)
    assert planned(folder, path) == set()


def test_with_change_detection_by_content_a_touched_recording_runs_nothing(tmp_path):
    root, path = corpus(tmp_path, NAMES[:4], change_detection="content")
    assert snakemake(tmp_path, *CHECKS, configfiles=(path,)).returncode == 0
    for recording in root.rglob("*.mp4"):
        os.utime(recording)
    assert planned(tmp_path, path) == set()
    recording = root / "a b.mp4"
    status = recording.stat()
    recording.write_bytes(recording.read_bytes()[:-1] + b"!")
    os.utime(recording, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert planned(tmp_path, path) == {("check", of_name("a b"))}
