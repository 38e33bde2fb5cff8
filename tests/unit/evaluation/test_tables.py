"""One definition, four forms: what they show, what they escape, and that they say the same."""

import re

import pandas
import pytest

from tests.unit.evaluation.nesting import check_nesting
from visualspeech.errors import DataError, SettingError, StorageError
from visualspeech.evaluation import table_formats as formats
from visualspeech.evaluation.metrics import METRICS
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableFacts, TableSettings, result_table

FACTS = TableFacts("demo", "fan2015", "0123456789ab", "silence")
BOOTSTRAP = BootstrapSettings(samples=200, level=0.9, seed=1)


def measured(scale, corr=0.5, kept=0.5, undefined=0):
    utterances = 6
    columns = {"id": [f"u{i}" for i in range(utterances)], "frames": [10 + i for i in range(utterances)]}
    for name in METRICS:
        columns[name] = [scale * (1 + 0.1 * i) for i in range(utterances)]
    columns["corr"] = [corr] * utterances
    columns["variance_kept"] = [kept] * utterances
    columns |= {"corr_undefined": [undefined] * utterances, "true_scatter": [2.0] * utterances}
    return pandas.DataFrame(columns)


def rows():
    return {
        "training_mean": measured(2.0, 0.0, 0.0, undefined=3),
        "aam_reconstruction": measured(0.1, 1.0, 1.0),
        "FBB-128": measured(1.0, 0.7, 0.8),
        "BFF-128": measured(1.1, 0.7, 1.3),
        "triphone_state_mean": measured(1.2, 0.6, 1.1),
        "phone_state_mean": measured(1.5, 0.4, 0.5),
    }


def made(settings=None, tables=None):
    return result_table(tables or rows(), FACTS, settings, BOOTSTRAP)


def test_networks_first_then_baselines_then_floor():
    assert made().rows == (
        "FBB-128", "BFF-128", "training_mean", "phone_state_mean", "triphone_state_mean", "aam_reconstruction",
    )  # fmt: skip


def test_facts_say_what_was_measured_on_what():
    facts = dict(made().facts)
    assert facts["corpus"] == "demo" and facts["experiment"] == "fan2015" and facts["split"] == "0123456789ab"
    assert facts["drift removal"] == "silence"
    assert facts["test utterances"] == "6" and facts["test frames"] == "75"
    assert "90 %" in facts["intervals"] and "200 samples" in facts["intervals"]
    assert facts["frames with undefined correlation, counted as 0"] == "training_mean 18"


def test_best_is_marked_ties_too_and_the_floor_never():
    best = made().best
    assert ("FBB-128", "rmse_shape") in best and ("BFF-128", "rmse_shape") not in best
    assert {row for row, metric in best if metric == "corr"} == {"FBB-128", "BFF-128"}
    assert {row for row, metric in best if metric == "variance_kept"} == {"triphone_state_mean"}
    assert not [row for row, _ in best if row == "aam_reconstruction"]


def test_ratios_to_the_training_mean():
    table = made()
    assert table.cells["FBB-128", "rmse_shape"]["ratio"] == "0.500"
    assert table.cells["training_mean", "rmse_shape"]["ratio"] == "1.000"
    assert table.cells["FBB-128", "corr"]["ratio"] == ""  # the training mean's is 0


def test_settings_choose_metrics_and_digits():
    settings = TableSettings(("corr", "rmse_shape"), 2, ratio_digits=1)
    cells = made(settings).cells
    assert {metric for _, metric in cells} == {"corr", "rmse_shape"}
    assert cells["FBB-128", "corr"]["value"] == "0.70"
    assert re.fullmatch(r"\d\.\d{2}", cells["FBB-128", "rmse_shape"]["value"])
    assert cells["FBB-128", "rmse_shape"]["ratio"] == "0.5"
    assert made(TableSettings(("corr",), 0)).cells["FBB-128", "corr"]["value"] == "1"
    assert dict(made(TableSettings(("rmse_shape",))).facts).keys() == {
        "corpus", "experiment", "split", "drift removal", "test utterances", "test frames", "intervals",
    }  # fmt: skip


def test_no_negative_zero():
    tables = {"training_mean": measured(1.0, -0.0001)}
    assert made(TableSettings(("corr",)), tables).cells["training_mean", "corr"]["value"] == "0.000"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"metrics": ("rmse_shap",)}, "tables.metrics.*one of rmse_shape"),
        ({"metrics": ()}, "at least 1 entry"),
        ({"digits": -1}, "tables.digits"),
        ({"digits": "3"}, "tables.digits"),
        ({"digits": True}, "tables.digits"),
        ({"digits": {"corr": 1}}, "tables.digits"),
        ({"ratio_digits": 99}, "tables.ratio_digits"),
    ],
)
def test_wrong_settings_are_named(wrong, message):
    with pytest.raises(SettingError, match=message):
        TableSettings(**wrong)


def test_missing_training_mean_is_named():
    with pytest.raises(DataError, match="training_mean"):
        made(tables={"FBB-128": measured(1.0)})


def test_tsv_reads_back_to_the_same_table_in_every_form():
    table = made()
    text = formats.to_tsv(table)
    again = formats.from_tsv(text)
    assert again == table
    for form in (formats.to_tsv, formats.to_markdown, formats.to_latex, formats.to_html_page):
        assert form(again) == form(table)


def test_tsv_is_read_by_others(tmp_path):
    (tmp_path / "t.tsv").write_text(formats.to_tsv(made()), encoding="utf-8")
    table = pandas.read_csv(tmp_path / "t.tsv", sep="\t", comment="#", index_col="row")
    assert table.loc["FBB-128", "corr"] == 0.7
    assert table.loc["FBB-128", "rmse_shape_low"] < table.loc["FBB-128", "rmse_shape"]


def test_other_text_is_no_table():
    for text in ("", "row\tnonsense\nFBB\t1\n", "row\tcorr\nFBB\n"):
        with pytest.raises(StorageError, match="not a result table"):
            formats.from_tsv(text)


def test_every_form_shows_every_figure():
    table = made()
    for form in (formats.to_tsv, formats.to_markdown, formats.to_latex, formats.to_html):
        text = form(table)
        for cells in table.cells.values():
            assert all(figure in text for figure in cells.values())
        assert "0123456789ab" in text and "silence" in text


def test_markdown_tables_are_rectangular():
    lines = [line for line in formats.to_markdown(made()).splitlines() if line.startswith("|")]
    assert {len(re.findall(r"(?<!\\)\|", line)) for line in lines} == {len(METRICS) + 2}
    assert any("**0.700**" in line and line.startswith("| FBB-128") for line in lines)


def test_latex_balances_and_escapes():
    facts = TableFacts("50 % & more_$#{}~^\\", "fan2015", "ab", "none")
    text = formats.to_latex(result_table(rows(), facts, None, BOOTSTRAP))
    assert r"50 \% \& more\_\$\#\{\}\textasciitilde{}\textasciicircum{}\textbackslash{}" in text
    plain = re.sub(r"\\[{}]", "", text)
    assert plain.count("{") == plain.count("}")
    body = text[text.index(r"\toprule") : text.index(r"\bottomrule")]
    for line in body.splitlines():
        if line.endswith(r"\\") and "multicolumn" not in line:
            assert len(re.findall(r"(?<!\\)&", line)) == len(METRICS)
    assert all(ord(sign) < 128 for sign in text)


def test_html_escapes_and_nests():
    facts = TableFacts("<script>alert(1)</script>", 'a"b', "ab", "none")
    text = formats.to_html_page(result_table(rows(), facts, None, BOOTSTRAP))
    assert "<script" not in text and "&lt;script&gt;" in text
    assert "http" not in text

    check_nesting(text)


def test_same_input_same_text():
    assert formats.to_html(made()) == formats.to_html(made())
