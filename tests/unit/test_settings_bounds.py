"""Every setting is bounded, and no value of any kind is answered by anything but acceptance or sentences."""

import importlib
import json
import pkgutil
import re
import re._parser as regular

import pytest

import visualspeech
from tests.paths import REPOSITORY
from tests.settings_cases import CONFIG, VALUES, cases, keys, outcome
from tests.unit.planning.configs import config, resolved
from visualspeech.errors import SettingError
from visualspeech.features.blocks.base import block_kinds
from visualspeech.fields import Settings, section_schema
from visualspeech.models.entries import entry_schema
from visualspeech.models.families import FAMILIES
from visualspeech.models.registry import MOST_ROWS
from visualspeech.planning.run import resolve
from visualspeech.planning.systems import block_schema
from visualspeech.schema import load_schema
from visualspeech.settings import MAX_BYTES, check_overlays, main, plain_data, read_yaml


def settings_classes(cls=Settings):
    for module in pkgutil.walk_packages(visualspeech.__path__, "visualspeech."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    return {
        one
        for sub in cls.__subclasses__()
        if sub.__module__.startswith("visualspeech.")
        for one in (sub, *sub.__subclasses__())
    }


def schemas():
    found = {path.name: load_schema(path) for path in (REPOSITORY / "workflow" / "schemas").glob("*.yaml")}
    found |= {cls.__name__: section_schema(cls) for cls in settings_classes()}
    found |= {f"family {name}": entry_schema(name, {"letters": ["F"], "nodes": [1]}, ["tri"]) for name in FAMILIES}
    return found | {f"block {kind}": block_schema(kind) for kind in block_kinds()}


def nodes(node, path):
    yield path, node
    for key, inner in node.get("properties", {}).items():
        yield from nodes(inner, f"{path}.{key}")
    for key in ("items", "additionalProperties", "propertyNames"):
        if isinstance(node.get(key), dict):
            yield from nodes(node[key], f"{path}.{key}")


def unbounded(node):
    """Kinds of value of which a schema takes any amount."""
    if "enum" in node:
        return []
    kinds = node.get("type", [])
    kinds = {kinds} if isinstance(kinds, str) else set(kinds)
    pattern = node.get("pattern")
    longest = regular.parse(pattern).getwidth()[1] if pattern else regular.MAXREPEAT
    limited = {
        "number": bool({"minimum", "exclusiveMinimum"} & set(node))
        and bool({"maximum", "exclusiveMaximum"} & set(node)),
        "string": "maxLength" in node or longest < 10_000,
        "array": "maxItems" in node,
        "object": node.get("additionalProperties") is False or "maxProperties" in node or "training" in str(node),
    }
    limited["integer"] = limited["number"]
    return sorted(kind for kind in kinds if not limited.get(kind, True))


def test_every_setting_has_bounds():
    found = {path: unbounded(node) for name, schema in schemas().items() for path, node in nodes(schema, name)}
    assert len(found) > 300 and {path: kinds for path, kinds in found.items() if kinds} == {}


def test_patterns_refuse_a_line_break_at_the_end():
    for name, schema in schemas().items():
        for path, node in nodes(schema, name):
            if "pattern" in node:
                assert not re.search(node["pattern"], "name\n") and not node["pattern"].endswith("$"), path


LIMITS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")


def bounds_of(node):
    """The bounds of a number as a message writes them."""
    return [str(node[name]) for name in LIMITS if name in node]


def test_extreme_values_are_accepted_or_refused_in_sentences():
    tried, accepted, named = 0, 0, 0
    for case in cases(seed=8, count=1200):
        told = outcome(case)
        tried, accepted = tried + 1, accepted + (told.kind == "accepted")
        assert told.kind != "crashed" and told.seconds < 5, (case.key, case.value, told)
        if told.kind != "refused":
            continue
        key = case.key.rpartition(".")[2]
        # A change of models or blocks can be a mistake of what names them.
        others = "systems.fan2015." if case.key.startswith(("models.", "blocks.", "systems.fan2015.")) else "split"
        assert key in told.message or others in told.message, (case.key, case.value, told.message)
        assert len(told.message) < 20_000 and "Traceback" not in told.message
        assert told.message.rstrip().endswith(("?", ".")), told.message
        if isinstance(case.value, float | int) and case.node.get("type") in ("integer", "number"):
            line = next((one for one in told.message.splitlines() if f"{key}: " in one), "")
            if " must be " in line:  # not what goes with other keys
                assert all(bound in line for bound in bounds_of(case.node)), line
                named += 1
    assert tried == 1200 and accepted > 20 and named > 100 and len(keys()) > 200 and len(VALUES) > 40


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"seed": 10**24}, "`seed: 1000000000000000000000000` must be at least 0 and at most 999999999"),
        ({"seed": 10**4000}, "`seed` is a number of hundreds of digits"),
        ({"seed": "1e999999999"}, "`seed: 1e999999999` must be a whole number"),
        ({"results": "a{b}"}, "without line breaks, braces"),
        ({"results": "/".join(["r" * 200] * 4 + ["r" * 150])}, ""),
        ({"results": "r" * 300}, "`results`: the name rrrr.* has more than 255 bytes"),
        ({"corpora": {"name": "a" * 300, "adapter": "demo"}}, "`corpora.name: a* ...` must be of this form"),
        ({"corpora": {"name": "a\n", "adapter": "demo"}}, "must be of this form"),
        ({"corpora": {"name": "a", "adapter": "folder", "root": "x" * 5000}}, "at most 1000 characters"),
        ({"corpora": {"name": "a", "adapter": "folder", "root": "~nobodyhere/x"}}, "there is no user 'nobodyhere'"),
        ({"corpora": {"name": "a", "adapter": "folder", "root": "x" * 300}}, "corpora.a.root.*more than 255 bytes"),
        ({"corpora": "x" * 300 + ".yaml"}, "File name too long"),
        ({"override": {"systems": {"fan2015": {"rate": 1e-9}}}}, "rate: 1e-09` must be 0, .* at least 1"),
        ({"override": {"systems": {"fan2015": {"seeds": list(range(100)), "models": {"nets": {
            "nodes": list(range(1, 21))}}}}}}, f"more than {MOST_ROWS} rows"),
        ({"speak": {"voice": {"voice": "a b\n"}}}, "speak.voice.voice"),
        ({"speak": {"file": "a\0b"}}, r"`speak.file` holds the character U\+0000"),
        ({"speak": {"sentences": ["\ud800"]}}, r"`speak.sentences.0` holds the character U\+D800"),
        ({"speak": {"sentences": 2 * [{1, 2}]}}, "is a set"),
    ],
    ids=lambda value: repr(value)[:40].encode("ascii", "replace").decode(),
)  # fmt: skip
def test_what_used_to_be_found_out_in_a_job(change, said):
    if not said:
        assert resolved(change)["results"]
        return
    with pytest.raises(SettingError, match=said):
        resolved(change)


def test_results_are_never_written_among_recordings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "clips" / "inner").mkdir(parents=True)
    (tmp_path / "link").symlink_to("clips")
    corpus = {"name": "mine", "adapter": "folder", "root": "clips"}
    assert resolved({"corpora": corpus})
    for results in ("clips", "clips/inner", "link", str(tmp_path / "clips" / "new"), "clips/../clips"):
        with pytest.raises(SettingError, match="`corpora.mine.root: clips`: the results would be written among"):
            resolved({"corpora": corpus, "results": results})
    for root in (".", "results/mine", "results/mine/x"):
        with pytest.raises(SettingError, match="the results would be written among"):
            resolved({"corpora": {**corpus, "root": root}})
    monkeypatch.setenv("GRID_ROOT", str(tmp_path))
    with pytest.raises(SettingError, match=f"`GRID_ROOT: {tmp_path}`"):
        resolved({"corpora": "grid"})
    (tmp_path / "results" / "demo").mkdir(parents=True)
    with pytest.raises(SettingError, match="`speak.file: results/demo/said.txt` lies among the results"):
        resolved({"speak": {"file": "results/demo/said.txt"}})
    with pytest.raises(SettingError, match="corpora.mine.table: .* lies among the results"):
        resolved({"corpora": {**corpus, "table": str(tmp_path / "results" / "mine" / "t.tsv")}})


LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"a: 1\nb: 2\na: 3\n", "the key `a` is given twice, in line 1 and in line 3"),
        (b"a:\n  b: {c: 1, d: 2, c: 3}\n", "the key `c` is given twice, in line 2 and in line 2"),
        (b"x: [{a: 1, a: 1}]\n", "the key `a` is given twice"),
        (b"a: &a [*a]\n", "line 1: an alias contains itself"),
        (b"a: &a {b: *a}\n", "line 1: an alias contains itself"),
        (LAUGHS.encode(), "more than 20,000 values"),
        (b"a: " + b"[" * 40 + b"]" * 40, "nested too deeply"),
        (b"a: " + b"[" * 2000 + b"]" * 2000, "nested too deeply"),
        (b"a: !!python/object/apply:os.system [ls]\n", "is not YAML"),
        (b"a: !!python/name:os.system\n", "is not YAML"),
        (b"a: !!int x\n", "is not YAML"),
        (b"a: !!bool x\n", "is not YAML"),
        (b"a: !!timestamp x\n", "is not YAML"),
        (b"a: 2020-99-99\n", "is not YAML"),
        (b"a: " + b"9" * 5000, "is not YAML"),
        (b"[1]: x\n", "a list or mapping is no possible key"),
        (b"? {a: 1}\n: x\n", "a list or mapping is no possible key"),
        (b"a: 'Andr\xe9'\n", "byte 8 is not UTF-8 text. Save the file in the encoding UTF-8"),
        ("a: 1\n".encode("utf-16"), "is not UTF-8"),
        (b"a: x\0y\n", "is not YAML"),
        (b"\ta: 1\n", "is not YAML"),
        (b"a: 1\n--- \nb: 2\n", "is not YAML"),
        (b"", "must hold `key: value` lines"),
        (b"- 1\n", "must hold `key: value` lines"),
        (b"a: 1 #" + b" " * MAX_BYTES, "settings files have at most 500,000"),
    ],
    ids=lambda value: repr(value)[:40].encode("ascii", "replace").decode(),
)  # fmt: skip
def test_files_that_are_refused(tmp_path, content, said):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    for read in (read_yaml, lambda path: check_overlays([path])):
        with pytest.raises(SettingError, match=re.escape(said) if "byte" not in said else said) as told:
            read(path)
        assert "mine.yaml" in str(told.value) and len(str(told.value)) < 1000 and "\n" not in str(told.value)


@pytest.mark.parametrize(
    "content",
    [
        b"a: 1\r\nb: {c: 2}\r\n", b"\xef\xbb\xbfa: 1\nb: {c: 2}\n", b"b: &b {c: 2}\na: 1\n",
        b"base: &x {c: 2}\nb: *x\n",
        b"base: &x {c: 1}\nb: {<<: *x, c: 2}\n",
    ],
    ids=lambda value: repr(value)[:40].encode("ascii", "replace").decode(),
)  # fmt: skip
def test_files_that_are_read(tmp_path, content):
    path = tmp_path / "mine.yaml"
    path.write_bytes(content)
    assert read_yaml(path)["b"] == {"c": 2}
    check_overlays([path])


def test_overlays_may_be_json_but_give_each_key_once(tmp_path):
    path = tmp_path / "mine.json"
    path.write_text('{\n\t"seed": 1,\n\t"split": {"train": 0.5}}')
    check_overlays([path])
    path.write_text('{"split": {"train": 0.5, "train": 0.6}}')
    with pytest.raises(SettingError, match="mine.json: the key `train` is given twice"):
        check_overlays([path])
    path.write_text(json.dumps({"__use_yte__": True}))
    with pytest.raises(SettingError, match="templates are no settings files"):
        check_overlays([path])
    for wrong in (tmp_path, tmp_path / "nowhere.yaml", "a\0b"):
        with pytest.raises(SettingError, match="cannot read"):
            check_overlays([wrong])


def test_files_can_be_checked_before_a_run(tmp_path, capsys):
    (tmp_path / "a.yaml").write_text("seed: 1\n")
    (tmp_path / "b.yaml").write_text("seed: [1\n")
    assert main([str(tmp_path / "a.yaml")]) == 0 and "1 file is well-formed" in capsys.readouterr().out
    assert main([str(tmp_path / "a.yaml"), str(tmp_path / "b.yaml")]) == 2
    assert re.search(r"b.yaml is not YAML: .*line 2", capsys.readouterr().err)


@pytest.mark.parametrize("key", ["yes", "1", "null", "~", "2020-01-01", "1.5"])
def test_keys_that_are_no_texts_are_unknown_settings(tmp_path, key):
    path = tmp_path / "mine.yaml"
    path.write_text(f"{key}: x\n")
    with pytest.raises(SettingError, match="unknown setting `"):
        resolve(config(path), CONFIG)


def test_plain_data_ends_on_endless_settings():
    endless: dict = {}
    endless["a"] = endless
    for wrong in (endless, {"a": [endless]}):
        with pytest.raises(SettingError, match="nested too deeply"):
            plain_data(wrong)
    assert plain_data({"a": (1, {"b": None})}) == {"a": [1, {"b": None}]}
