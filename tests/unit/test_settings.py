"""Settings: layers, what is shipped, and a reference that says what the schemas say."""

import subprocess
import sys
from itertools import chain

import pytest
import yaml

from tests.paths import REPOSITORY
from tests.unit.settings_reference import class_tables, preset_line, readme_rows, reference_rows, run_tables
from visualspeech.animation.speaking_settings import SpeakSettings
from visualspeech.animation.video_settings import VideoSettings
from visualspeech.corpora.adapters import ADAPTERS
from visualspeech.errors import SettingError
from visualspeech.evaluation.comparisons import ComparisonSettings
from visualspeech.evaluation.published_results import published, published_names
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings
from visualspeech.face.aam.model import AamSettings
from visualspeech.face.coding_files import KINDS as CODINGS
from visualspeech.features.blocks.base import block_class, block_kinds
from visualspeech.fields import MAX_SEED, described_fields, section_schema
from visualspeech.models.entries import ENTRY, ENTRY_KEYS, TRAINED_KEYS, entry_schema
from visualspeech.models.families import FAMILIES
from visualspeech.models.training_settings import TrainingSettings
from visualspeech.planning.codings import coding_schema
from visualspeech.planning.run import KINDS, RESERVED, plan_run, resolve
from visualspeech.planning.systems import NAME, NEEDS, block_schema
from visualspeech.schema import load_schema, settings_class
from visualspeech.settings import merged, read_yaml
from visualspeech.speech import egemaps

CONFIG = REPOSITORY / "config"
SCHEMAS = {
    path.name.removesuffix(".schema.yaml"): load_schema(path)
    for path in (REPOSITORY / "workflow" / "schemas").glob("*")
}
OVERLAYS = sorted(CONFIG.glob("*.yaml"))
HEAVY = {"torch", "av", "cv2", "dlib", "pandas", "scipy", "matplotlib", "h5py", "pocketsphinx"}


def default():
    return yaml.safe_load((CONFIG / "config.yaml").read_text())


def overlaid(*overlays):
    settings = default()
    for overlay in overlays:
        settings = merged(settings, overlay if isinstance(overlay, dict) else yaml.safe_load(overlay.read_text()))
    return settings


@pytest.fixture
def grid(tmp_path, monkeypatch):
    """A folder that looks like GRID: recordings that are never opened."""
    for code in ("bbaf2n", "lgbs7s", "pwij3p"):
        (tmp_path / "grid" / "s1").mkdir(parents=True, exist_ok=True)
        (tmp_path / "grid" / "s1" / f"{code}.mpg").write_bytes(b"no video")
    monkeypatch.setenv("GRID_ROOT", str(tmp_path / "grid"))


def nodes(node, path=""):
    """Every part of a schema that describes a value, with its path."""
    if path:
        yield path, node
    for key, inner in node.get("properties", {}).items():
        yield from nodes(inner, f"{path}.{key}")
    for key, name in (("items", "[]"), ("additionalProperties", "*"), ("propertyNames", "name")):
        if isinstance(node.get(key), dict):
            yield from nodes(node[key], f"{path}.{name}")


def sections(schema):
    """The parts of a schema that stand for a settings class."""
    every = [("", schema), *nodes(schema)]
    return [(path, node, settings_class(node["settings"])) for path, node in every if "settings" in node]


def derived():
    """Schemas that the library makes itself: entries of ``models:`` and of ``blocks:``."""
    families = {family: entry_schema(family) for family in FAMILIES}
    return families | {f"block {kind}": block_schema(kind) for kind in block_kinds()}


@pytest.mark.parametrize("name", [*SCHEMAS, *derived()])
def test_every_key_is_described(name):
    schema = SCHEMAS.get(name) or derived()[name]
    missing = [path for path, node in nodes(schema) if not str(node.get("description", "")).endswith((".", ". "))]
    assert missing == []
    closed = [path for path, node in nodes(schema) if node.get("properties") and node.get("additionalProperties", True)]
    assert closed == []


@pytest.mark.parametrize("name", SCHEMAS)
def test_sections_say_what_their_classes_say(name):
    for path, node, cls in sections(SCHEMAS[name]):
        own = section_schema(cls, hidden=node.get("hidden", ()))["properties"]
        assert {key: node["properties"][key] for key in own} == own, path
        assert set(node.get("hidden", ())) <= {"seed"}, path
        # Whatever else a section holds is a section or a list of its own, never a second copy of a field.
        assert all("default" in node["properties"][key] or "settings" in node["properties"][key]
                   for key in set(node["properties"]) - set(own) - set(node.get("required", ()))), path  # fmt: skip


def test_every_settings_class_of_a_run_is_in_a_schema():
    named = {cls for schema in SCHEMAS.values() for _, _, cls in sections(schema)}
    families = {settings_class(family.settings) for family in FAMILIES.values() if family.settings}
    blocks = {block_class(kind).settings for kind in block_kinds()} - {None}
    from tests.unit.test_fields import CLASSES

    library = {"DemoSettings", "RenderSettings", "SpeakSettings", "VideoSettings", "WalkSettings"}
    library |= {"TrajectorySettings"}  # the settings of networks inherit it
    assert {cls.__name__ for cls in set(CLASSES) - named - families - blocks} == library


def test_what_is_written_in_a_schema_agrees_with_the_library():
    run, system, coding, corpus = (SCHEMAS[name]["properties"] for name in ("run", "system", "coding", "corpus"))
    assert set(KINDS.values()) == set(SCHEMAS) - {"run"}
    assert system["needs"]["items"]["enum"] == list(NEEDS)
    assert set(corpus["adapter"]["enum"]) == set(ADAPTERS)
    for properties in (system, coding, corpus):
        assert properties["name"] == NAME
    for seed in (run["seed"], corpus["seed"], system["seeds"]["items"], ENTRY["seeds"]["items"]):
        assert (seed["minimum"], seed["maximum"]) == (0, MAX_SEED)
    assert run["speak"]["properties"]["label"]["default"] == SpeakSettings().label
    assert system["videos"]["properties"]["label"]["default"] == VideoSettings().label
    assert coding["kind"]["enum"] == list(CODINGS) and set(system["published"]) >= {"default", "pattern"}
    assert ENTRY_KEYS == tuple(ENTRY) and set(TRAINED_KEYS) <= set(ENTRY)
    for kind, name in (("stack", "letters"), ("stack", "nodes")):
        assert name in FAMILIES[kind].grid


@pytest.mark.parametrize("family", FAMILIES)
def test_no_setting_of_a_family_has_the_name_of_a_key_of_entries(family):
    known = FAMILIES[family]
    own = (
        {name for name, *_ in described_fields(settings_class(known.settings))} - {"seed"} if known.settings else set()
    )
    assert not own & set(ENTRY)
    assert set(entry_schema(family)["properties"]) == own | {
        key for key in ENTRY if known.trained or key not in TRAINED_KEYS
    }
    assert set(known.grid) <= own


def built(settings):
    """Build every settings class of a run from what the rules are handed; returns how many."""
    count = 0
    for path, node, cls in sections(SCHEMAS["run"]):
        value = settings
        for key in path.strip(".").split("."):
            value = value[key]
        cls(**value)
        count += bool(node)
    for coding in settings["codings"].values():
        for path, _, cls in sections(coding_schema(SCHEMAS["coding"], coding)):
            cls(**coding[path.strip(".")])
            count += 1
    for system in settings["systems"].values():
        tables = system["tables"]
        TableSettings(**{key: tables[key] for key in ("metrics", "digits", "ratio_digits")})
        ComparisonSettings(**tables["comparison"])
        BootstrapSettings(**tables["bootstrap"])
        for block in system["blocks"].values():
            cls = block_class(block["kind"]).settings
            assert set(block) == {"kind", "settings"} and (cls or block["settings"] == {})
            count += bool(cls) and bool(cls(**block["settings"]))
        for row in system["rows"]:
            family = FAMILIES[row["family"]]
            cls = settings_class(family.settings) if family.settings else None
            assert cls or row["settings"] == {}
            count += bool(cls) and bool(cls(**row["settings"]))
            assert bool(row["training"]) == family.trained and set(row["reads"]) <= set(system["blocks"])
            if family.trained:
                TrainingSettings(**row["training"], seed=row["seed"])
    return count


@pytest.mark.parametrize("base", [None, CONFIG / "grid.yaml"], ids=["demo", "grid"])
@pytest.mark.parametrize("overlay", OVERLAYS, ids=lambda path: path.name)
def test_every_shipped_config_resolves_and_builds_its_settings(overlay, base, grid, monkeypatch):
    monkeypatch.setattr(egemaps, "find_spec", lambda name: True)  # planning reads nothing of it
    layers = [base, overlay] if base else [overlay]
    plan = plan_run(overlaid(*layers), CONFIG)
    # fan2015 and others are systems of one speaker.
    assert built(plan.settings) > 15 and plan.pairs and all(" on demo_pair: " in one for one in plan.skipped)
    for name, corpus in plan.corpora.items():
        alone = {"one_speaker"} if name != "demo_pair" else {"emotion"}
        assert len(corpus.split) >= 3 and corpus.gives >= {"video", "audio", "text"} | alone


@pytest.mark.parametrize("path", sorted((CONFIG / "systems").glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_system_resolves(path):
    settings = resolve(overlaid({"systems": [path.stem]}), CONFIG)
    system = settings["systems"][path.stem]
    assert built(settings) and list(settings["codings"]) == [system["coding"]]
    assert system["published"] == "" or published(system["published"])
    assert settings == resolve(overlaid({"systems": str(path)}), CONFIG)


@pytest.mark.parametrize("path", sorted((CONFIG / "codings").glob("*.yaml")), ids=lambda path: path.stem)
def test_every_shipped_coding_resolves(path):
    base = "sadoughi2017" if read_yaml(path)["kind"] == "markers" else "fan2015"
    given = {"systems": [{"name": "mine", "extends": base, "coding": path.stem}]}
    settings = resolve(overlaid(given), CONFIG)
    if base == "fan2015":
        AamSettings(**settings["codings"][path.stem]["aam"], seed=settings["seed"])
    assert settings["systems"]["mine"]["coding"] == path.stem


@pytest.mark.parametrize("name", published_names())
def test_every_file_of_published_figures_is_read(name):
    assert published(name).source


def test_merging_leaves_its_inputs_alone():
    base, over = {"a": {"b": 1, "c": [1]}, "d": 2}, {"a": {"c": [2]}, "d": {"e": 3}}
    result = merged(base, over)
    assert result == {"a": {"b": 1, "c": [2]}, "d": {"e": 3}}
    result["a"]["c"].append(9)
    result["d"]["e"] = 9
    assert (base, over) == ({"a": {"b": 1, "c": [1]}, "d": 2}, {"a": {"c": [2]}, "d": {"e": 3}})


def test_what_is_no_mapping_is_replaced():
    assert merged({"a": {"b": 1}}, {"a": None}) == {"a": None}
    assert merged({"a": None}, {"a": {"b": 1}}) == {"a": {"b": 1}}
    assert merged({"a": [1, 2]}, {"a": [3]}) == {"a": [3]}
    assert merged({}, {}) == {}


def test_files_that_are_no_settings(tmp_path):
    path = tmp_path / "x.yaml"
    with pytest.raises(SettingError, match="cannot read .*x.yaml: No such file"):
        read_yaml(path)
    for content in (b"a: [1", b"\xff\xfe\x00", b"a: !!python/object:os.system {}"):
        path.write_bytes(content)
        with pytest.raises(SettingError, match="x.yaml is not YAML"):
            read_yaml(path)
    for content in (b"- 1", b""):
        path.write_bytes(content)
        with pytest.raises(SettingError, match="x.yaml must hold `key: value` lines"):
            read_yaml(path)
    path.write_text("a: 1\nb: {c: [2]}\n")
    assert read_yaml(path) == {"a": 1, "b": {"c": [2]}}


def test_components_take_the_place_of_an_energy():
    base = {"shape": {"energy": 0.9, "at_most": 5}}
    assert merged(base, {"shape": {"components": 3}}) == {"shape": {"components": 3}}
    assert merged({"shape": {"components": 3}}, base) == base
    assert merged(base, {"shape": {"energy": 0.8}}) == {"shape": {"energy": 0.8, "at_most": 5}}


def test_resolving_changes_nothing_that_it_is_given():
    config, again = overlaid(CONFIG / "test.yaml"), overlaid(CONFIG / "test.yaml")
    first = resolve(config, CONFIG)
    assert config == again and first == resolve(config, CONFIG)


def test_a_corpus_file_anywhere_names_its_root_from_its_own_folder(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nadapter: folder\nroot: clips\n")
    settings = resolve(overlaid({"corpora": str(tmp_path / "mine.yaml")}), CONFIG)
    assert settings["corpora"]["mine"]["root"] == str(tmp_path / "clips")


def test_corpora_are_names_files_or_mappings_alone_or_in_a_list(tmp_path):
    corpus = {"name": "mine", "adapter": "folder", "root": "/somewhere"}
    (tmp_path / "other.yaml").write_text("adapter: folder\nroot: /elsewhere\n")

    def corpora(given):
        return resolve(overlaid({"corpora": given}), CONFIG)["corpora"]

    mine = corpora(corpus)["mine"]
    assert {key: mine[key] for key in corpus} == corpus and mine["limit"] == 0 and mine["consent"] == ""
    assert corpora([corpus]) == corpora(corpus) and corpora("demo") == corpora(["demo"])
    found = corpora(["demo", corpus, str(tmp_path / "other.yaml")])
    assert list(found) == ["demo", "mine", "other"] and found["other"]["root"] == "/elsewhere"


def test_a_corpus_file_may_be_an_overlay(tmp_path):
    (tmp_path / "mine.yaml").write_text("corpora:\n  - {name: inner, adapter: folder, root: /x}\n")
    assert list(resolve(overlaid({"corpora": [str(tmp_path / "mine.yaml")]}), CONFIG)["corpora"]) == ["inner"]


#: The networks that read sound are left out.
QUIET = {"sound": None, "text_and_sound": None, "nets_thirds": None, "articulate": None}


def rows(system="fan2015", **changes):
    settings = resolve(overlaid({"override": {"systems": {"fan2015": {"videos": {"model": ""}, **changes}}}}), CONFIG)
    return settings["systems"][system]["rows"]


def test_further_seeds_and_other_inputs_have_names_of_their_own():
    nets = {"letters": ["FBB", "F"], "nodes": [128]}
    names = [row["name"] for row in rows(models={**QUIET, "nets": nets}, seeds=[1, 5]) if row["family"] == "stack"]
    assert names == ["FBB-128", "F-128", "FBB-128-s5", "F-128-s5"]
    richer = {"like": "nets", "letters": ["FBB"], "reads": ["tri", "parts"], "suffix": "rich"}
    given = {**QUIET, "nets": nets, "richer": richer}
    found = [row for row in rows(models=given, seeds=[3]) if row["family"] == "stack"]
    assert [row["name"] for row in found] == ["FBB-128", "F-128", "FBB-128-rich"]
    assert found[2]["reads"] == ["tri", "parts"] and {row["seed"] for row in found} == {3}
    given = {**QUIET, "nets": {**nets, "seeds": [7, 8]}}
    own = [row["name"] for row in rows(models=given) if row["family"] == "stack"]
    assert own == ["FBB-128", "F-128", "FBB-128-s8", "F-128-s8"]


def test_an_entry_may_change_its_training_and_inherit_a_change():
    models = {
        "nets": {"letters": "FB", "nodes": 8, "training": {"dropout": 0.5, "patience": 3}},
        "slow": {"like": "nets", "training": {"patience": 9}},
    }
    found = {row["name"]: row["training"] for row in rows(models=models, training={"batch_size": 2})}
    assert [found["nets"][key] for key in ("dropout", "patience", "batch_size")] == [0.5, 3, 2]
    assert [found["slow"][key] for key in ("dropout", "patience", "batch_size")] == [0.5, 9, 2]
    assert set(found["slow"]) == {name for name, *_ in described_fields(TrainingSettings)} - {"seed"}


def test_an_inherited_entry_that_is_left_out_asks_for_nothing():
    settings = resolve(overlaid({"override": {"systems": {"fan2015": {
        "models": {**QUIET, "nets": None}, "videos": {"model": ""}}}}}), CONFIG)["systems"]["fan2015"]  # fmt: skip
    assert settings["tables"]["topologies"] == [] and settings["tables"]["gains"]["candidates"] == []
    assert settings["videos"]["model"] == "hmm_monophone"


def test_a_change_of_a_system_counts_for_what_extends_it():
    changes = {"override": {"systems": {"fan2015": {"models": {"hmm_monophone": {"states": 3}}}}}}
    settings = resolve(overlaid(CONFIG / "two_rates.yaml", changes), CONFIG)["systems"]
    for system in settings.values():
        assert {row["settings"]["states"] for row in system["rows"] if row["family"] == "hmm"} == {3}
    assert [system["rate"] for system in settings.values()] == [25, 50]


def test_two_codings_stand_side_by_side():
    other = {"name": "small", "extends": "aam51", "aam": {"shape": {"components": 4}}}
    given = {"systems": ["fan2015", {"name": "mine", "extends": "fan2015", "coding": other}]}
    codings = resolve(overlaid(given), CONFIG)["codings"]
    assert codings["small"]["aam"]["shape"] == {"components": 4} and "energy" in codings["aam51"]["aam"]["shape"]
    assert codings["small"]["texture"] == codings["aam51"]["texture"]


def folder_of(tmp_path, speakers, transcript="a b"):
    for number, speaker in enumerate(speakers):
        (tmp_path / speaker).mkdir(exist_ok=True)
        (tmp_path / speaker / f"u{number}.mp4").write_bytes(b"no video")
    lines = [f"{speaker}/u{number}.mp4\t{transcript}\t{speaker}" for number, speaker in enumerate(speakers)]
    (tmp_path / "table.tsv").write_text("\n".join(["file\ttranscript\tspeaker", *lines]) + "\n")
    return {"name": "mine", "adapter": "folder", "root": str(tmp_path), "table": str(tmp_path / "table.tsv")}


def test_a_system_that_a_corpus_does_not_suit_is_skipped_or_nothing_runs(tmp_path):
    two = folder_of(tmp_path, ["ann", "ann", "ann", "bob", "bob", "bob"])
    one = {"systems": ["fan2015"]}
    with pytest.raises(SettingError) as told:
        plan_run(overlaid({"corpora": two}, one), CONFIG)
    assert str(told.value).splitlines() == [
        "no selected system can run on a selected corpus:",
        "  fan2015 is skipped on mine: it needs recordings of one speaker (select one with `speaker` of the corpus).",
    ]
    plan = plan_run(overlaid({"corpora": ["demo", two]}, one), CONFIG)
    assert plan.pairs == (("demo", "fan2015"),) and len(plan.skipped) == 1 and list(plan.corpora) == ["demo"]
    assert plan_run(overlaid({"corpora": {**two, "speaker": "ann"}}, one), CONFIG).pairs == (("mine", "fan2015"),)


def test_results_have_no_folder_that_a_system_may_be_named_after():
    for name in RESERVED:
        with pytest.raises(SettingError, match=f"{name.capitalize()} is the name of a folder"):
            resolve(overlaid({"systems": {"name": name.capitalize(), "extends": "fan2015"}}), CONFIG)


def test_planning_imports_nothing_heavy():
    modules = sorted(
        f"visualspeech.planning.{path.stem}" for path in (REPOSITORY / "visualspeech" / "planning").glob("[a-z]*.py")
    )
    code = (
        f"import sys, yaml, {', '.join(modules)}\nfrom pathlib import Path\n"
        "config = yaml.safe_load(Path('config/config.yaml').read_text())\n"
        "visualspeech.planning.run.plan_run(config, Path('config'))\n"
        f"print(*({HEAVY!r} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=REPOSITORY, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [] and len(modules) > 5


def test_the_examples_of_the_reference_are_taken():
    blocks = (CONFIG / "README.md").read_text().split("```yaml\n")[1:]
    examples = [yaml.safe_load(block.split("```")[0]) for block in blocks]
    assert len(examples) == 7
    for example in examples:
        example.pop("corpora", None)
        if set(example) == {"models"}:
            example = {"override": {"systems": {"fan2015": example}}}
        assert resolve(overlaid({"override": {"systems": {"fan2015": {"videos": {"model": ""}}}}}, example), CONFIG)


@pytest.mark.parametrize("title", [*run_tables(), *class_tables()])
def test_the_reference_has_every_key_with_its_default_and_range(title):
    """What config/README.md must say of each key stands in the message, ready to be pasted."""
    missing = [line for line in reference_rows(title) if line not in readme_rows()]
    assert not missing, "\n".join(["config/README.md lacks:", *missing])


def test_the_reference_has_no_key_that_is_gone():
    known = set(chain.from_iterable(reference_rows(title) for title in [*run_tables(), *class_tables()]))
    assert [line for line in readme_rows() if line not in known] == []


def test_the_reference_names_every_key_and_field():
    text = (CONFIG / "README.md").read_text()
    from tests.unit.test_fields import CLASSES

    names = {name for cls in CLASSES for name, *_ in described_fields(cls)}
    schemas = [*SCHEMAS.values(), *derived().values()]
    names |= {path.rpartition(".")[2] for schema in schemas for path, _ in nodes(schema)} - {"[]", "*", "name"}
    assert sorted(name for name in names if f"`{name}`" not in text) == []
    assert all(f"`{one}`" in text for one in [*FAMILIES, *block_kinds(), *ADAPTERS, *NEEDS, *RESERVED])
    assert preset_line("paper") in text, preset_line("paper")
