"""Tables as TSV, Markdown and HTML; as LaTeX they are written by :mod:`visualspeech.evaluation.latex`."""

import html
from collections.abc import Sequence

from visualspeech.errors import StorageError
from visualspeech.evaluation.escaping import markdown
from visualspeech.evaluation.latex import LatexSettings, to_latex
from visualspeech.evaluation.layout import Cell, Row, Table
from visualspeech.storage.tables import table_text

PAGE_STYLE = (
    ":root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:min(92vw,110rem);"
    "padding:0 1rem}table{border-collapse:collapse;margin:1rem 0;width:100%}th,td{padding:.35rem .6rem;"
    "text-align:right;border-bottom:1px solid #8884;font-variant-numeric:tabular-nums}th:first-child{text-align:left}"
    "td small{display:block;opacity:.65}tr.baseline th,tr.floor th{font-weight:400}figure{margin:0}dt{font-weight:600}"
    "dd{margin:0 0 .4rem}.scroll{overflow-x:auto}th[colspan]{text-align:center}tr.heading th{text-align:left}"
)


def all_forms(
    frame, tables: Sequence[Table], title: str, latex: LatexSettings | None = None
) -> tuple[str, str, str, str]:
    """The texts of the TSV, Markdown, LaTeX and HTML files of a data frame and its tables.

    The TSV begins with the facts of the first table, on lines that begin with ``#``. ``latex`` chooses rows and
    measures of the LaTeX file.
    """
    facts = "".join(f"# {_flat(name)}: {_flat(text)}\n" for name, text in (tables[0].facts if tables else ()))
    return facts + table_text(frame), to_markdown(tables), to_latex(tables, latex), to_html_page(tables, title)


def _flat(text: str) -> str:
    return " ".join(text.split())


def to_markdown(tables: Sequence[Table]) -> str:
    """GitHub-flavoured Markdown; the name of a group precedes each of its columns, as there is one line of headings."""
    return "\n\n".join(map(_markdown_table, tables)) + "\n"


def _markdown_table(table: Table) -> str:
    over = [name for name, span in table.groups for _ in range(span)] or [""] * len(table.columns)
    heads = [f"{group} {column}".strip() for group, column in zip(over, table.columns, strict=True)]
    lines = [f"**{markdown(table.title)}**", ""]
    lines += [f"- {markdown(name)}: {markdown(text)}" for name, text in table.facts]
    lines += [""] if table.facts else []
    lines.append("| " + " | ".join(markdown(head) for head in (table.corner, *heads)) + " |")
    lines.append("|---|" + "---:|" * len(heads))
    for row in table.rows:
        name, cells = markdown(row.title), list(map(_markdown_cell, row.cells))
        lines.append("| " + " | ".join([name, *cells] if cells else [f"**{name}**", *[""] * len(heads)]) + " |")
    for note in table.notes:
        lines += ["", markdown(note)]
    lines += [""] if table.definitions else []
    lines += [f"- {markdown(term)}: {markdown(text)}" for term, text in table.definitions]
    return "\n".join(lines)


def _markdown_cell(cell: Cell) -> str:
    mark = ("**" if cell.best else "") + ("*" if cell.collapsed else "")
    text = markdown(cell.text) + ("†" if cell.collapsed else "") if cell.text else "–"
    return f"{mark}{text}{mark[::-1]} {markdown(cell.small)}".rstrip()


def to_html(tables: Sequence[Table]) -> str:
    """HTML fragments (``<figure>``) without a style of their own; all text is escaped."""
    return "\n".join(line for table in tables for line in _html_table(table)) + "\n"


def _html_table(table: Table) -> list[str]:
    css_class = "result-table grouped" if table.groups else "result-table"
    facts = " · ".join(_pairs(table.facts, "{}: {}"))
    out = [f'<figure class="{css_class}">', f"<figcaption><b>{html.escape(table.title)}</b>"]
    out += [facts, '</figcaption><div class="scroll"><table><thead>']
    corner = f'<th scope="col"{" rowspan=2" if table.groups else ""}>{html.escape(table.corner)}</th>'
    if table.groups:
        spans = "".join(f'<th scope="colgroup" colspan="{n}">{html.escape(name)}</th>' for name, n in table.groups)
        out.append(f"<tr>{corner}{spans}</tr>")
    # With many columns, headings need a line break before the bracket.
    heads = "".join(f'<th scope="col">{html.escape(name).replace("(", "<wbr>(")}</th>' for name in table.columns)
    out.append(f"<tr>{'' if table.groups else corner}{heads}</tr></thead><tbody>")
    out += [_html_row(row, len(table.columns)) for row in table.rows]
    out.append("</tbody></table></div>")
    out += [f"<p>{html.escape(note)}</p>" for note in table.notes]
    if table.definitions:
        out += ["<dl>", *_pairs(table.definitions, "<dt>{}</dt><dd>{}</dd>"), "</dl>"]
    return [*out, "</figure>"]


def _pairs(pairs: Sequence[tuple[str, str]], form: str) -> list[str]:
    return [form.format(html.escape(name), html.escape(text)) for name, text in pairs]


def _html_row(row: Row, width: int) -> str:
    title = html.escape(row.title)
    if not row.cells:
        return f'<tr class="heading"><th scope="colgroup" colspan="{width + 1}">{title}</th></tr>'
    cells = "".join(map(_html_cell, row.cells))
    return f'<tr class="{html.escape(row.role)}"><th scope="row">{title}</th>{cells}</tr>'


def _html_cell(cell: Cell) -> str:
    text = html.escape(cell.text) or "–"
    if cell.collapsed:
        text = f"<em>{text}†</em>"
    if cell.best:
        text = f"<strong>{text}</strong>"
    small = f"<small>{html.escape(cell.small)}</small>" if cell.small else ""
    return f"<td>{text}{small}</td>"


def to_html_page(tables: Sequence[Table], title: str) -> str:
    """A self-contained HTML page with the tables."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{PAGE_STYLE}</style></head><body><h1>{html.escape(title)}</h1>\n"
        f"{to_html(tables)}</body></html>\n"
    )


def fragment_of(page: str) -> str:
    """The tables of a page written by :func:`to_html_page`, for use in another page.

    Raises
    ------
    StorageError
        The text is not such a page.
    """
    _, heading, rest = page.partition("</h1>\n")
    body, end, _ = rest.rpartition("</body>")
    if not heading or not end:
        raise StorageError("this is not a page of tables that a run has written. Delete it and run again.")
    return body
