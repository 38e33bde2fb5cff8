"""Schemas: sections that stand for settings classes, and defaults that are filled in."""

import pytest
import yaml

from tests.paths import REPOSITORY
from visualspeech.errors import SettingError
from visualspeech.planning.run import resolve
from visualspeech.schema import check, fill_defaults, load_schema

CONFIG = REPOSITORY / "config"
SCHEMAS = REPOSITORY / "workflow" / "schemas"
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


def test_the_order_in_which_settings_are_written_does_not_matter(schema):
    one = fill_defaults({"hmm": {"states": 3, "rate": 50.0}, "pairs": {"count": 2}}, schema)
    other = fill_defaults({"pairs": {"count": 2}, "hmm": {"rate": 50.0, "states": 3}}, schema)
    assert repr(one) == repr(other)


@pytest.mark.parametrize(
    "name", ["os:path", "visualspeech.face.head", "visualspeech.nowhere:X", "visualspeech.face.head:X"]
)
def test_a_schema_names_only_classes_of_the_package(tmp_path, name):
    (tmp_path / "schema.yaml").write_text(f'properties: {{a: {{settings: "{name}"}}}}' if ":" in name else
                                          f'properties: {{a: {{settings: "{name}:"}}}}')  # fmt: skip
    with pytest.raises(SettingError, match="the schema names"):
        load_schema(tmp_path / "schema.yaml")


def test_a_run_has_all_defaults_and_they_satisfy_the_schemas():
    settings = resolve(yaml.safe_load((CONFIG / "config.yaml").read_text()), CONFIG)
    fan, aam = settings["systems"]["fan2015"], settings["codings"]["aam51"]
    assert settings["check"]["min_rate"] == 10.0 and fan["tables"]["comparison"]["test"] == "wilcoxon"
    assert settings["speak"]["voice"]["rate_wpm"] == 150
    assert "seed" not in aam["aam"] and all("seed" not in row["training"] for row in fan["rows"])
    run = load_schema(SCHEMAS / "run.schema.yaml")
    named = {"systems": ["fan2015"], "corpora": ["demo"]}
    check({key: value for key, value in settings.items() if key != "codings"} | named, run)
    check(aam, load_schema(SCHEMAS / "coding.schema.yaml"))
    check(settings["corpora"]["demo"], load_schema(SCHEMAS / "corpus.schema.yaml"))
    plain = {key: value for key, value in fan.items() if key not in ("rows", "own_metrics")} | {"models": {}}
    check(plain, load_schema(SCHEMAS / "system.schema.yaml"))
