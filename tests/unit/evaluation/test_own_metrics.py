"""Measures of the user's own: figures, intervals and tests as of built-in ones, and a sentence for each mistake."""

import re

import numpy as np
import pytest

from tests.paths import REPOSITORY
from tests.unit.evaluation.examples import stack
from visualspeech.errors import DataError
from visualspeech.evaluation.comparisons import compare
from visualspeech.evaluation.measured import MeasuredRows
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.own_functions import with_own
from visualspeech.evaluation.own_metrics import register
from visualspeech.evaluation.scoring import FaceSequence, score, score_table
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings, result_tables
from visualspeech.models.rows import ModelRow
from visualspeech.planning.own_metrics import described

SOURCE = """import numpy as np

def own_rmse(predicted, true):
    "As rmse_first5."
    return np.sqrt(np.mean((predicted - true)[:, :5] ** 2, axis=0)).mean()

def extent(predicted, true, predicted_points, true_points, rate):
    return predicted_points.sum() - true_points.sum() + rate

def fails(predicted, true):
    return [][0]

def leaves(predicted, true):
    raise SystemExit

def changes(predicted, true):
    predicted -= 1
    return 0.0

def nothing(predicted, true):
    pass

def many(predicted, true):
    return predicted.mean(axis=0)

def undefined(predicted, true):
    return np.nan

def counts(predicted, true):
    return np.int64(len(true)) > 2
"""
BOOTSTRAP = BootstrapSettings(samples=100, level=0.9, seed=1)


class Arrays:
    """Arrays by utterance, as the readers of this project give them."""

    def __init__(self, arrays):
        self.arrays = arrays

    def array(self, one, name):
        return self.arrays[one][name].copy()

    def rate(self, one):
        return 25.0


class Coding:
    points = None

    def decode_points(self, parameters, speaker):
        assert speaker == "she"
        return np.asarray(parameters)[:, :4].reshape(len(parameters), 2, 2)


@pytest.fixture
def own(tmp_path, monkeypatch):
    """Descriptions of measures of a module in the working folder, by their names; known to this test alone."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", ["", *__import__("sys").path])
    (tmp_path / "mine.py").write_text(SOURCE)
    before = dict(METRICS)
    yield lambda *names: {f"mine:{name}": described(f"mine:{name}", "x") for name in names}
    METRICS.clear()
    METRICS.update(before)


def utterances(seed, count=7):
    rng, found = np.random.default_rng(seed), {}
    for number in range(count):
        found[f"u{number}"] = {"appearance": rng.normal(size=(20 + number, 6)) + 3}
    return found


def measured_row(own, true, seed):
    predicted, targets = Arrays({one: {"appearance": arrays["appearance"] + noise["appearance"] * 0.1 * seed}
                                 for (one, arrays), noise in zip(true.items(), utterances(seed).values(), strict=True)
                                 }), Arrays(true)  # fmt: skip

    def face(values):
        return FaceSequence(values, values, values, np.zeros((len(values), 20, 2)))

    rows = (score(one, face(predicted.array(one, "appearance")), face(arrays["appearance"]), 25.0)
            for one, arrays in true.items())  # fmt: skip
    speakers = dict.fromkeys(true, "she")
    return score_table(with_own(rows, own, predicted, targets, Coding(), speakers))


def test_figures_intervals_and_tests_are_those_of_the_built_in_measure(own):
    given, true = own("own_rmse"), utterances(0)
    register(given)
    mean = ModelRow("base", "Training mean", "mean", role="baseline")
    rows = (stack("a", "F", 8), stack("b", "B", 8), mean)
    found = MeasuredRows(rows, {row.name: measured_row(given, true, seed + 1) for seed, row in enumerate(rows)})
    names = ("rmse_first5", "mine:own_rmse")
    frame, tables = result_tables(found, (), TableSettings(names, digits=9), BOOTSTRAP)
    for part in ("", "_low", "_high", "_ratio", "_ratio_low"):
        assert list(frame[f"{names[0]}{part}"]) == list(frame[f"{names[1]}{part}"])
    assert tables[0].columns[1] == "Own rmse\u00a0↓" and ("Own rmse", "As rmse_first5; mean over utterances of the "
                                                          "figure of each.") in tables[1].definitions  # fmt: skip
    tested = compare(found, names, bootstrap=BOOTSTRAP)
    one, other = (tested[tested["metric"] == name].drop(columns="metric").reset_index(drop=True) for name in names)
    assert list(one["p"]) == list(other["p"]) and list(one["better"]) == list(other["better"])
    numbers = ["first_value", "difference", "low", "high", "p_holm"]
    np.testing.assert_allclose(one[numbers], other[numbers], rtol=1e-12)


def test_points_and_rate_are_given_where_they_are_asked_for(own):
    table = measured_row(own("extent"), true := utterances(0), 1)
    predicted = true["u0"]["appearance"] + utterances(1)["u0"]["appearance"] * 0.1
    expected = predicted[:, :4].sum() - true["u0"]["appearance"][:, :4].sum() + 25
    assert table["mine:extent_sum"][0] == pytest.approx(expected) and (table["utterances"] == 1).all()


def test_the_example_of_the_documents_runs(own, tmp_path):
    text = (REPOSITORY / "docs" / "tables.md").read_text(encoding="utf-8")
    (tmp_path / "jaw.py").write_text(re.search(r"```python\n(# jaw.py\n.*?)```", text, re.DOTALL)[1])
    given = {"jaw:jaw_error": described("jaw:jaw_error", "x")}
    assert (given["jaw:jaw_error"]["title"], given["jaw:jaw_error"]["unit"]) == ("Jaw error", "px")
    figures = measured_row(given, utterances(0), 1)["jaw:jaw_error_sum"]
    assert (figures > 0).all() and (measured_row(given, utterances(0), 0)["jaw:jaw_error_sum"] == 0).all()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("fails", r"failed on the utterance u0: IndexError: list index out of range \(mine.py, line 11\)"),
        ("leaves", r"failed on the utterance u0: SystemExit: no message \(mine.py, line 14\)"),
        ("changes", r"failed on the utterance u0: ValueError: .*read-only \(mine.py, line 17\)"),
        ("nothing", "gave NoneType for the utterance u0; it must return one number"),
        ("many", r"gave an array of shape \(6,\) for the utterance u0"),
        ("undefined", "gave nan for the utterance u0, 20 frames; it must return a finite number"),
    ],
)
def test_every_mistake_is_a_sentence(own, name, said):
    with pytest.raises(DataError, match=rf"the measure `mine:{name}` {said}"):
        measured_row(own(name), utterances(0), 1)


def test_a_truth_value_is_a_number(own):
    assert (measured_row(own("counts"), utterances(0), 1)["mine:counts_sum"] == 1).all()


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("import nowhere_at_all\n", r"ModuleNotFoundError: No module named 'nowhere_at_all' \(mine.py, line 1\)"),
        ("raise SystemExit(3)\n", r"SystemExit: 3 \(mine.py, line 1\)"),
        ("def own_rmse(a, b): pass\nown_rmse = 3\n", "is no function after its module was imported"),
    ],
)
def test_a_module_that_cannot_be_imported_is_a_sentence(own, tmp_path, source, said):
    given = own("own_rmse")
    (tmp_path / "mine.py").write_text(source)
    with pytest.raises(DataError, match=said):
        measured_row(given, utterances(0), 1)


def test_modules_beside_it_are_found_and_names_of_the_library_are_no_trap(own, tmp_path):
    (tmp_path / "beside_it.py").write_text("value = 4.0\n")
    (tmp_path / "json.py").write_text("from beside_it import value\ndef f(a, b):\n    return value\n")
    given = {"json.py:f": described("json.py:f", "x")}
    assert (measured_row(given, utterances(0), 1)["json.py:f_sum"] == 4).all()
    assert __import__("json").dumps(1) == "1"


def test_a_measure_of_a_package_may_import_from_it(own, tmp_path, monkeypatch):
    (tmp_path / "own_pack").mkdir()
    (tmp_path / "own_pack" / "__init__.py").write_text("")
    (tmp_path / "own_pack" / "part.py").write_text("value = 5.0\n")
    (tmp_path / "own_pack" / "inner.py").write_text("from .part import value\ndef f(a, b):\n    return value\n")
    given = {"own_pack.inner:f": described("own_pack.inner:f", "x")}
    assert (measured_row(given, utterances(0), 1)["own_pack.inner:f_sum"] == 5).all()
    digest = given["own_pack.inner:f"]["digest"]
    (tmp_path / "own_pack" / "part.py").write_text("value = 6.0\n")
    assert described("own_pack.inner:f", "x")["digest"] != digest
