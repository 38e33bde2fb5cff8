"""A recording that fails after it was tracked costs that utterance, in the codings that read it again."""

import os

import pytest

from tests.workflow.running import snakemake, tables
from visualspeech.storage.tables import read_table

pytestmark = pytest.mark.xdist_group("workflow")

CODING = "results/tiny/codings/aam51"


def ids(path):
    return set(read_table(path, ("id",))["id"])


def test_a_recording_that_vanishes_after_tracking_is_left_out_of_the_coding(tiny_run):
    before = tables(tiny_run)
    accepted = read_table(tiny_run / "results/tiny/utterances.tsv", ("id", "media", "split"))
    lost = accepted[accepted["split"] == "train"].iloc[0]
    path = tiny_run / lost["media"]
    content, times = path.read_bytes(), (path.stat().st_atime_ns, path.stat().st_mtime_ns)
    model = tiny_run / CODING / "model.safetensors"
    try:
        path.write_bytes(b"no video any more")
        forced = ["--forcerun", "sample_textures", "--rerun-triggers", "mtime"]
        done = snakemake(tiny_run, "results/tiny/tables/systems.tsv", str(model.relative_to(tiny_run)), *forced)
        assert done.returncode == 0, done.stdout[-4000:]
        assert "Traceback" not in done.stdout
        assert ids(tiny_run / CODING / "utterances.tsv") == set(accepted["id"]) - {lost["id"]}
        (finding,) = read_table(tiny_run / CODING / "findings.tsv", ("id", "stage", "finding")).itertuples()
        assert (finding.id, finding.stage) == (lost["id"], "textures") and "unreadable" in finding.finding
    finally:
        path.write_bytes(content)
        os.utime(path, ns=times)
        done = snakemake(tiny_run, "all", "--forcerun", "sample_textures")
    assert done.returncode == 0, done.stdout[-4000:]
    assert ids(tiny_run / CODING / "utterances.tsv") == set(accepted["id"])
    assert tables(tiny_run) == before


def test_a_recording_that_vanishes_before_the_videos_costs_its_video(tiny_run):
    accepted = read_table(tiny_run / "results/tiny/utterances.tsv", ("id", "media", "split"))
    videos = tiny_run / "results/tiny/fan2015/videos"
    shown = {path.stem for path in videos.glob("*.mp4")}
    lost = accepted[accepted["id"].isin(shown)].iloc[0]
    path = tiny_run / lost["media"]
    content, times = path.read_bytes(), (path.stat().st_atime_ns, path.stat().st_mtime_ns)
    render = (str(videos.relative_to(tiny_run)), "--forcerun", "render_videos", "--rerun-triggers", "mtime")
    try:
        path.write_bytes(b"no video any more")
        done = snakemake(tiny_run, *render)
        assert done.returncode == 0, done.stdout[-4000:]
        assert f"no video of {lost['id']}" in done.stdout and "unreadable" in done.stdout
        assert {path.stem for path in videos.glob("*.mp4")} == shown - {lost["id"]}
    finally:
        path.write_bytes(content)
        os.utime(path, ns=times)
        done = snakemake(tiny_run, *render)
    assert done.returncode == 0, done.stdout[-4000:]
    assert {path.stem for path in videos.glob("*.mp4")} == shown
