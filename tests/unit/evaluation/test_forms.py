"""Tables in every form: rectangular, escaped, nested as they must be, and with the same figures."""

import re

import pandas
import pytest

from tests.unit.evaluation.nesting import check_nesting
from visualspeech.errors import StorageError
from visualspeech.evaluation.forms import all_forms, fragment_of, to_html, to_html_page, to_markdown
from visualspeech.evaluation.latex import to_latex
from visualspeech.evaluation.layout import Cell, Row, Table, best_of, interval, shown
from visualspeech.evaluation.metrics import METRICS

NASTY = "50 % & <b>_x_|$#[1]"
TABLE = Table(
    title=f"Title {NASTY}",
    columns=("a", "b", "a", NASTY),
    rows=(
        Row(f"heading {NASTY}"),
        Row("one", (Cell("1.0", "± 0.1", best=True), Cell(""), Cell("2.0", collapsed=True), Cell(NASTY, NASTY))),
        Row(NASTY, (Cell("1"), Cell("2"), Cell("3"), Cell("4", best=True, collapsed=True)), "floor"),
    ),
    groups=(("128", 2), ("256", 2)),
    facts=(("corpus", NASTY),),
    notes=(NASTY,),
    definitions=((NASTY, NASTY),),
    corner="Nodes",
)
PLAIN = Table("Plain", ("x",), (Row("r", (Cell("1"),), "baseline"),))


def test_markdown_is_rectangular_and_marked():
    text = to_markdown([TABLE, PLAIN])
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert [len(re.findall(r"(?<!\\)\|", line)) for line in lines] == [6, 6, 6, 6, 6, 3, 3, 3]
    assert "| Nodes | 128 a | 128 b | 256 a |" in text and "| **heading 50 %" in text
    assert "**1.0** ± 0.1 | – | *2.0†* |" in text and "***4†***" in text
    assert "<b>" not in text


def test_latex_balances_and_is_rectangular():
    text = to_latex([TABLE, PLAIN])
    assert all(ord(sign) < 128 for sign in text)
    plain = re.sub(r"\\[{}]", "", text)
    assert plain.count("{") == plain.count("}")
    rows = [line for line in text.splitlines() if line.endswith(r"\\") and line.startswith(("one", "50", " &"))]
    assert len(rows) == 4 and {len(re.findall(r"(?<!\\)&", line)) for line in rows} == {1, 4}
    assert r"\multicolumn{2}{c}{256}" in text and r"\textbf{\textit{4\textdagger{}}}" in text
    assert r"\multicolumn{5}{l}{\itshape heading 50 \%" in text


def test_html_nests_and_escapes():
    text = to_html_page([TABLE, PLAIN], NASTY)
    assert "<b>_x_" not in text and "http" not in text
    check_nesting(text)
    assert text.count("<th ") == 1 + 2 + 4 + 3 + 1 + 1 + 1 and 'colspan="2">256<' in text
    assert 'colspan="5">heading' in text and '<tr class="floor">' in text and '<tr class="baseline">' in text
    assert text.count("<dt>") == 1


def test_a_page_gives_its_tables_back():
    assert fragment_of(to_html_page([TABLE, PLAIN], NASTY)) == to_html([TABLE, PLAIN])
    with pytest.raises(StorageError, match="not a page of tables"):
        fragment_of("<html></html>")


def test_the_tsv_is_read_by_others(tmp_path):
    texts = all_forms(pandas.DataFrame({"row": ["a"], "value": [0.1]}), [TABLE], "Title")
    assert texts[1:] == (to_markdown([TABLE]), to_latex([TABLE]), to_html_page([TABLE], "Title"))
    (tmp_path / "t.tsv").write_text(texts[0], encoding="utf-8")
    assert pandas.read_csv(tmp_path / "t.tsv", sep="\t", comment="#")["value"][0] == 0.1
    assert texts[0].startswith("# corpus: 50 %")


def test_figures_as_shown():
    assert shown(-0.0001, 3) == "0.000" and shown(1.23456, 2) == "1.23" and shown(float("nan"), 3) == ""
    assert interval("1", "2") == "[1, 2]" and interval("", "2") == ""


def test_the_best_are_those_that_no_other_beats():
    assert best_of(METRICS["rmse_shape"], {"a": "1.0", "b": "1.0", "c": "1.1", "d": ""}) == {"a", "b"}
    assert best_of(METRICS["corr"], {"a": "0.1", "b": "0.2"}) == {"b"}
    assert best_of(METRICS["gv_ratio"], {"a": "0.9", "b": "1.1", "c": "0.8"}) == {"a", "b"}
    assert best_of(METRICS["corr"], {"a": "0.1", "b": ""}) == set()
