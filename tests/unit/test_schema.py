"""Mistakes in settings: a sentence each that names the setting, the rule, and how to write what was meant."""

import math

import pytest

from tests.unit.planning import configs
from visualspeech.errors import SettingError
from visualspeech.schema import check, fill_defaults, load_schema


def system(text):
    """An overlay that changes the default system."""
    return f"override: {{systems: {{fan2015: {text}}}}}"


def coding(text):
    return f"override: {{codings: {{aam51: {text}}}}}"


@pytest.mark.parametrize(
    ("overlay", "said"),
    [
        ("shards: four", "`shards: four` must be a whole number, at least 1 and at most 1000. Parts in which"),
        ("shards: 16.0", "`shards: 16.0` must be a whole number, .*; write 16"),
        ("shards: 16.5", r"`shards: 16.5` must be a whole number, at least 1 and at most 1000. Parts"),
        ("shards: '16'", "`shards: '16'` must be a whole number, .*; write 16"),
        ("shards: yes", "`shards: true` must be a whole number, at least 1 and at most 1000. "),
        ("shards: -4", "`shards: -4` must be at least 1"),
        ("shards: ", "`shards` is empty and must be a whole number"),
        ("seed: 12345678901", "`seed: 12345678901` must be at least 0 and at most"),
        ("corpora: []", r"`corpora: \[\]` must have at least 1 entry. The recordings"),
        ("corpora: 3", "`corpora: 3` must be a list or a text or lines of `key: value`. The recordings"),
        ("corpora: [3]", "`corpora.0: 3` must be a text or lines of `key: value`. Name, path or mapping of a corpus"),
        ("systems: [no]", "`systems.0: false` must be a text or lines of `key: value`"),
        (system("{seeds: 3}"), r"`systems.fan2015.seeds: 3` must be a list; write \[3\]"),
        (system("{seeds: [1, 2, 1]}"), r"`systems.fan2015.seeds: \[1, 2, 1\]` names 1 more than once; give each once"),
        (system("{seeds: [-1]}"), "`systems.fan2015.seeds.0: -1` must be at least 0"),
        (system("{title: no}"), r"title: false` must be a text \(YAML reads no, yes, on and off as false and true"),
        (system("{title: 3}"), r"`systems.fan2015.title: 3` must be a text \(put it in quotes\)"),
        (system("{rate: fast}"), "`systems.fan2015.rate: fast` must be a number, at least 0 and at most 1000. Frames"),
        (system("{blocks: {Tri: {}}}"), "`systems.fan2015.blocks.*` .*does not fit"),
        (coding("{source: fitted}"), "`codings.aam51.source: fitted` must be one of landmarks, fit"),
        (coding("{aam: {shape: {components: 0}}}"), "`codings.aam51.aam.shape.components: 0` must be at least 1"),
        (coding("{aam: }"), "`codings.aam51.aam` is empty and must be lines of `key: value`"),
        (coding("{aam: {images: 300.0}}"), "`codings.aam51.aam.images: 300.0` must be a whole number, .*; write 300"),
        (
            coding("{texture: {texture_pixels: 40000}}"),
            "`codings.aam51.texture.texture_pixels: 40000` must be at least 100 and at most 30000. Approximate number",
        ),
        ("pose: {focal_length: wide}", "must be a number, at least 0.1 and at most 1000. Assumed focal length"),
        (
            system("{training: {learning_rate: 0}}"),
            "learning_rate: 0` must be above 0 and at most 1. Step size",
        ),
        (system("{training: {learning_rate: 1e-3}}"), "learning_rate: 1e-3` must be a number, .*; write 0.001"),
        (system("{training: {learning_rate: 1e-6}}"), "learning_rate: 1e-6` must be a number, .*; write 0.000001"),
        (system("{training: {learning_rate: .nan}}"), "rate: .nan` must be a number, above 0 and at most 1. "),
        (system("{training: {max_grad_norm: .inf}}"), "training.max_grad_norm: .inf` must be a number, at least 0"),
        (system("{training: {dropout: 1}}"), "training.dropout: 1` must be at least 0 and below 1"),
        (system("{training: {ema_decay: 1.5}}"), "training.ema_decay: 1.5` must be at least 0 and below 1"),
        (system("{training: {max_epochs: 0}}"), "training.max_epochs: 0` must be at least 1"),
        (system("{training: {optimiser: sgd}}"), "training.optimiser: sgd` must be one of adam, paper"),
        (system("{training: [1]}"), r"training: \[1\]` must be lines of `key: value`"),
        (system("{tables: {comparison: {level: 5}}}"), "tables.comparison.level: 5` must be above 0 and below 1"),
        (system("{tables: {comparison: {level: high}}}"), "level: high` must be a number, above 0 and below 1. "),
        (
            system("{tables: {comparison: {test: t}}}"),
            "comparison.test: t` must be one of wilcoxon, permutation",
        ),
        ("speak: {sentences: []}", r"`speak.sentences: \[\]` must have at least 1 entry. What the target speak says"),
        ("speak: {sentences: ['']}", "`speak.sentences.0: ''` must not be empty"),
        ("speak: {sentences: [no]}", "`speak.sentences.0: false` must be a text .*put a text in quotes"),
        ("speak: {sentences: [12]}", r"`speak.sentences.0: 12` must be a text \(put it in quotes\)"),
        ("speak: {voice: {pitch: 200}}", "`speak.voice.pitch: 200` must be at least 0 and at most 100. Pitch"),
        ("corpora: [{name: x, adapter: folder, root: 5}]", "`corpora.x.root: 5` must be a text"),
        ("no: 3", "unknown setting `False`"),
    ],
)
def test_every_mistake_is_a_sentence(overlay, said):
    with pytest.raises(SettingError, match=said) as told:
        configs.resolved(overlay)
    assert len(str(told.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"energy": 0.9, "components": 3}, "must have either `energy` or `components`. Components of the shape"),
        ({"components": 3, "at_most": 5}, "has `at_most`, which goes with `energy` alone. Components"),
    ],
)
def test_components_of_an_analysis_are_said_in_one_way(wrong, said):
    mine = {"name": "mine", "kind": "aam", "points": "lower_face_51", "aam": {"shape": wrong}}
    with pytest.raises(SettingError, match=said):
        configs.resolved({"systems": [{"name": "x", "extends": "fan2015", "coding": mine}]})


def test_all_mistakes_are_told_at_once():
    with pytest.raises(SettingError) as told:
        configs.resolved("{shards: 0, pose: {focal_length: 0}, speak: {sentences: ['', 3]}}")
    lines = str(told.value).splitlines()
    assert [line.split("`")[1] for line in lines] == [
        "pose.focal_length: 0", "shards: 0", "speak.sentences.0: ''", "speak.sentences.1: 3",
    ]  # fmt: skip
    with pytest.raises(SettingError) as told:
        configs.resolved(system("{rate: -1, training: {dropout: 1}}"))
    assert len(str(told.value).splitlines()) == 2


def test_all_missing_keys_are_one_sentence():
    with pytest.raises(SettingError) as told:
        check({}, {"type": "object", "required": ["a", "b"]})
    assert str(told.value) == "`the configuration` lacks `a`, `b`."


def test_what_is_written_as_told_is_taken():
    rows = configs.resolved(system("{training: {learning_rate: 0.000001, max_grad_norm: 0, ema_decay: 0}}"))
    training = rows["systems"]["fan2015"]["rows"][0]["training"]
    assert training["learning_rate"] == 1e-6 and not math.isnan(training["max_grad_norm"])


def test_a_corpus_file_with_a_root_that_is_no_text(tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\nadapter: folder\nroot: 5\n")
    with pytest.raises(SettingError, match="`corpora.mine.root: 5` must be a text"):
        configs.resolved({"corpora": str(tmp_path / "mine.yaml")})


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
  model: {type: object, properties: {low: {settings: "visualspeech.models.lookup_settings:LookupSettings"}, free: {}}}
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
    low = {"context": "triphone", "min_count": 3}
    assert filled["models"] == {"a": {"low": low}, "b": {"low": {**low, "min_count": 7}}}
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
