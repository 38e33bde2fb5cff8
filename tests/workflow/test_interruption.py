"""A run killed at any point ends after the same command in the same tables, with any number of cores."""

import os
import shutil
import signal
import subprocess
import time

import pytest

from tests import kills
from tests.workflow.running import command, snakemake, tables

pytestmark = pytest.mark.xdist_group("workflow")

#: The run is killed when a file that matches appears: early, in the middle of the shards, in training, at the end.
MOMENTS = [
    "recordings",
    "landmarks/*.h5",
    "codings/aam51/model.safetensors",
    "fan2015/models/FB-16/checkpoint.safetensors",
]


def kill_whole_run_when(folder, pattern):
    run = subprocess.Popen(
        command(folder, "all", cores=2), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )
    corpus = folder / "results" / "tiny"
    while run.poll() is None and not list(corpus.glob(pattern)):
        time.sleep(0.05)
    killed = run.poll() is None
    if killed:
        os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    return killed


def test_killed_runs_end_in_the_same_tables(tiny_run, tmp_path):
    kills = [kill_whole_run_when(tmp_path, moment) for moment in MOMENTS]
    assert sum(kills) >= 3, f"only {sum(kills)} of {len(MOMENTS)} kills came in time"
    done = snakemake(tmp_path, "all", cores=1)
    assert done.returncode == 0, done.stdout[-4000:]
    assert tables(tmp_path) == tables(tiny_run)
    assert list((tmp_path / "results").rglob(".partial.*")) == []
    assert not (tmp_path / "results/tiny/fan2015/models/FB-16/checkpoint.safetensors").exists()


def test_random_kills_end_in_the_same_files(tiny_run, tmp_path):
    """A short campaign of ``python -m tests.kills``: groups, Snakemake alone, single jobs."""
    figures = kills.campaign(tmp_path / "work", tiny_run, kills=5, seed=2, minutes=10)
    assert figures.faults == []
    assert sum(figures.kills.values()) >= 5


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_jobs_end_with_snakemake_and_the_next_run_resumes(tiny_run, tmp_path, number):
    """As the out-of-memory killer does it, and Ctrl-C."""
    folder = tmp_path / "work"
    shutil.copytree(tiny_run, folder, symlinks=True)
    for name in ("landmarks", "pose", "codings", "fan2015", "tables", "utterances.tsv", "report.html"):
        path = folder / kills.CORPUS / name
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    run = kills.start(folder)
    while run.poll() is None and "track_landmarks" not in kills.jobs(run).values():
        time.sleep(0.02)
    time.sleep(1)
    assert kills.jobs(run)
    os.kill(run.pid, number) if number == signal.SIGKILL else os.killpg(run.pid, number)
    run.wait(60)
    figures = kills.Figures()
    kills.wait_for_jobs(run, figures)
    assert figures.faults == []
    shown = (folder / "output.txt").read_text()
    assert "run the same command again to resume" in shown and "Traceback" not in shown
    assert list((folder / "results").rglob(".partial.*")) == []
    done = snakemake(folder, "pose")
    assert done.returncode == 0, done.stdout[-4000:]
    for path in sorted((tiny_run / kills.CORPUS / "pose").glob("*.h5")):
        assert (folder / kills.CORPUS / "pose" / path.name).read_bytes() == path.read_bytes()


def test_two_runs_at_once_do_not_share_a_corpus(tmp_path):
    from visualspeech.errors import StorageError
    from visualspeech.locks import hold

    held = hold(tmp_path / "results" / "tiny")
    with pytest.raises(StorageError, match="another run"):
        hold(tmp_path / "results" / "tiny")
    done = snakemake(tmp_path, "alignment")
    assert done.returncode != 0
    assert "another run is using" in done.stdout and "Traceback" not in done.stdout
    assert not (tmp_path / "results" / "tiny" / "corpus").exists()
    hold(tmp_path / "results" / "other").close()  # another corpus is another folder
    held.close()
    hold(tmp_path / "results" / "tiny").close()
