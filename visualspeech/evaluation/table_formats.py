"""A result table as TSV, Markdown, LaTeX and HTML, and back from TSV."""

import html
from collections.abc import Mapping

from visualspeech.errors import StorageError
from visualspeech.evaluation.escaping import markdown as _md
from visualspeech.evaluation.escaping import tex as _tex
from visualspeech.evaluation.metrics import METRICS, Metric
from visualspeech.evaluation.statistics import BASE_ROW
from visualspeech.evaluation.tables import FLOOR_ROW, PARTS, ROW_TITLES, ResultTable, best_cells


def row_title(row: str) -> str:
    """Name of a row for people; networks keep theirs."""
    return ROW_TITLES.get(row, row)


def column_title(metric: Metric, part: str = "value") -> str:
    """Heading of a measure: its name, for figures also the unit and whether low or high is good."""
    if part == "ratio":
        return metric.title
    arrow = {"low": "↓", "high": "↑", "one": "→\u00a01"}[metric.best]
    return f"{metric.title}{f' [{metric.unit}]' if metric.unit else ''}\u00a0{arrow}"


def to_tsv(table: ResultTable) -> str:
    """Tab-separated text: the facts as lines that begin with ``#``, then a header, then one line a row."""
    header = ["row"] + [_column(metric.name, part) for metric in table.metrics for part in PARTS]
    lines = [f"# {_flat(name)}: {_flat(text)}" for name, text in table.facts] + ["\t".join(header)]
    for row in table.rows:
        cells = [table.cells[row, metric.name][part] for metric in table.metrics for part in PARTS]
        lines.append("\t".join([_flat(row), *cells]))
    return "\n".join(lines) + "\n"


def from_tsv(text: str) -> ResultTable:
    """The table that :func:`to_tsv` wrote.

    Raises
    ------
    StorageError
        The text is not such a table.
    """
    try:
        lines = text.splitlines()
        facts = tuple(
            (name, value) for name, _, value in (line[2:].partition(": ") for line in lines if line.startswith("# "))
        )
        header, *body = [line.split("\t") for line in lines if not line.startswith("# ")]
        metrics = tuple(METRICS[name] for name in header[1 :: len(PARTS)])
        cells = {}
        for row, *values in body:
            for place, metric in enumerate(metrics):
                part = values[place * len(PARTS) : (place + 1) * len(PARTS)]
                cells[row, metric.name] = dict(zip(PARTS, part, strict=True))
        rows = tuple(line[0] for line in body)
        return ResultTable(facts, metrics, rows, cells, best_cells(rows, metrics, cells))
    except (ValueError, KeyError, IndexError) as error:
        raise StorageError(f"this is not a result table ({error!r}). Delete it and run again.") from error


def _column(metric: str, part: str) -> str:
    return metric if part == "value" else f"{metric}_{part}"


def _flat(text: str) -> str:
    return " ".join(str(text).split())


def _interval(cells: Mapping[str, str], part: str) -> str:
    low, high = ("low", "high") if part == "value" else ("ratio_low", "ratio_high")
    return f"[{cells[low]}, {cells[high]}]" if cells[low] and cells[high] else ""


def _blocks(table: ResultTable) -> tuple[tuple[str, str], ...]:
    return (("value", "Figures"), ("ratio", f"Ratio to the {ROW_TITLES[BASE_ROW].lower()}"))


def _note(table: ResultTable) -> str:
    """Why a ratio is missing, where one is."""
    if all(table.cells[row, metric.name]["ratio"] for row in table.rows for metric in table.metrics):
        return ""
    return (
        f"Ratios are given of errors. The {ROW_TITLES[BASE_ROW].lower()} keeps no variance and correlates by chance, "
        "and no ratio to that says anything; nor is there one where the interval of its error holds 0."
    )


def to_markdown(table: ResultTable) -> str:
    """GitHub-flavoured Markdown: figures, then ratios, each with intervals; the best figure in bold."""
    lines = [f"- {_md(name)}: {_md(text)}" for name, text in table.facts]
    for part, title in _blocks(table):
        lines += ["", f"**{title}**", "", "| | " + " | ".join(_md(column_title(m, part)) for m in table.metrics) + " |"]
        lines.append("|---|" + "---:|" * len(table.metrics))
        for row in table.rows:
            texts = []
            for metric in table.metrics:
                cells = table.cells[row, metric.name]
                mark = "**" if part == "value" and (row, metric.name) in table.best else ""
                texts.append(f"{mark}{cells[part]}{mark} {_interval(cells, part)}".strip() if cells[part] else "–")
            lines.append(f"| {_md(row_title(row))} | " + " | ".join(texts) + " |")
    note = _note(table)
    lines += [
        "",
        *([note, ""] if note else []),
        *(f"- {_md(metric.title)}: {_md(metric.definition)}." for metric in table.metrics),
    ]
    return "\n".join(lines) + "\n"


def to_latex(table: ResultTable) -> str:
    """A LaTeX table environment (packages ``booktabs`` and ``graphicx``), the facts in its caption."""
    columns = "l" + "r" * len(table.metrics)
    width = len(table.metrics) + 1
    lines = [r"\begin{table}", r"\centering", rf"\resizebox{{\linewidth}}{{!}}{{\begin{{tabular}}{{{columns}}}"]
    lines.append(r"\toprule")
    for part, title in _blocks(table):
        if part == "ratio":
            lines.append(r"\midrule")
        lines.append(rf"\multicolumn{{{width}}}{{l}}{{\itshape {_tex(title)}}} \\")
        lines.append(" & ".join(["", *(_tex(column_title(metric, part)) for metric in table.metrics)]) + r" \\")
        lines.append(r"\midrule")
        for row in table.rows:
            texts = []
            for metric in table.metrics:
                cells = table.cells[row, metric.name]
                text = cells[part]
                if part == "value" and (row, metric.name) in table.best:
                    text = rf"\textbf{{{text}}}"
                interval = _interval(cells, part)
                texts.append(f"{text}{{\\scriptsize\\ {interval}}}" if interval else text or "--")
            lines.append(" & ".join([_tex(row_title(row)), *texts]) + r" \\")
    caption = "; ".join(f"{_tex(name)}: {_tex(text)}" for name, text in table.facts)
    definitions = ". ".join(f"{_tex(metric.title)}: {_tex(metric.definition)}" for metric in table.metrics)
    note = _note(table)
    caption += f". {definitions}." + (f" {_tex(note)}" if note else "")
    lines += [r"\bottomrule", r"\end{tabular}}", rf"\caption{{{caption}}}", r"\end{table}"]
    return "\n".join(lines) + "\n"


def to_html(table: ResultTable) -> str:
    """An HTML fragment (``<figure>``) that styles itself where it stands; all text escaped."""
    out = ['<figure class="result-table">', "<figcaption>"]
    out.append(" · ".join(f"<b>{html.escape(name)}</b> {html.escape(text)}" for name, text in table.facts))
    out.append("</figcaption>")
    for part, title in _blocks(table):
        heads = "".join(
            f'<th scope="col" title="{html.escape(m.definition)}">{html.escape(column_title(m, part))}</th>'
            for m in table.metrics
        )
        out.append('<div class="scroll"><table>')
        out.append(f'<thead><tr><th scope="col">{html.escape(title)}</th>{heads}</tr></thead><tbody>')
        for row in table.rows:
            out.append(f'<tr class="{_kind(row)}"><th scope="row">{html.escape(row_title(row))}</th>')
            for metric in table.metrics:
                cells = table.cells[row, metric.name]
                best = part == "value" and (row, metric.name) in table.best
                text = html.escape(cells[part]) or "–"
                interval = html.escape(_interval(cells, part))
                out.append(
                    f"<td>{f'<strong>{text}</strong>' if best else text}"
                    f"{f'<small>{interval}</small>' if interval else ''}</td>"
                )
            out.append("</tr>")
        out.append("</tbody></table></div>")
    if note := _note(table):
        out.append(f"<p>{html.escape(note)}</p>")
    terms = "".join(f"<dt>{html.escape(m.title)}</dt><dd>{html.escape(m.definition)}.</dd>" for m in table.metrics)
    out += [f"<dl>{terms}</dl>", "</figure>"]
    return "\n".join(out) + "\n"


def to_html_page(table: ResultTable, title: str = "Objective results") -> str:
    """The table as an HTML page of its own, without anything from outside."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{html.escape(title)}</title><style>{PAGE_STYLE}</style></head><body><h1>{html.escape(title)}</h1>\n"
        f"{to_html(table)}</body></html>\n"
    )


PAGE_STYLE = (
    ":root{color-scheme:light dark}body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:min(92vw,110rem);"
    "padding:0 1rem}table{border-collapse:collapse;margin:1rem 0;width:100%}th,td{padding:.35rem .6rem;"
    "text-align:right;border-bottom:1px solid #8884;font-variant-numeric:tabular-nums}th:first-child{text-align:left}"
    "td small{display:block;opacity:.65}tr.baseline th,tr.floor th{font-weight:400}figure{margin:0}dt{font-weight:600}"
    "dd{margin:0 0 .4rem}.scroll{overflow-x:auto}th[colspan]{text-align:center}"
)


def _kind(row: str) -> str:
    if row == FLOOR_ROW:
        return "floor"
    return "baseline" if row in ROW_TITLES else "network"
