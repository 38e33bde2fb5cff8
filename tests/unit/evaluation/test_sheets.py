"""Sheets in three forms: rectangular, escaped, and nested as they must be."""

import re

import pandas
import pytest

from tests.unit.evaluation.nesting import check_nesting
from visualspeech.errors import StorageError
from visualspeech.evaluation.sheets import (
    Cell,
    Sheet,
    all_forms,
    fragment_of,
    to_html,
    to_html_page,
    to_latex,
    to_markdown,
)

NASTY = "50 % & <b>_x_|$#[1]"
SHEET = Sheet(
    title=f"Title {NASTY}",
    columns=("a", "b", "a", NASTY),
    rows=(
        ("one", (Cell("1.0", "± 0.1", best=True), Cell(""), Cell("2.0", collapsed=True), Cell(NASTY, NASTY))),
        (NASTY, (Cell("1"), Cell("2"), Cell("3"), Cell("4", best=True, collapsed=True))),
    ),
    groups=(("128", 2), ("256", 2)),
    facts=(("corpus", NASTY),),
    notes=(NASTY,),
    corner="Nodes",
)
PLAIN = Sheet("Plain", ("x",), (("r", (Cell("1"),)),))


def test_markdown_is_rectangular_and_marked():
    text = to_markdown([SHEET, PLAIN])
    lines = [line for line in text.splitlines() if line.startswith("|")]
    assert [len(re.findall(r"(?<!\\)\|", line)) for line in lines] == [6, 6, 6, 6, 3, 3, 3]
    assert "| Nodes | 128 a | 128 b | 256 a |" in text
    assert "**1.0** ± 0.1 | – | *2.0†* |" in text and "***4†***" in text
    assert "<b>" not in text


def test_latex_balances_and_is_rectangular():
    text = to_latex([SHEET, PLAIN])
    assert all(ord(sign) < 128 for sign in text)
    plain = re.sub(r"\\[{}]", "", text)
    assert plain.count("{") == plain.count("}")
    rows = [line for line in text.splitlines() if line.endswith(r"\\") and line.startswith(("one", "50", " &"))]
    assert len(rows) == 4 and {len(re.findall(r"(?<!\\)&", line)) for line in rows} == {1, 4}
    assert r"\multicolumn{2}{c}{256}" in text and r"\textbf{\textit{4\textdagger{}}}" in text


def test_html_nests_and_escapes():
    text = to_html_page([SHEET, PLAIN], NASTY)
    assert "<b>_x_" not in text and "http" not in text

    check_nesting(text)
    assert text.count("<th ") == 1 + 2 + 4 + 2 + 1 + 1 + 1 and 'colspan="2">256<' in text


def test_a_page_gives_its_tables_back():
    assert fragment_of(to_html_page([SHEET, PLAIN], NASTY)) == to_html([SHEET, PLAIN])
    with pytest.raises(StorageError, match="no page of tables"):
        fragment_of("<html></html>")


def test_the_tsv_is_read_by_others(tmp_path):
    texts = all_forms(pandas.DataFrame({"row": ["a"], "value": [0.1]}), [SHEET], "Title")
    assert texts[1:] == (to_markdown([SHEET]), to_latex([SHEET]), to_html_page([SHEET], "Title"))
    (tmp_path / "t.tsv").write_text(texts[0], encoding="utf-8")
    assert pandas.read_csv(tmp_path / "t.tsv", sep="\t", comment="#")["value"][0] == 0.1
    assert texts[0].startswith("# corpus: 50 %")
