"""Settings files: plain data, read and laid over each other."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.settings import merged, read_yaml


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


def test_components_take_the_place_of_an_energy():
    base = {"shape": {"energy": 0.9, "at_most": 5}}
    assert merged(base, {"shape": {"components": 3}}) == {"shape": {"components": 3}}
    assert merged({"shape": {"components": 3}}, base) == base
    assert merged(base, {"shape": {"energy": 0.8}}) == {"shape": {"energy": 0.8, "at_most": 5}}


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
