"""Tables as LaTeX for a paper: ``booktabs``, a short caption, a label, and the rows and measures that settings choose.

What a caption cannot hold (facts, notes, definitions) stands in comments above the table, for its author to use.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from visualspeech.evaluation.escaping import is_in_tex, tex
from visualspeech.evaluation.layout import Cell, Row, Table, best_of
from visualspeech.evaluation.metrics import metric_named
from visualspeech.evaluation.selection_settings import NAMED
from visualspeech.fields import Settings, setting
from visualspeech.models.rows import ORACLE

PACKAGES = ("booktabs", "graphicx")
#: Scales a table down to the width of the text, and leaves a narrow one as it is.
_FITTED = r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%"


@dataclass(frozen=True)
class LatexSettings(Settings):
    """Content of the LaTeX files of a system's tables; the other files of a table keep all of it."""

    section = "tables.latex"
    rows: tuple[str, ...] = setting(
        (),
        "Rows in their order: entries of models, or rows; empty for all.",
        item={"description": "Entry of models, or row.", "max_length": 200},
        max_items=1000,
        unique=True,
    )
    metrics: tuple[str, ...] = setting(
        (),
        "Measures in the order of the columns, of those that the tables show; empty for all.",
        item=NAMED,
        max_items=100,
        unique=True,
    )
    intervals: bool = setting(True, "Show intervals and deviations beside the figures.")
    ratios: bool = setting(True, "Keep the tables of ratios to the training mean.")


def to_latex(tables: Sequence[Table], settings: LatexSettings | None = None) -> str:
    """LaTeX ``table`` environments, one after the other, below the packages that they need.

    Parameters
    ----------
    tables : what is shown; the facts of one count for those after it that have none
    settings : which rows and measures are shown of the tables that tell theirs (:class:`Table`), all by default
    """
    settings = settings or LatexSettings()
    body, labels, facts = [], set(), {}
    for whole in tables:
        # Published figures have facts of their own, which hold for the tables after them, too.
        facts = dict(whole.facts) or facts
        if table := chosen(whole, settings):
            label = _label(table, facts)
            while label in labels:
                label += "-more"
            labels.add(label)
            body += _table(table, facts, label)
    return "\n".join([*_head(body), *body]) + "\n"


def _head(body: Sequence[str]) -> list[str]:
    packages = [rf"% \usepackage{{{name}}}" for name in PACKAGES]
    lines = ["% Needs these packages, and UTF-8 (the default of LaTeX):", *packages]
    odd = sorted({sign for line in body if not line.startswith("%") for sign in line if not is_in_tex(sign)})
    if odd:
        shown = " ".join(odd[:20])
        lines.append(f"% Needs LuaLaTeX or XeLaTeX, and a font that has these characters: {shown}")
    if not body:
        lines.append("% This table has no rows, or the settings of tables.latex leave out every row or measure.")
    return [*lines, ""]


def chosen(table: Table, settings: LatexSettings) -> Table | None:
    """The rows and columns of a table that the settings choose; None where none is left.

    Rows without a name and columns without a measure stay. Where the best value in each column is bold, it is found
    anew among the rows that are left.
    """
    if table.ratios and not settings.ratios:
        return None
    rows = _in_order(table.rows, [row.name for row in table.rows], settings.rows)
    columns = list(range(len(table.columns)))
    groups = table.groups
    if settings.metrics and any(table.metrics):
        if groups:  # their order is that of the table
            columns = [number for number in columns if table.metrics[number] in ("", *settings.metrics)]
            groups = _groups(table, columns)
        else:
            columns = _in_order(columns, table.metrics, settings.metrics)
    if not any(row.cells for row in rows) or (any(table.metrics) and not any(table.metrics[one] for one in columns)):
        return None
    rows = [_cut(row, columns, settings.intervals) for row in rows]
    made = replace(
        table,
        columns=tuple(table.columns[number] for number in columns),
        metrics=tuple(table.metrics[number] for number in columns) if table.metrics else (),
        rows=tuple(rows),
        groups=groups,
    )
    return _ranked(made) if table.ranked and len(rows) < len(table.rows) else made


def _in_order(values: Sequence, names: Sequence[str], wanted: Sequence[str]) -> list:
    """Values whose name is wanted or empty, in the order of the wanted names where all have one."""
    pairs = [(value, name) for value, name in zip(values, names, strict=True) if not wanted or name in ("", *wanted)]
    if wanted and all(name for _, name in pairs):
        pairs.sort(key=lambda pair: list(wanted).index(pair[1]))
    return [value for value, _ in pairs]


def _groups(table: Table, columns: Sequence[int]) -> tuple[tuple[str, int], ...]:
    ends, found, start = set(columns), [], 0
    for name, span in table.groups:
        if left := sum(number in ends for number in range(start, start + span)):
            found.append((name, left))
        start += span
    return tuple(found)


def _cut(row: Row, columns: Sequence[int], intervals: bool) -> Row:
    cells = tuple(row.cells[number] for number in columns) if row.cells else ()
    return replace(row, cells=cells if intervals else tuple(replace(cell, small="") for cell in cells))


def _ranked(table: Table) -> Table:
    """The table with the best value in each column bold, of the rows that can have one."""
    best = []
    for number, name in enumerate(table.metrics):
        figures = {
            index: row.cells[number].text
            for index, row in enumerate(table.rows)
            if row.cells and row.role not in ("floor", ORACLE)
        }
        best.append(best_of(metric_named(name), figures) if name else set())
    rows = [
        replace(row, cells=tuple(replace(cell, best=index in best[n]) for n, cell in enumerate(row.cells)))
        for index, row in enumerate(table.rows)
    ]
    return replace(table, rows=tuple(rows))


def _table(table: Table, facts: Mapping[str, str], label: str) -> list[str]:
    width = len(table.columns)
    lines = [f"% {_flat(line)}" for line in _details(table)]
    lines += [r"\begin{table}", r"\centering", rf"\caption{{{tex(_caption(table, facts))}}}", rf"\label{{{label}}}"]
    lines += [r"\smallskip", _FITTED, rf"\begin{{tabular}}{{l{'r' * width}}}", r"\toprule"]
    if table.groups:
        spans = [rf"\multicolumn{{{span}}}{{c}}{{{tex(name)}}}" for name, span in table.groups]
        lines.append(" & ".join([tex(table.corner), *spans]) + r" \\")
    corner = "" if table.groups else tex(table.corner)
    lines += [" & ".join([corner, *map(tex, table.columns)]) + r" \\", r"\midrule"]
    for row in table.rows:
        if row.cells:
            lines.append(" & ".join([tex(row.title), *map(_cell, row.cells)]) + r" \\")
        else:
            lines.append(rf"\multicolumn{{{width + 1}}}{{l}}{{\itshape {tex(row.title)}}} \\")
    return [*lines, r"\bottomrule", r"\end{tabular}}", r"\end{table}", ""]


def _details(table: Table) -> list[str]:
    pairs = [f"{name}: {text}" for name, text in (*table.facts, *table.definitions)]
    return [*pairs, *table.notes]


def _caption(table: Table, facts: Mapping[str, str]) -> str:
    """Title, data, and what brackets, bold figures and daggers mean."""
    place = " on ".join(filter(None, (facts.get("system"), facts.get("corpus"))))
    count = facts.get("test utterances")
    tested = f"{count} test utterance{'s' * (count != '1')}" if count else ""
    about = facts.get("source") or ", ".join(filter(None, (place, tested)))
    parts = [f"{table.title} ({about})." if about else f"{table.title}."]
    cells = [cell for row in table.rows for cell in row.cells]
    if table.ranked and any(cell.best for cell in cells):
        parts.append("The best value in each column is bold.")
    intervals = facts.get("intervals", "").split(",")[0]
    if intervals and any(cell.small.startswith("[") for cell in cells):
        parts.append(f"In brackets: {intervals}.")
    if any(cell.collapsed for cell in cells):
        parts += [note for note in table.notes if "†" in note]
    return " ".join(parts)


def _label(table: Table, facts: Mapping[str, str]) -> str:
    parts = [facts.get("corpus", ""), facts.get("system", ""), table.title]
    words = re.findall(r"[a-z0-9]+", " ".join(parts).lower())
    return f"tab:{'-'.join(words) or 'table'}"


def _flat(text: str) -> str:
    return " ".join(text.split())


def _cell(cell: Cell) -> str:
    text = _number(cell.text) + (r"\textdagger{}" if cell.collapsed else "") if cell.text else "--"
    if cell.collapsed:
        text = rf"\textit{{{text}}}"
    if cell.best:
        text = rf"\textbf{{{text}}}"
    return text + (rf"{{\scriptsize\ {_number(cell.small)}}}" if cell.small else "")


def _number(text: str) -> str:
    """Text of a cell, whose hyphens before digits are minus signs."""
    return tex(re.sub(r"(?<![\w.)])-(?=\d)", "−", text))
