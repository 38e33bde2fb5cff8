"""A corpus without any transcript: a system driven by sound runs on it, from the recordings to a video of a new one."""

import shutil
import subprocess
import sys

import pytest
import yaml

from tests.workflow.running import TINY, planned_rules, snakemake
from visualspeech.corpora.findings import read_findings
from visualspeech.media.reading import probe
from visualspeech.speech.alignment import read_alignments
from visualspeech.storage.tables import read_table

pytestmark = pytest.mark.xdist_group("workflow")

RESULTS = "results/untold"


@pytest.fixture(scope="module")
def untold(tiny_run, tmp_path_factory):
    """Working folder and overlay of a finished run on the recordings of the tiny run, without their transcripts."""
    folder = tmp_path_factory.mktemp("untold")
    (folder / "clips").mkdir()
    for video in (tiny_run / "results/tiny/recordings").rglob("*.mp4"):
        shutil.copy(video, folder / "clips")
    small = yaml.safe_load(TINY.read_text())["override"]["codings"]
    models = {"sound": {"letters": ["FB"], "nodes": [16]}}
    system = {"models": models, "training": {"max_epochs": 4}, "videos": {"model": "FB-16", "count": 1}}
    settings = {
        "corpora": [
            {"name": "untold", "adapter": "folder", "root": str(folder / "clips"), "consent": "Nobody's face."}
        ],
        "systems": ["sound_driven"],
        "shards": 2,
        "split": {"train": 0.6, "validation": 0.2, "test": 0.2},
        "override": {"codings": small, "systems": {"sound_driven": system}},
    }
    path = folder / "untold.yaml"
    path.write_text(yaml.safe_dump(settings))
    done = snakemake(folder, "all", "speaker", configfiles=(path,))
    assert done.returncode == 0, done.stdout[-6000:]
    return folder, path


def test_it_runs_to_its_report(untold):
    folder, path = untold
    results = folder / RESULTS
    assert not [one for one in read_findings(results / "findings.tsv") if "transcript" in one.finding]
    assert len(read_table(results / "utterances.tsv", ("id",))) == 12
    tables = [one for shard in (0, 1) for one in read_alignments(results / f"alignment/{shard}.tsv").values()]
    assert {phone.label for one in tables for phone in one.phones} == {"sil", "spn"}
    assert "FB-16" in (results / "sound_driven/tables/objective.md").read_text()
    assert (results / "report.html").is_file() and list((results / "sound_driven/videos").glob("*.mp4"))
    assert "Nothing to be done" in snakemake(folder, "all", "speaker", configfiles=(path,)).stdout


def test_its_speaker_is_driven_by_recordings_and_by_the_voice(untold, tmp_path):
    folder, _ = untold
    model, clip = folder / RESULTS / "sound_driven/speakers/FB-16", next((folder / "clips").glob("*.mp4"))
    for given in (["--audio", clip], ["--text", "A happy map."]):
        command = [sys.executable, "-m", "visualspeech", "speak", "--model", model, *given, "-o", tmp_path / "a.mp4"]
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert probe(tmp_path / "a.mp4").duration > 1


def test_a_system_that_needs_text_is_skipped_there(untold):
    folder, path = untold
    both = folder / "both.yaml"
    both.write_text(yaml.safe_dump({**yaml.safe_load(path.read_text()), "systems": ["sound_driven", "fan2015"]}))
    done = snakemake(folder, "--dry-run", "all", configfiles=(both,))
    assert done.returncode == 0 and "fan2015 is skipped on untold: it needs transcripts" in done.stdout


def test_labels_are_not_computed_again_where_sound_is_read(tiny_run, tmp_path):
    """Sound is an input of the blocks that read it, and of no other."""
    done = snakemake(tiny_run, "--dry-run", "results/tiny/report.html", "--forcerun", "encode_block")
    assert done.returncode == 0, done.stdout
    blocks = {}
    for part in done.stdout.split("rule encode_block:")[1:]:
        inputs, outputs = (next(line for line in part.splitlines() if f"{key}put:" in line) for key in ("in", "out"))
        blocks[outputs.split("/features/")[1].split("/")[0]] = ("/audio/" in inputs, "/alignment/" in inputs)
    labels = dict.fromkeys(("tri", "tri_shares", "tri_thirds", "track"), (False, True))
    assert blocks == {**labels, "mel": (True, False)}
    assert "encode_block" not in planned_rules(tiny_run, "all")
