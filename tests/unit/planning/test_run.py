"""A run planned from its settings: every shipped one, which systems run where, without files and heavy libraries."""

import os
import subprocess
import sys

import pytest
import yaml

from tests.paths import REPOSITORY
from tests.unit.planning.configs import CONFIG, planned, resolved, rows
from visualspeech.errors import CorpusError, SettingError
from visualspeech.features.blocks.base import block_class
from visualspeech.fields import with_defaults
from visualspeech.models.families import FAMILIES
from visualspeech.models.rows import ModelRow
from visualspeech.models.training_settings import TrainingSettings
from visualspeech.schema import check, load_schema, settings_class
from visualspeech.speech import egemaps

SCHEMAS = REPOSITORY / "workflow" / "schemas"
#: Without those that an optional package of this installation is missing for.
OVERLAYS = sorted(path for path in CONFIG.glob("*.yaml") if path.name != "egemaps.yaml" or not egemaps.missing())
SYSTEMS = sorted(path.stem for path in (CONFIG / "systems").glob("*.yaml"))
CODINGS = sorted(path.stem for path in (CONFIG / "codings").glob("*.yaml"))
HEAVY = ("torch", "av", "cv2", "pandas", "dlib", "matplotlib", "h5py", "scipy")


@pytest.fixture
def grid(tmp_path, monkeypatch):
    """A folder of GRID with recordings of two speakers, empty ones."""
    for speaker in ("s1", "s2"):
        (tmp_path / "grid" / speaker).mkdir(parents=True)
        for code in ("bbaf2n", "bbaf3s", "lwiz9p", "sgazzs", "pwij3p"):
            (tmp_path / "grid" / speaker / f"{code}.mpg").write_bytes(b"")
    monkeypatch.setenv("GRID_ROOT", str(tmp_path / "grid"))
    return tmp_path / "grid"


@pytest.mark.parametrize("overlay", OVERLAYS, ids=lambda path: path.name)
def test_every_shipped_config_is_planned(overlay, grid):
    plan = planned(overlay)
    # Systems of one speaker are skipped on the corpus of two.
    assert plan.pairs and all(" on demo_pair: it needs recordings of one speaker" in one for one in plan.skipped)
    for corpus, system in plan.pairs:
        assert rows(plan.settings, system) and plan.corpora[corpus].shards
        assert plan.systems(corpus) and set(plan.codings(corpus)) <= set(plan.settings["codings"])


@pytest.mark.parametrize("overlay", OVERLAYS, ids=lambda path: path.name)
def test_every_shipped_config_builds_its_settings(overlay):
    settings = resolved(overlay)
    for system in settings["systems"].values():
        for row in map(ModelRow.of, system["rows"]):
            family = FAMILIES[row.family]
            if family.settings:
                assert with_defaults(settings_class(family.settings), row.settings, ("seed",)) == row.settings
            if family.trained:
                TrainingSettings(**row.training)
        for block in system["blocks"].values():
            cls = block_class(block["kind"]).settings
            assert block["settings"] == (with_defaults(cls, block["settings"]) if cls else {})
    # What is resolved satisfies the schema, and needs no further default.
    for coding in settings["codings"].values():
        check(coding, load_schema(SCHEMAS / "coding.schema.yaml"))
    for corpus in settings["corpora"].values():
        check(corpus, load_schema(SCHEMAS / "corpus.schema.yaml"))


@pytest.mark.parametrize("system", SYSTEMS)
def test_every_shipped_system_resolves_alone(system):
    settings = resolved({"systems": [system]})
    assert list(settings["systems"]) == [system] and settings["systems"][system]["coding"] in settings["codings"]


@pytest.mark.parametrize("coding", CODINGS)
def test_every_shipped_coding_resolves(coding):
    base = "sadoughi2017" if coding == "markers" else "fan2015"
    settings = resolved({"systems": [{"name": "mine", "extends": base, "coding": coding}]})
    assert settings["codings"][coding]["kind"] and settings["systems"]["mine"]["coding"] == coding


def test_rows_of_the_default_run():
    settings = resolved()
    assert rows(settings) == [
        *(f"{letters}-{nodes}" for letters in ("FFF", "BFF", "BBB", "FBB") for nodes in (64, 128)),
        "FBB-128-lips", "FBB-128-mel", "FBB-128-tri-mel",
        "hmm_monophone", "hmm_tied", "hmm_mge",
        "FBB-128-thirds", "hmm_monophone_states", "hmm_tied_states", "hmm_mge_states",
    ]  # fmt: skip
    assert rows(settings, role="baseline") == ["phone_state_mean", "triphone_state_mean", "training_mean"]
    assert len(rows(resolved(CONFIG / "paper.yaml"))) == 42 + 2 + 3 + 4
    fan = settings["systems"]["fan2015"]
    assert fan["videos"]["model"] == "FBB-128-lips"
    assert fan["tables"]["topologies"] == rows(settings)[:8] and fan["seeds"] == [1]


def test_a_run_has_all_defaults():
    settings = resolved()
    assert settings["check"]["min_rate"] == 10.0 and settings["speak"]["voice"]["rate_wpm"] == 150
    assert settings["systems"]["fan2015"]["tables"]["comparison"]["test"] == "wilcoxon"
    assert settings["corpora"]["demo"]["limit"] == 0 and settings["codings"]["aam51"]["source"] == "landmarks"
    assert resolved({"override": {}}) == settings


def test_a_corpus_may_have_shards_of_its_own():
    own = planned({"corpora": ["demo"], "shards": 7}).corpora["demo"].shards
    run = planned({"corpora": [{"name": "other", "adapter": "demo"}], "shards": 7}).corpora["other"].shards
    assert own == ["0", "1"] and run == [str(number) for number in range(7)]


def files(folder):
    return sorted((path.relative_to(folder), path.stat().st_mtime_ns) for path in folder.rglob("*"))


def test_planning_writes_no_file_at_all(tmp_path, grid, monkeypatch):
    (tmp_path / "run").mkdir()
    monkeypatch.chdir(tmp_path / "run")
    before = files(tmp_path)
    for overlay in OVERLAYS:
        planned(overlay)
    with pytest.raises(SettingError):
        planned({"shards": 0})
    assert files(tmp_path) == before


def test_planning_imports_no_heavy_library(grid):
    code = f"""
import sys
from tests.unit.planning.configs import CONFIG, planned
for name in {[path.name for path in OVERLAYS]!r}:
    planned(CONFIG / name)
print(*sorted(set({HEAVY!r}) & set(sys.modules)))
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(REPOSITORY), *sys.path])}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == []


NEEDY = {"name": "needy", "extends": "fan2015", "needs": ["motion", "emotion"]}


def test_a_system_that_a_corpus_does_not_suit_is_skipped_with_a_sentence():
    plan = planned({"systems": ["fan2015", NEEDY], "corpora": ["demo"]})
    assert plan.pairs == (("demo", "fan2015"),)
    assert plan.skipped == (
        "needy is skipped on demo: it needs motion capture of every utterance, an emotion label of the utterances.",
    )
    assert plan.systems("demo") == ["fan2015"] and plan.codings("demo") == ["aam51"]


def test_nothing_left_to_run_is_refused():
    with pytest.raises(SettingError, match="no selected system can run .*:\n  needy is skipped on demo"):
        planned({"systems": [NEEDY]})


def test_a_corpus_without_any_system_is_dropped(grid):
    both = {"name": "both", "adapter": "grid", "root": str(grid)}
    plan = planned({"systems": ["fan2015"], "corpora": ["demo", both]})
    assert list(plan.corpora) == ["demo"] and plan.pairs == (("demo", "fan2015"),)
    assert plan.skipped[0].startswith("fan2015 is skipped on both: it needs recordings of one speaker (select one with")
    one = planned({"systems": ["fan2015"], "corpora": ["demo", {**both, "speaker": "s2"}]})
    assert one.pairs == (("demo", "fan2015"), ("both", "fan2015"))
    assert list(one.corpora["both"].speakers) == ["s2"]
    with pytest.raises(CorpusError, match="no recordings of the speaker 's3'"):
        planned({"corpora": [{**both, "speaker": "s3"}]})


def test_a_corpus_file_anywhere_names_its_root_from_its_own_folder(tmp_path):
    for n in range(3):
        (tmp_path / "clips").mkdir(exist_ok=True)
        (tmp_path / "clips" / f"{n}.mp4").write_bytes(b"")
        (tmp_path / "clips" / f"{n}.txt").write_text("hello")
    (tmp_path / "mine.yaml").write_text("adapter: folder\nroot: clips\n")
    plan = planned({"corpora": [str(tmp_path / "mine.yaml")]})
    assert plan.settings["corpora"]["mine"]["root"] == str(tmp_path / "clips")
    assert sum(map(len, plan.corpora["mine"].utterances.values())) == 3
    (tmp_path / "mine.yaml").write_text(f"adapter: folder\nroot: {tmp_path / 'clips'}\n")
    assert resolved({"corpora": str(tmp_path / "mine.yaml")})["corpora"]["mine"]["root"] == str(tmp_path / "clips")


def test_an_overlay_of_one_corpus_is_a_corpus_file_too(tmp_path):
    (tmp_path / "own.yaml").write_text("corpora: [{name: inner, adapter: folder, root: clips}]\nshards: 2\n")
    (corpus,) = resolved({"corpora": [str(tmp_path / "own.yaml")]})["corpora"].values()
    assert (corpus["name"], corpus["root"]) == ("inner", str(tmp_path / "clips"))


def test_corpora_and_systems_may_be_given_without_a_list():
    assert list(resolved({"corpora": "demo", "systems": "fan2015"})["systems"]) == ["fan2015"]
    corpus = {"name": "mine", "adapter": "folder", "root": "/somewhere"}
    assert resolved({"corpora": corpus})["corpora"]["mine"]["root"] == "/somewhere"


@pytest.mark.parametrize("path", sorted(SCHEMAS.glob("*.yaml")), ids=lambda path: path.name)
def test_every_key_is_described(path):
    def undescribed(node, place):
        for key, value in node.get("properties", {}).items():
            if "description" not in value and key not in ("name",):
                yield f"{place}{key}"
            yield from undescribed(value, f"{place}{key}.")

    assert list(undescribed(load_schema(path), "")) == []
    assert load_schema(path)["additionalProperties"] is False and yaml.safe_load(path.read_text())["description"]
