"""Mistakes in settings: a sentence each that names the setting, the rule, and how to write what was meant."""

import math

import pytest
import yaml

from tests.paths import REPOSITORY
from visualspeech.errors import SettingError
from visualspeech.schema import check, fill_defaults, load_schema
from visualspeech.settings import merged, resolve

CONFIG = REPOSITORY / "config"
STACK = r"Hidden layers from the input up, one capital letter each: F feed-forward, B bidirectional LSTM"


def resolved(overlay):
    return resolve(merged(yaml.safe_load((CONFIG / "config.yaml").read_text()), yaml.safe_load(overlay)), CONFIG)


@pytest.mark.parametrize(
    ("overlay", "said"),
    [
        ("networks: {stacks: [FXB]}", f"`networks.stacks.0: FXB` does not fit. {STACK}"),
        ("networks: {stacks: [fbb]}", f"`networks.stacks.0: fbb` does not fit. {STACK}"),
        ("networks: {stacks: ['']}", f"`networks.stacks.0: ''` does not fit. {STACK}"),
        ("networks: {stacks: [FBB-128]}", "`networks.stacks.0: FBB-128` does not fit. .* its width in networks.nodes"),
        ("networks: {stacks: []}", r"`networks.stacks: \[\]` must have at least 1 entry. Hidden layers"),
        ("networks: {stacks: [3]}", r"`networks.stacks.0: 3` must be a text \(put it in quotes\)"),
        ("networks: {stacks: [no]}", r"`networks.stacks.0: false` must be a text \(YAML reads no, yes, on and off as"),
        ("networks: {stacks: FBB}", r"`networks.stacks: FBB` must be a list; write \[FBB\]"),
        ("networks: {stacks: }", "`networks.stacks` is empty and must be a list"),
        ("networks: {stacks: [FB, FB]}", r"`networks.stacks: \[FB, FB\]` names FB more than once; give each once"),
        ("networks: {nodes: [0]}", "`networks.nodes.0: 0` must be at least 1"),
        ("networks: {nodes: [-4]}", "`networks.nodes.0: -4` must be at least 1"),
        (
            "networks: {nodes: [16.5]}",
            r"`networks.nodes.0: 16.5` must be a whole number, at least 1 and at most 4096. ",
        ),
        ("networks: {nodes: [16.0]}", "`networks.nodes.0: 16.0` must be a whole number, .*; write 16"),
        ("networks: {nodes: ['16']}", "`networks.nodes.0: '16'` must be a whole number, .*; write 16"),
        ("networks: {nodes: [yes]}", r"`networks.nodes.0: true` must be a whole number, at least 1 and at most 4096. "),
        (
            "networks: {nodes: [many]}",
            r"`networks.nodes.0: many` must be a whole number, at least 1 and at most 4096. ",
        ),
        ("networks: {nodes: [16, 15], b_nodes: layer}", "`networks.nodes: 15` is odd; with `networks.b_nodes: layer`"),
        ("networks: {richer: [FB-15], b_nodes: layer}", "`networks.richer: FB-15` is odd; .* Give an even number"),
        ("networks: {richer: [FB]}", "`networks.richer.0: FB` does not fit. Stack and width, for example FBB-128"),
        ("networks: {richer: [FB-99999]}", "`networks.richer.0: FB-99999` does not fit"),
        ("networks: {seeds: []}", "`networks.seeds.* must have at least 1 entry"),
        ("networks: {seeds: [1, 2, 1]}", r"`networks.seeds: \[1, 2, 1\]` names 1 more than once"),
        ("networks: {seeds: [-1]}", "`networks.seeds.0: -1` must be at least 0"),
        (
            "networks: {seeds: [12345678901]}",
            "`networks.seeds.0: 12345678901` must be at least 0 and at most 999999999",
        ),
        ("networks: {label_parts: [tone]}", "`networks.label_parts.0: tone` must be one of position_in_syllable"),
        ("videos: {model: BBB-512}", "`videos.model: BBB-512` is not trained. Trained here: FFF-64"),
        ("hmm: {variants: [hmm_triphone]}", "`hmm.variants.0: hmm_triphone` must be one of hmm_monophone, hmm_tied"),
        ("hmm: {variants: hmm_mge}", r"`hmm.variants: hmm_mge` must be a list; write \[hmm_mge\]"),
        ("aam_source: fitted", "`aam_source: fitted` must be one of landmarks, fit"),
        ("aam: {shape: {components: 0}}", "`aam.shape.components: 0` must be at least 1"),
        (
            "aam: {shape: {energy: 0.9, components: 3}}",
            "must have either `energy` or `components`. Components of the shape",
        ),
        ("aam: {shape: {components: 3, at_most: 5}}", "has `at_most`, which goes with `energy` alone. Components"),
        ("pose: {focal_length: wide}", "must be a number, at least 0.1 and at most 1000. Assumed focal length"),
        ("hmm: {states: 0}", "`hmm.states: 0` must be at least 1 and at most 20. Number of states per phone"),
        ("aam: {images: 300.0}", "`aam.images: 300.0` must be a whole number, .*; write 300"),
        (
            "texture: {texture_pixels: 40000}",
            "`texture.texture_pixels: 40000` must be at least 100 and at most 30000. Approximate number",
        ),
        ("aam: ", "`aam` is empty and must be lines of `key: value`"),
        ("experiment: 3", "`experiment: 3` is not known. Known: fan2015"),
        ("training: {learning_rate: 0}", "`training.learning_rate: 0` must be above 0 and at most 1. Step size"),
        ("training: {learning_rate: 1e-3}", "`training.learning_rate: 1e-3` must be a number, .*; write 0.001"),
        ("training: {learning_rate: 1e-6}", "`training.learning_rate: 1e-6` must be a number, .*; write 0.000001"),
        (
            "training: {learning_rate: .nan}",
            r"`training.learning_rate: .nan` must be a number, above 0 and at most 1. ",
        ),
        ("training: {clip: .inf}", r"`training.clip: .inf` must be a number, at least 0"),
        ("training: {dropout: 1}", "`training.dropout: 1` must be at least 0 and below 1"),
        ("training: {averaging: 1.5}", "`training.averaging: 1.5` must be at least 0 and below 1"),
        ("training: {max_epochs: 0}", "`training.max_epochs: 0` must be at least 1"),
        ("training: {optimiser: sgd}", "`training.optimiser: sgd` must be one of adam, paper"),
        ("training: {scale_targets: 1}", r"`training.scale_targets: 1` must be true or false\. "),
        ("training: [1]", r"`training: \[1\]` must be lines of `key: value`"),
        ("tables: {comparison: {level: 5}}", "`tables.comparison.level: 5` must be above 0 and below 1"),
        (
            "tables: {comparison: {level: high}}",
            r"`tables.comparison.level: high` must be a number, above 0 and below 1. ",
        ),
        ("tables: {comparison: {test: t}}", "`tables.comparison.test: t` must be one of wilcoxon, permutation"),
        ("preference: {models: [FBB-128]}", r"`preference.models: \[FBB-128\]` must have at least 2 entries"),
        ("speak: {sentences: []}", r"`speak.sentences: \[\]` must have at least 1 entry. What the target speak says"),
        ("speak: {sentences: ['']}", "`speak.sentences.0: ''` must not be empty"),
        ("speak: {sentences: [no]}", "`speak.sentences.0: false` must be a text .*put a text in quotes"),
        ("speak: {sentences: [12]}", r"`speak.sentences.0: 12` must be a text \(put it in quotes\)"),
        ("speak: {voice: {pitch: 200}}", "`speak.voice.pitch: 200` must be at least 0 and at most 100. Pitch"),
        ("corpus: {name: x, adapter: folder, root: 5}", "`corpus.root: 5` must be a text"),
        ("no: 3", "unknown setting `False`"),
    ],
)
def test_every_mistake_is_a_sentence(overlay, said):
    with pytest.raises(SettingError, match=said) as told:
        resolved(overlay)
    assert len(str(told.value).splitlines()) == 1


def test_all_mistakes_are_told_at_once():
    with pytest.raises(SettingError) as told:
        resolved("{shards: 0, training: {dropout: 1}, networks: {nodes: [0, two]}}")
    lines = str(told.value).splitlines()
    assert [line.split("`")[1] for line in lines] == [
        "networks.nodes.0: 0", "networks.nodes.1: two", "shards: 0", "training.dropout: 1",
    ]  # fmt: skip


def test_what_is_written_as_told_is_taken():
    settings = resolved("training: {learning_rate: 0.000001, clip: 0, averaging: 0}")["training"]
    assert settings["learning_rate"] == 1e-6 and not math.isnan(settings["clip"])
    assert resolved("hmm: {variants: [hmm_mge]}")["hmm"]["variants"] == ["hmm_mge"]


def test_a_corpus_file_with_a_root_that_is_no_text(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nadapter: folder\nroot: 5\n")
    with pytest.raises(SettingError, match="`corpus.root: 5` must be a text"):
        resolved(f"corpus: {tmp_path / 'mine.yaml'}")


SCHEMA = """
type: object
additionalProperties: false
properties:
  head: {settings: "visualspeech.face.head:PoseSettings", hidden: [margin], description: Another text.}
  hmm:
    settings: "visualspeech.models.hmm.model:HmmSettings"
    hidden: [seed]
    properties:
      variants: {type: array, items: {type: string}, default: [hmm_tied], description: Rows.}
  models:
    type: object
    additionalProperties: {$ref: "#/$defs/model"}
  pairs:
    type: object
    properties:
      count: {type: integer, default: 10}
      tests: {settings: "visualspeech.evaluation.comparisons:ComparisonSettings", hidden: [seed]}
  voices: {type: array, items: {settings: "visualspeech.speech.spoken_settings:VoiceSettings"}}
$defs:
  model: {type: object, properties: {low: {settings: "visualspeech.models.baselines:BaselineSettings"}, free: {}}}
"""


@pytest.fixture
def schema(tmp_path):
    (tmp_path / "schema.yaml").write_text(SCHEMA)
    return load_schema(tmp_path / "schema.yaml")


def test_a_section_stands_for_the_schema_of_its_class(schema):
    head = schema["properties"]["head"]
    assert head["description"] == "Another text." and head["additionalProperties"] is False
    assert head["properties"]["focal_length"]["minimum"] == 0.1 and "margin" not in head["properties"]
    assert {"variants", "states"} <= set(schema["properties"]["hmm"]["properties"])
    check({"hmm": {"variants": ["hmm_mge"], "states": 3}}, schema)
    with pytest.raises(SettingError, match="`hmm.states: 99` must be at least 1"):
        check({"hmm": {"states": 99}}, schema)
    with pytest.raises(SettingError, match="unknown setting `head.margin`"):
        check({"head": {"margin": 1}}, schema)


def test_defaults_are_filled_in_and_what_is_given_stays(schema):
    given = {"hmm": {"states": 3}, "models": {"a": {}, "b": {"low": {"min_count": 7}}}, "voices": [{"pitch": 3}]}
    filled = fill_defaults(given, schema)
    assert given == {
        "hmm": {"states": 3},
        "models": {"a": {}, "b": {"low": {"min_count": 7}}},
        "voices": [{"pitch": 3}],
    }
    assert filled["hmm"]["states"] == 3 and filled["hmm"]["rate"] == 100.0 and filled["hmm"]["variants"] == ["hmm_tied"]
    assert "seed" not in filled["hmm"] and "margin" not in filled["head"] and filled["head"]["focal_length"] == 3.0
    assert filled["models"] == {"a": {"low": {"min_count": 3}}, "b": {"low": {"min_count": 7}}}
    assert filled["pairs"]["count"] == 10 and filled["pairs"]["tests"]["level"] == 0.05
    assert filled["voices"][0]["pitch"] == 3 and filled["voices"][0]["rate_wpm"] == 150
    check(filled, schema)
    assert fill_defaults(filled, schema) == filled
    filled["hmm"]["variants"].append("changed")
    assert fill_defaults({}, schema)["hmm"]["variants"] == ["hmm_tied"]


@pytest.mark.parametrize(
    "name", ["os:path", "visualspeech.face.head", "visualspeech.nowhere:X", "visualspeech.face.head:X"]
)
def test_a_schema_names_only_classes_of_the_package(tmp_path, name):
    (tmp_path / "schema.yaml").write_text(f'properties: {{a: {{settings: "{name}"}}}}' if ":" in name else
                                          f'properties: {{a: {{settings: "{name}:"}}}}')  # fmt: skip
    with pytest.raises(SettingError, match="the schema names"):
        load_schema(tmp_path / "schema.yaml")


def test_a_run_has_all_defaults_and_they_satisfy_the_schema():
    settings = resolved("{}")
    assert settings["check"]["min_rate"] == 10.0 and settings["tables"]["comparison"]["test"] == "wilcoxon"
    assert settings["speak"]["voice"]["rate_wpm"] == 150 and "seed" not in settings["hmm"]
    check(settings, load_schema(REPOSITORY / "workflow" / "schemas" / "config.schema.yaml"))
