"""Several systems, corpora and speakers in one run: one list of utterances, one split, nothing overwritten."""

import shutil

import numpy as np
import pytest
import yaml

from tests.workflow.running import TINY, of_system, overlay, planned_rules, snakemake
from visualspeech.models.registry import load_model
from visualspeech.storage.arrays import ArrayReader
from visualspeech.storage.tables import read_table

pytestmark = pytest.mark.xdist_group("workflow")

#: A second system by settings alone: other topologies and rows, another rate, one HMM, on the same coding.
SECOND = {
    "name": "second",
    "extends": "fan2015",
    "title": "Second",
    "rate": 50,
    "models": {
        "nets": {"letters": ["F"], "nodes": [8]},
        "nets_thirds": None,
        "articulate": None,
        "sound": None,
        "text_and_sound": None,
        "convolutions": {"like": "nets", "letters": ["CF"], "trajectory": "mlpg", "suffix": "mlpg"},
        "mix": {"family": "ensemble", "members": ["nets", "convolutions", "hmm_monophone"]},
        "articulated": {"family": "gv_compensation", "from": "mix"},
        "hmm_tied": None,
        "hmm_mge": None,
    },
    "tables": {"gains": {"references": []}},
    "videos": {"model": "articulated"},
    "sound_model": "",
}


SECOND_ROWS = ("F-8", "CF-8-mlpg", "hmm_monophone", "mix", "articulated")


@pytest.fixture(scope="module")
def two_systems(tiny_run, tmp_path_factory):
    """The finished tiny run with a second system beside the first."""
    files = overlay(tmp_path_factory.mktemp("second"), {"systems": ["fan2015", SECOND]})
    done = snakemake(tiny_run, "all", configfiles=files)
    assert done.returncode == 0, done.stdout[-4000:]
    yield tiny_run / "results" / "tiny", done.stdout, files
    shutil.rmtree(tiny_run / "results" / "tiny" / "second")
    restored = snakemake(tiny_run, "all")
    assert restored.returncode == 0, restored.stdout[-4000:]


def test_a_second_system_runs_beside_the_first_and_leaves_it_alone(two_systems):
    corpus, said, _ = two_systems
    assert (corpus / "second" / "tables" / "objective.tsv").is_file() and list((corpus / "second/videos").glob("*.mp4"))
    again = {line.split()[1].rstrip(":") for line in said.splitlines() if line.startswith("rule ")}
    assert not again & {"track_landmarks", "align_speech", "fit_aam", "normalise_pose", "accept_utterances"}
    assert "fan2015/models" not in "".join(line for line in said.splitlines() if "output:" in line)


def test_both_systems_stand_in_one_table_and_in_one_report(two_systems):
    corpus, _, _ = two_systems
    table = (corpus / "tables" / "systems.md").read_text()
    assert "Fan et al. 2015" in table and "Second" in table and "25 Hz" in table and "50 Hz" in table
    report = (corpus / "report.html").read_text()
    assert "Fan et al. 2015" in report and "Second" in report
    header = (corpus / "second" / "tables" / "objective.tsv").read_text()
    for fact in ("# corpus: tiny", "# system: second", "# rate: 50 Hz", "# seeds: 1", "# visual coding: aam51 ("):
        assert fact in header


def test_two_systems_share_utterances_and_split(two_systems):
    corpus, _, _ = two_systems
    lines = [(corpus / name / "tables" / "objective.tsv").read_text() for name in ("fan2015", "second")]
    splits = [next(line for line in text.splitlines() if line.startswith("# split")) for text in lines]
    assert splits[0] == splits[1]
    assert not list(corpus.glob("*/utterances.tsv")) and (corpus / "utterances.tsv").is_file()


def test_a_change_of_one_system_leaves_the_other_alone(two_systems, tiny_run, tmp_path):
    _, _, files = two_systems
    changed = tmp_path / "changed.yaml"
    changed.write_text(yaml.safe_dump(of_system("second", training={"dropout": 0.1})))
    done = snakemake(tiny_run, "--dry-run", "models", configfiles=(*files, changed))
    trained = {row for row in SECOND_ROWS if f"second/models/{row}/learning_curve.tsv" in done.stdout}
    # The networks, and the rows that are made of them; not the HMM that is a member beside them.
    assert trained == {"F-8", "CF-8-mlpg", "mix", "articulated"} and done.stdout.count("rule train_model:") == 4


def test_rows_that_are_made_of_others_are_rows_of_the_tables(two_systems):
    corpus, _, _ = two_systems
    lines = (corpus / "second" / "tables" / "objective.tsv").read_text().splitlines()
    assert set(SECOND_ROWS) < {line.split("\t")[0] for line in lines if not line.startswith("#")}
    with ArrayReader(corpus / "second/models/mix/predictions.h5") as mixed:
        found = {name: mixed.array(name, "appearance") for name in mixed.ids}
    for name, mean in found.items():
        members = []
        for row in SECOND_ROWS[:3]:
            with ArrayReader(corpus / f"second/models/{row}/predictions.h5") as one:
                members.append(one.array(name, "appearance"))
        np.testing.assert_allclose(mean, np.mean(members, axis=0, dtype=np.float64), rtol=1e-4, atol=1e-3)
    model = load_model(corpus / "second/models/articulated/model.safetensors")
    assert (list(model.blocks), model.rate) == (["tri_shares", "track"], 50.0)


def two_speakers(tiny_run, folder):
    """A folder of two people: the tiny corpus's recordings under two names."""
    for number, path in enumerate(sorted((tiny_run / "results/tiny/recordings").rglob("*.mp4"))):
        target = folder / "clips" / ("anna" if number % 2 else "ben")
        target.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target / path.name)
        shutil.copy(path.with_suffix(".txt"), target / path.with_suffix(".txt").name)
    return {"name": "two", "adapter": "folder", "root": str(folder / "clips"), "consent": "Nobody's face."}


def test_a_corpus_of_several_speakers_has_a_head_for_each(tiny_run, tmp_path):
    corpus = two_speakers(tiny_run, tmp_path)
    files = overlay(tmp_path, {"corpora": [corpus]}, of_system(needs=["video", "text"]))
    done = snakemake(tmp_path, "pose", configfiles=files)
    assert done.returncode == 0, done.stdout[-4000:]
    heads = sorted(path.name for path in (tmp_path / "results/two/heads").iterdir())
    assert heads == ["anna.safetensors", "ben.safetensors"]
    accepted = read_table(tmp_path / "results/two/utterances.tsv", ("id", "speaker", "split"))
    assert len(accepted) >= 10
    assert all({"train", "validation", "test"} == set(rows["split"]) for _, rows in accepted.groupby("speaker"))


def test_a_system_that_needs_one_speaker_is_refused_on_two_unless_one_is_selected(tiny_run, tmp_path):
    corpus = two_speakers(tiny_run, tmp_path)
    files = overlay(tmp_path, {"corpora": [corpus]})
    done = snakemake(tmp_path, "all", configfiles=files)
    assert done.returncode != 0 and "rule " not in done.stdout and "Traceback" not in done.stdout
    assert "fan2015 is skipped on two: it needs recordings of one speaker" in done.stdout
    one = overlay(tmp_path, {"corpora": [corpus | {"speaker": "anna"}]})
    assert "train_model" in planned_rules(tmp_path, "all", configfiles=one)


def test_several_corpora_in_one_run_and_a_skipped_pair_is_reported(tiny_run, tmp_path):
    other = yaml.safe_load(TINY.read_text())["corpora"][0] | {"name": "other", "utterances": 11}
    pair = two_speakers(tiny_run, tmp_path)
    files = overlay(tmp_path, {"corpora": [other, pair]})
    done = snakemake(tmp_path, "--dry-run", "all", configfiles=files)
    assert done.returncode == 0, done.stdout[-3000:]
    assert "results/other/report.html" in done.stdout and "results/two" not in done.stdout
    assert "fan2015 is skipped on two" in done.stdout
