"""A corpus whose alignment is made elsewhere: TextGrids in a folder, without any transcript."""

import shutil

import pytest
import yaml

from tests.workflow.running import planned_rules, snakemake
from visualspeech.corpora.findings import read_findings
from visualspeech.speech.alignment import read_alignments

pytestmark = pytest.mark.xdist_group("workflow")


def aligned(results, shards=(0, 1)):
    """All alignments below the results of a corpus."""
    tables = (read_alignments(results / f"alignment/{shard}.tsv") for shard in shards)
    return {name: one for table in tables for name, one in table.items()}


@pytest.fixture(scope="module")
def mine(tiny_run, tmp_path_factory):
    """Working folder with the recordings and exported TextGrids of the tiny run, and the settings of a run on them."""
    folder = tmp_path_factory.mktemp("mine")
    for video in (tiny_run / "results/tiny/recordings").rglob("*.mp4"):
        (folder / "clips/sub").mkdir(parents=True, exist_ok=True)
        shutil.copy(video, folder / "clips/sub")
    shutil.copytree(tiny_run / "results/tiny/alignment/textgrid", folder / "aligned/sub")
    return folder, {
        "corpora": [{
            "name": "mine", "adapter": "folder", "root": str(folder / "clips"), "consent": "Nobody's face.",
            "alignment": {"source": "textgrid", "folder": str(folder / "aligned"), "states": "tier"},
        }],
        "systems": ["fan2015"], "shards": 2, "split": {"train": 0.6, "validation": 0.2, "test": 0.2},
    }  # fmt: skip


def written(folder, settings, /, **alignment):
    """The overlay of a run, with other settings of the alignment."""
    corpus = settings["corpora"][0]
    changed = {**settings, "corpora": [{**corpus, "alignment": {**corpus["alignment"], **alignment}}]}
    path = folder / "mine.yaml"
    path.write_text(yaml.safe_dump(changed))
    return (path,)


def test_the_exported_files_are_the_alignment(mine, tiny_run):
    folder, settings = mine
    names = sorted(path.stem for path in (folder / "aligned").rglob("*.TextGrid"))
    missing, wrong = (folder / f"aligned/sub/{name}.TextGrid" for name in names[:2])
    missing.unlink()
    text = wrong.read_text(encoding="utf-8")
    wrong.write_text(text.replace('text = "ah"', 'text = "QQ"').replace('text = "s"', 'text = "QQ"'), encoding="utf-8")
    done = snakemake(folder, "alignment", configfiles=written(folder, settings))
    assert done.returncode == 0, done.stdout[-6000:]
    found = {f"sub-{name}": one for name, one in aligned(tiny_run / "results/tiny").items() if name in names[2:]}
    assert aligned(folder / "results/mine") == found and len(found) == len(names) - 2
    reasons = {
        one.id: one.finding
        for shard in (0, 1)
        for one in read_findings(folder / f"results/mine/alignment/{shard}.findings.tsv")
    }
    assert set(reasons) == {f"sub-{name}" for name in names[:2]}
    assert reasons[f"sub-{names[0]}"] == f"there is no {names[0]}.TextGrid"
    assert f"{names[1]}.TextGrid, tier 'phones'" in reasons[f"sub-{names[1]}"] and "'QQ' is no phone" in str(reasons)
    assert "Nothing to be done" in snakemake(folder, "alignment", configfiles=written(folder, settings)).stdout
    # The words are those of the files, so a system that needs them runs.
    assert "train_model" in planned_rules(folder, "tables", configfiles=written(folder, settings))
    # A file that is put in its place re-runs its shard alone.
    missing.write_text(text, encoding="utf-8")
    again = snakemake(folder, "--dry-run", "alignment", configfiles=written(folder, settings))
    assert again.stdout.count("rule align_speech:") == 1


@pytest.mark.parametrize(
    ("alignment", "reason"),
    [
        ({"folder": "nowhere"}, "nowhere does not exist"),
        ({"phone_tier": "Laute"}, "has no tier 'Laute' (its tiers: 'words', 'phones', 'states')"),
        ({"phones": "ipa"}, "is no phone of the phone set ipa"),
        ({"dictionary": "own.dict"}, "own.dict, line 2: the phone 'QQ' of 'b'"),
        ({"folder": "", "source": "recogniser", "states": "tier"}, "`corpora.mine.alignment.states: tier` must be"),
    ],
)
def test_mistakes_are_one_sentence_before_any_job(mine, alignment, reason):
    folder, settings = mine
    (folder / "own.dict").write_text("a AH0\nb QQ\n")
    done = snakemake(folder, "alignment", configfiles=written(folder, settings, **alignment))
    assert done.returncode == 1 and reason in done.stdout, done.stdout[-3000:]
    assert "Traceback" not in done.stdout and "rule " not in done.stdout
