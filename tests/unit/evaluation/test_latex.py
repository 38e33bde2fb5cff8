"""Tables as LaTeX: what LaTeX reads, and the rows and measures that settings choose."""

import re
import shutil
import subprocess

import numpy as np
import pytest

from tests.unit.evaluation.examples import measured, stack, statistics
from tests.unit.evaluation.test_forms import NASTY, PLAIN, TABLE
from visualspeech.errors import SettingError
from visualspeech.evaluation.comparisons import ComparisonSettings, compare, comparison_tables
from visualspeech.evaluation.latex import LatexSettings, to_latex
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.evaluation.selection_settings import SelectionSettings
from visualspeech.evaluation.selections import selection_frame, selection_tables
from visualspeech.evaluation.statistics import BootstrapSettings
from visualspeech.evaluation.tables import TableSettings, result_tables

BOOTSTRAP = BootstrapSettings(samples=100, level=0.9, seed=1)
FACTS = (("corpus", "my_corpus"), ("system", "fan2015"), ("test utterances", "6"),
         ("intervals", "95 % percentile bootstrap over utterances, 2000 samples, seed 1"))  # fmt: skip


def rows():
    errors = 1 + 0.1 * np.arange(6)
    return measured(
        (stack("F-8", "F", 8), statistics(errors, 0.7, 0.8)),
        (stack("B_8", "B", 8), statistics(1.1 * errors, 0.6, 1.3)),
        ("training_mean", statistics(2.0 * errors, 0.0, 0.0)),
        ("floor", statistics(0.1 * errors, 1.0, 1.0)),
    )


def objective(**settings):
    tables = TableSettings(("rmse_shape", "corr", "lip_distance_px"))
    return to_latex(result_tables(rows(), FACTS, tables, BOOTSTRAP)[1], LatexSettings(**settings))


def read(text):
    """The tables of LaTeX text as (caption, label, rows of cells); a strict reader of what this project writes."""
    assert text.count(r"\begin{table}") == text.count(r"\end{table}") == text.count(r"\end{tabular}}")
    plain = re.sub(r"\\[{}\\%]", "", text)
    assert plain.count("{") == plain.count("}") and plain.count("$") % 2 == plain.count(r"\$") % 2
    found = []
    for part in text.split(r"\begin{table}")[1:]:
        caption, label = (
            re.search(r"^\\caption\{(.*)\}$", part, re.M)[1],
            re.search(r"^\\label\{(.*)\}$", part, re.M)[1],
        )
        width = len(re.search(r"\\begin\{tabular\}\{(l?r*)\}", part)[1])
        lines = [re.split(r"(?<!\\) & ", line[:-3]) for line in part.splitlines() if line.endswith(r" \\")]
        assert all(sum(int((re.match(r"\\multicolumn\{(\d+)", cell) or [0, 1])[1]) for cell in line) == width
                   for line in lines)  # fmt: skip
        found.append((caption, label, lines))
    return found


def test_a_table_has_a_short_caption_a_label_and_its_packages():
    text = objective()
    (caption, label, lines), (second, other, _) = read(text)
    assert text.startswith("% Needs") and r"% \usepackage{booktabs}" in text and r"% \usepackage{graphicx}" in text
    assert caption == (
        r"Objective measures, centred (fan2015 on my\_corpus, 6 test utterances). The best value in each column is "
        r"bold. In brackets: 90 \% percentile bootstrap over utterances."
    )
    assert label == "tab:my-corpus-fan2015-objective-measures-centred" and other.startswith(label + "-ratio")
    assert len(second) < 200 and "% RMSE(shape): Eq. 16" in text and "% corpus: my_corpus" in text
    assert lines[0][1].endswith(r"$\downarrow$") and lines[2][0] == r"B\_8"


def test_rows_and_measures_in_the_order_of_the_settings():
    ((_, _, lines),) = read(objective(rows=["training_mean", "B-8"], metrics=["lip_distance_px", "corr"], ratios=False))
    assert [line[0] for line in lines] == ["", "Training mean", r"B\_8"]
    assert [line.partition("~")[0] for line in lines[0][1:]] == ["Lip distance {[}px{]}", "CORR"]
    # The best of all rows is left out, so another one is the best.
    assert lines[2][1].startswith(r"\textbf{") and not lines[1][1].startswith(r"\textbf{")
    text = objective(intervals=False)
    assert r"\scriptsize" not in text and "In brackets" not in text


def test_the_floor_is_never_the_best():
    ((_, _, lines), _) = read(objective(rows=["floor", "training_mean", "B-8"], metrics=["rmse_shape"]))
    assert [line[1].startswith(r"\textbf{") for line in lines] == [False, False, False, True]


def test_tables_without_anything_chosen_are_left_out():
    text = objective(metrics=["gv_ratio"])
    assert read(text) == [] and "leave out every row or measure" in text
    found, settings = rows(), ComparisonSettings()
    tables = comparison_tables(compare(found, ["corr", "rmse_shape"], settings, BOOTSTRAP), found, settings, FACTS)
    ((caption, _, _),) = read(to_latex(tables, LatexSettings(metrics=["rmse_shape"])))
    assert caption.startswith("RMSE(shape), centred: paired comparisons (fan2015 on")
    selection = SelectionSettings("Chosen", ("F-8",), ("corr", "rmse_shape"), ("rmse_shape",), "F-8")
    frame = selection_frame(found, selection, BOOTSTRAP)
    made = selection_tables(frame, found, selection, "mine", FACTS, BOOTSTRAP)
    both = read(to_latex(made, LatexSettings(metrics=["rmse_shape"], rows=["B-8"])))  # as pooled
    assert [[len(line) for line in lines] for _, _, lines in both] == [[2, 2], [3, 3]]


def test_columns_below_groups_keep_their_order():
    row = Row("a", tuple(map(Cell, "1234")), name="a")
    table = Table("T", ("x", "y", "x", "y"), (row,), groups=(("1", 2), ("2", 2)), metrics=("corr", "ccc") * 2)
    ((_, _, lines),) = read(to_latex([table], LatexSettings(metrics=["ccc"])))
    assert lines == [["", r"\multicolumn{1}{c}{1}", r"\multicolumn{1}{c}{2}"], ["", "y", "y"], ["a", "2", "4"]]


def test_published_figures_name_their_source():
    printed = Table("T as published", ("x",), PLAIN.rows, facts=(("source", "A 2015"),))
    found = read(to_latex([Table("T", ("x",), PLAIN.rows, facts=FACTS), printed, PLAIN, PLAIN]))
    assert [caption for caption, _, _ in found][1:] == ["T as published (A 2015).", *["Plain (A 2015)."] * 2]
    assert len({label for _, label, _ in found}) == 4


def test_minus_signs_and_signs_of_other_scripts():
    cells = (Cell("-1.5", "[-2.0, -1.0]"), Cell("< 0.1"), Cell("5-3"))
    text = to_latex([Table("Δ – 語", ("a", "b", "c"), (Row("é", cells),), notes=("two\nlines",))])
    assert r"$-$1.5{\scriptsize\ {[}$-$2.0, $-$1.0{]}} & \textless{} 0.1 & 5-3" in text
    assert "% Needs LuaLaTeX or XeLaTeX, and a font that has these characters: 語" in text and "é" in text
    assert "\n% two lines\n" in text and r"$\Delta$ -- 語" in text


def test_settings_are_checked():
    with pytest.raises(SettingError, match=r"tables.latex.rows"):
        LatexSettings(rows=("a", "a"))
    assert LatexSettings(metrics=["mine:f"]).metrics == ("mine:f",)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no LaTeX here")
def test_latex_sets_it_without_an_error(tmp_path):
    (tmp_path / "tables.tex").write_text(to_latex([TABLE, PLAIN]) + objective(), encoding="utf-8")
    document = r"\documentclass{article}\usepackage{booktabs,graphicx}\begin{document}\input{tables}\end{document}"
    (tmp_path / "paper.tex").write_text(document)
    done = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper.tex"], cwd=tmp_path,
                          capture_output=True, text=True, errors="replace")  # fmt: skip
    assert done.returncode == 0 and "Overfull" not in done.stdout, done.stdout[-2000:]
    assert NASTY and (tmp_path / "paper.pdf").stat().st_size > 10_000
