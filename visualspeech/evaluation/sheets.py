"""Tables laid out for people: headings that span columns, marked cells, notes; as Markdown, LaTeX and HTML.

A :class:`Sheet` is what is read on paper. What is computed on stays a data frame, written as TSV, from which the sheets
are made; so the forms cannot disagree.
"""

import html
from collections.abc import Sequence
from dataclasses import dataclass

from visualspeech.errors import StorageError
from visualspeech.evaluation.escaping import markdown, tex
from visualspeech.evaluation.table_formats import PAGE_STYLE
from visualspeech.storage import table_text


@dataclass(frozen=True)
class Cell:
    """What a cell shows.

    Parameters
    ----------
    text : the figure; empty is shown as a dash
    small : beside it, less prominent: an interval, a deviation
    best : shown in bold
    collapsed : shown in italics with a dagger; a note says what that means
    """

    text: str
    small: str = ""
    best: bool = False
    collapsed: bool = False


@dataclass(frozen=True)
class Sheet:
    """One table.

    Parameters
    ----------
    title : above it
    groups : headings of the upper line, each with the number of columns it spans; empty: there is no upper line
    columns : headings of the lower line, without that of the first column
    rows : (name, cells), as many cells as columns
    facts : (name, text) pairs
    notes : sentences below it
    corner : heading of the first column
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]
    groups: tuple[tuple[str, int], ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()
    corner: str = ""


def all_forms(frame, sheets: Sequence[Sheet], title: str) -> tuple[str, str, str, str]:
    """TSV of the data frame under the facts of its first sheet (lines that begin with ``#``); Markdown, LaTeX, HTML."""
    facts = "".join(f"# {name}: {' '.join(text.split())}\n" for name, text in (sheets[0].facts if sheets else ()))
    return facts + table_text(frame), to_markdown(sheets), to_latex(sheets), to_html_page(sheets, title)


def to_markdown(sheets: Sequence[Sheet]) -> str:
    """GitHub-flavoured Markdown, which has one line of headings: a group's name stands before each of its columns."""
    parts = []
    for sheet in sheets:
        over = [name for name, span in sheet.groups for _ in range(span)] or [""] * len(sheet.columns)
        heads = [f"{group} {column}".strip() for group, column in zip(over, sheet.columns, strict=True)]
        lines = [f"**{markdown(sheet.title)}**", ""]
        lines += [f"- {markdown(name)}: {markdown(text)}" for name, text in sheet.facts]
        lines += [""] if sheet.facts else []
        lines.append("| " + " | ".join(markdown(head) for head in (sheet.corner, *heads)) + " |")
        lines.append("|---|" + "---:|" * len(heads))
        for name, cells in sheet.rows:
            lines.append("| " + " | ".join([markdown(name), *map(_markdown_cell, cells)]) + " |")
        for note in sheet.notes:
            lines += ["", markdown(note)]
        parts.append("\n".join(lines))
    return "\n\n".join(parts) + "\n"


def _markdown_cell(cell: Cell) -> str:
    mark = ("**" if cell.best else "") + ("*" if cell.collapsed else "")
    text = markdown(cell.text) + ("†" if cell.collapsed else "") if cell.text else "–"
    return f"{mark}{text}{mark[::-1]} {markdown(cell.small)}".rstrip()


def to_latex(sheets: Sequence[Sheet]) -> str:
    """LaTeX table environments (packages ``booktabs`` and ``graphicx``)."""
    lines = []
    for sheet in sheets:
        lines += [r"\begin{table}", r"\centering", rf"\caption{{{tex(_caption(sheet))}}}"]
        lines.append(rf"\resizebox{{\linewidth}}{{!}}{{\begin{{tabular}}{{l{'r' * len(sheet.columns)}}}")
        lines.append(r"\toprule")
        if sheet.groups:
            spans = [rf"\multicolumn{{{span}}}{{c}}{{{tex(name)}}}" for name, span in sheet.groups]
            lines.append(" & ".join([tex(sheet.corner), *spans]) + r" \\")
        corner = "" if sheet.groups else tex(sheet.corner)
        lines.append(" & ".join([corner, *map(tex, sheet.columns)]) + r" \\")
        lines.append(r"\midrule")
        for name, cells in sheet.rows:
            lines.append(" & ".join([tex(name), *map(_latex_cell, cells)]) + r" \\")
        lines += [r"\bottomrule", r"\end{tabular}}", r"\end{table}", ""]
    return "\n".join(lines)


def _caption(sheet: Sheet) -> str:
    facts = "; ".join(f"{name}: {text}" for name, text in sheet.facts)
    return " ".join([f"{sheet.title}.", *([f"{facts}."] if facts else []), *sheet.notes])


def _latex_cell(cell: Cell) -> str:
    text = tex(cell.text) + (r"\textdagger{}" if cell.collapsed else "") if cell.text else "--"
    if cell.collapsed:
        text = rf"\textit{{{text}}}"
    if cell.best:
        text = rf"\textbf{{{text}}}"
    return text + (rf"{{\scriptsize\ {tex(cell.small)}}}" if cell.small else "")


def to_html(sheets: Sequence[Sheet]) -> str:
    """HTML fragments (``<figure>``) that style themselves where they stand; all text escaped."""
    out = []
    for sheet in sheets:
        kind = "result-table grouped" if sheet.groups else "result-table"
        out += [f'<figure class="{kind}">', f"<figcaption><b>{html.escape(sheet.title)}</b>"]
        out.append(" · ".join(f"{html.escape(name)}: {html.escape(text)}" for name, text in sheet.facts))
        out.append('</figcaption><div class="scroll"><table><thead>')
        corner = f'<th scope="col"{" rowspan=2" if sheet.groups else ""}>{html.escape(sheet.corner)}</th>'
        if sheet.groups:
            spans = "".join(
                f'<th scope="colgroup" colspan="{span}">{html.escape(name)}</th>' for name, span in sheet.groups
            )
            out.append(f"<tr>{corner}{spans}</tr>")
        # Many columns stand side by side: a heading may break before its bracket.
        names = (html.escape(column).replace("(", "<wbr>(") for column in sheet.columns)
        heads = "".join(f'<th scope="col">{name}</th>' for name in names)
        out.append(f"<tr>{'' if sheet.groups else corner}{heads}</tr></thead><tbody>")
        for name, cells in sheet.rows:
            out.append(f'<tr><th scope="row">{html.escape(name)}</th>{"".join(map(_html_cell, cells))}</tr>')
        out.append("</tbody></table></div>")
        out += [f"<p>{html.escape(note)}</p>" for note in sheet.notes]
        out.append("</figure>")
    return "\n".join(out) + "\n"


def _html_cell(cell: Cell) -> str:
    text = html.escape(cell.text) or "–"
    if cell.collapsed:
        text = f"<em>{text}†</em>"
    if cell.best:
        text = f"<strong>{text}</strong>"
    small = f"<small>{html.escape(cell.small)}</small>" if cell.small else ""
    return f"<td>{text}{small}</td>"


def fragment_of(page: str) -> str:
    """The tables of a page that :func:`to_html_page` wrote, for a page that holds more.

    Raises
    ------
    StorageError
        It is no such page.
    """
    _, heading, rest = page.partition("</h1>\n")
    body, end, _ = rest.rpartition("</body>")
    if not heading or not end:
        raise StorageError("this is no page of tables of a run. Delete it and run again.")
    return body


def to_html_page(sheets: Sequence[Sheet], title: str) -> str:
    """The tables as an HTML page of its own, without anything from outside."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{PAGE_STYLE}</style></head><body><h1>{html.escape(title)}</h1>\n"
        f"{to_html(sheets)}</body></html>\n"
    )
