"""Keys at the wrong place of a run's settings: the message says what to write, and what it says works."""

import re

import pytest
import yaml
from snakemake.cli import parse_config

from tests.unit.planning.configs import config, resolved
from visualspeech.errors import SettingError
from visualspeech.settings import from_command_line, merged, typed


@pytest.mark.parametrize(
    "given",
    [
        "features: {rate: 50}",
        "rate: 50",
        "fan2015: {rate: 50}",
        "override: {fan2015: {rate: 50}}",
        "override: {rate: 50}",
    ],
)
def test_the_frame_rate_can_be_written_as_the_message_says(given):
    with pytest.raises(SettingError) as told:
        resolved(given)
    said = str(told.value)
    written = re.search(r"Write `(override: .*?)` in a file", said)[1]
    assert resolved(written)["systems"]["fan2015"]["rate"] == 50
    typed_in = re.search(r"--config (\w+='.*?') on the command line", said)[1].replace("'", "")
    found = parse_config([typed_in])
    assert found["override"]["systems"]["fan2015"]["rate"] == "50"  # Snakemake hands on text
    run = from_command_line(merged(config(), found), found)
    assert run["override"]["systems"]["fan2015"]["rate"] == 50


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("rate: 50", "lay config/two_rates.yaml over a corpus"),
        ("max_epochs: 3", "`override: {systems: {fan2015: {training: {max_epochs: 3}}}}`"),
        ("metrics: [corr]", "`override: {systems: {fan2015: {tables: {metrics: [corr]}}}}`"),
        ("{systems: thangthai2016, rate: 50}", "`override: {systems: {thangthai2016: {rate: 50}}}`"),
        ("{systems: thangthai2016, drift: {}}", "`override: {codings: {aam34: {drift: {}}}}`"),
        ("aam51: {source: fit}", "`override: {codings: {aam51: {source: fit}}}`"),
        ("aam51: 3", "`aam51` is a visual coding, not a setting"),
        ("padding: 0.1", "Write `alignment: {padding: 0.1}` in a file, or --config alignment='{padding: 0.1}'"),
        ("root: /data", "corpora: [{name: mine, adapter: folder, root: /data}]"),
        ("grid: {}", "`grid` is a corpus, not a setting. Select it with `corpora: grid`"),
        ("override: {aam51: {source: fit}}", "`override.aam51` is a visual coding, not a setting."),
        ("features: {rate: 50, colour: 1}", "unknown setting `features`"),
        ("shrads: 3", "Did you mean `shards`?"),
        ("systems: 'fan2015, thangthai2016'", "A list is written [fan2015, thangthai2016]."),
        ("systems: '[fan2015'", "A list is written [fan2015]."),
    ],
)
def test_what_to_write_instead(given, said):
    with pytest.raises(SettingError) as told:
        resolved(given)
    assert said in str(told.value)


def test_all_mistakes_at_once():
    with pytest.raises(SettingError) as told:
        resolved("{rate: 50, shards: 0, override: {fan2015: {rate: 50}, systems: {fan2015: {rat: 1}}}}")
    lines = str(told.value).splitlines()
    assert len(lines) == 4 and lines[0].startswith("`rate`") and "`systems.fan2015.rat`" in lines[3]


def test_values_of_the_command_line_have_the_types_of_yaml():
    given = parse_config(["split={train: 0.8, name: grid, off: null, list: [1, two, ''], flag: true}", "seed=3"])
    run = from_command_line({"split": {"train": "0.8", "test": "0.1"}, "seed": 3, "other": "5"}, given)
    assert run == {"split": {"train": 0.8, "test": "0.1"}, "seed": 3, "other": "5"}
    assert typed(given["split"]) == {"train": 0.8, "name": "grid", "off": None, "list": [1, "two", ""], "flag": True}
    assert typed("2020-01-01") == "2020-01-01" and typed("[1") == "[1" and typed("x: y") == "x: y"
    assert yaml.safe_load("1e3") == typed("1e3")
