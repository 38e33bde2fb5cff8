"""No model learns from test utterances: whatever their recordings hold, every model stays the same to the last byte."""

import shutil

import numpy as np
import pytest

from tests import synthetic
from tests.workflow.running import snakemake
from visualspeech.media.reading import probe, read_audio, read_frames
from visualspeech.provenance import file_digest
from visualspeech.storage.tables import read_table

pytestmark = pytest.mark.xdist_group("workflow")

RESULTS = "results/tiny"


def poison(path):
    """Another recording in place of one: its pictures mirrored and darker, its sound softer and in noise."""
    frames = [np.ascontiguousarray(frame[:, ::-1] * 0.7).astype(np.uint8) for frame in read_frames(path)]
    audio, rate = read_audio(path, 16_000), probe(path).rate
    noise = 0.002 * np.random.default_rng(1).normal(size=len(audio))
    synthetic.record(path, frames=frames, audio=(0.5 * audio + noise).astype(np.float32), rate=rate)


def models(folder):
    """Digests of all that is learned: heads, reference, appearance model, input blocks, phones, models."""
    found = [*(folder / RESULTS).rglob("*.safetensors"), folder / RESULTS / "phones.tsv"]
    return {str(path.relative_to(folder)): file_digest(path) for path in found}


def test_models_do_not_change_with_the_test_recordings(tiny_run, tmp_path):
    shutil.copytree(tiny_run / "results", tmp_path / "results", symlinks=True)
    shutil.copytree(tiny_run / ".snakemake", tmp_path / ".snakemake", symlinks=True)
    accepted = read_table(tmp_path / RESULTS / "utterances.tsv", ("id", "media", "split"))
    before, predictions = models(tmp_path), f"{RESULTS}/fan2015/models/FB-16/statistics.tsv"
    figures = (tmp_path / predictions).read_bytes()
    poisoned = accepted[accepted["split"] == "test"]["media"]
    assert len(poisoned)
    for media in poisoned:
        poison(tmp_path / media)
    # Everything is made again from the recordings on; by time stamps alone, `record_demo` would restore them.
    stages = ["check_recordings", "align_speech", "track_landmarks"]
    done = snakemake(tmp_path, "all", "--forcerun", *stages, "--rerun-triggers", "mtime")
    assert done.returncode == 0, done.stdout[-6000:]
    again = read_table(tmp_path / RESULTS / "utterances.tsv", ("id", "media", "split"))
    assert list(again["id"]) == list(accepted["id"])
    assert models(tmp_path) == before
    assert len([name for name in before if name.endswith("model.safetensors")]) > 5
    # The poison has worked: the figures of the test utterances are others.
    assert (tmp_path / predictions).read_bytes() != figures
