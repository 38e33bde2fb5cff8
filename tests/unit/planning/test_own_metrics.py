"""Measures of the user's own: found by reading their source, and every mistake in it is a sentence."""

import pytest

from tests.unit.planning.configs import resolved
from visualspeech.errors import SettingError
from visualspeech.planning.own_metrics import described, metric_mistakes

SOURCE = '''import helper

def jaw(predicted, true, true_points, *, rate, weight=2.0):
    """Error of the jaw,
    in pixels.

    More.
    """
    raise RuntimeError("planning does not run this")

jaw.title = "Jaw error"
jaw.unit = "px"
jaw.best = "zero"

def plain_error(predicted, true):
    return 0.0
'''


@pytest.fixture
def mine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(SOURCE)
    (tmp_path / "helper.py").write_text("x = 1\n")
    return tmp_path / "mine.py"


def test_a_measure_is_described_without_running_it(mine):
    found = described("mine:jaw", "x")
    assert found | {"digest": ""} == {
        "file": "mine.py", "root": ".", "module": "mine", "function": "jaw", "takes": ["true_points", "rate"],
        "title": "Jaw error", "unit": "px", "best": "zero",
        "definition": "Error of the jaw, in pixels; mean over utterances of the figure of each", "digest": "",
    }  # fmt: skip
    plain = described("mine.py:plain_error", "x")
    assert (plain["title"], plain["best"], plain["takes"], plain["unit"]) == ("Plain error", "low", [], "")
    assert described(f"{mine}:jaw", "x") == found


def test_a_module_of_a_package_is_found_where_python_finds_it(tmp_path, monkeypatch):
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "inner.py").write_text("def f(a, b):\n    pass\n")
    with pytest.raises(SettingError, match="there is no module pack.inner"):
        described("pack.inner:f", "x")
    monkeypatch.syspath_prepend(str(tmp_path))
    found = described("pack.inner:f", "x")
    assert (found["module"], found["root"]) == ("pack.inner", str(tmp_path))


def test_the_digest_follows_code_and_what_it_imports(mine):
    first = described("mine:jaw", "x")["digest"]
    mine.write_text(SOURCE + "# a comment\n")
    assert described("mine:jaw", "x")["digest"] == first
    (mine.parent / "helper.py").write_text("x = 2\n")
    second = described("mine:jaw", "x")["digest"]
    mine.write_text(SOURCE.replace("0.0", "0.5"))
    assert len({first, second, described("mine:jaw", "x")["digest"]}) == 3


@pytest.mark.parametrize(
    ("name", "source", "said"),
    [
        ("mine:jwa", SOURCE, "`x: mine:jwa`: mine.py has no `def jwa(predicted, true)`. Did you mean `jaw`?"),
        ("mine.py:f", "x = 1", "mine.py has no `def f(predicted, true)`. It defines no function."),
        ("mine:f", "def f(a)", "mine.py, line 1 is no Python: expected ':'."),
        ("mine:f", "def f(a): pass", "`def f(predicted, true)`, with any of predicted_points, true_points, rate after"),
        ("mine:f", "def f(a, b, true_point): pass", "it takes `true_point`. Did you mean `true_points`?"),
        ("mine:f", "def f(*both): pass", "it does not take two arrays by position"),
        ("mine:f", "async def f(a, b): pass", "It defines no function"),
        ("mine:f", "def f(a, b): pass\nf.bst = 'low'", "line 2: `f.bst` is not known. Did you mean `best`?"),
        ("mine:f", "def f(a, b): pass\nf.best = 'lower'", "`f.best` must be one of 'low', 'high', 'one', 'zero'"),
        ("mine:f", "def f(a, b): pass\nf.title = f.__name__", "`f.title` must be a text in quotes"),
        ("mine:f", "def f(a, b): pass\nf.unit = 'a\\nb'", "`f.unit` must be a text in quotes, of one line"),
        ("nine:f", "", "there is no module nine: no nine.py in the working folder"),
        ("nine.py:f", "", "there is no file nine.py"),
        ("my-own:f", "", "must be `module:function` or `path/file.py:function`"),
        ("mine:", "", "mine.py has no `def (predicted, true)`"),
    ],
)
def test_every_mistake_is_a_sentence(mine, name, source, said):
    mine.write_text(source)
    (found,) = metric_mistakes({"metrics": [name]}, "t")
    assert said.replace("`x: ", "`t.metrics.0: ") in found and "\n" not in found


def test_a_file_that_is_no_text_is_a_sentence(mine):
    mine.write_bytes(b"\xff\xfe\x00")
    (found,) = metric_mistakes({"selections": {"one": {"intervals": ["mine:f"]}}}, "t")
    assert found.startswith("`t.selections.one.intervals.0: mine:f`: cannot read mine.py")
    (mine.parent / "deep.py").write_text("x = " + "(" * 2000)
    assert "deep.py" in metric_mistakes({"metrics": ["deep:f"]}, "t")[0]


def test_an_unknown_measure_is_told_beside_all_others():
    (found,) = metric_mistakes({"metrics": ["corr", "cor"], "latex": {"metrics": 3}}, "t")
    assert found.startswith("`t.metrics.1: cor` is no measure. Did you mean `corr`?")
    assert metric_mistakes(None, "t") == metric_mistakes({"metrics": 3, "selections": [1]}, "t") == []


def test_a_system_holds_the_descriptions_of_its_measures(mine):
    tables = {"metrics": ["corr", "mine:jaw"], "latex": {"metrics": ["mine:jaw"], "rows": ["nets"]}}
    system = resolved({"override": {"systems": {"fan2015": {"tables": tables}}}})["systems"]["fan2015"]
    assert list(system["own_metrics"]) == ["mine:jaw"] and system["own_metrics"]["mine:jaw"]["unit"] == "px"
    assert {"FBB-64", "FBB-128"} <= set(system["tables"]["latex"]["rows"])
    tables["latex"]["metrics"] = ["rmse_first5"]
    with pytest.raises(SettingError, match="`systems.fan2015.tables.latex.metrics.0: rmse_first5` is in no table"):
        resolved({"override": {"systems": {"fan2015": {"tables": tables}}}})
