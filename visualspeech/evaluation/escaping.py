"""Escaping of arbitrary text for Markdown and LaTeX; for HTML, :func:`html.escape` is used."""

import html

_TEX = {
    "\\": r"\textbackslash{}",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "[": "{[}",  # after the end of a row, LaTeX would read a bracket as an optional argument
    "]": "{]}",
    "\u00a0": "~",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "“": "``",
    "”": "''",
    "–": "--",
    "±": r"$\pm$",
    "−": "$-$",
    "×": r"$\times$",
    "†": r"\textdagger{}",
    "↓": r"$\downarrow$",
    "↑": r"$\uparrow$",
    "→": r"$\rightarrow$",
}


def tex(text: str) -> str:
    """Text escaped for LaTeX."""
    return "".join(_TEX.get(sign, sign) for sign in text)


def markdown(text: str) -> str:
    """Text escaped for Markdown, also inside a table."""
    escaped = html.escape(text, quote=False)
    for sign in "\\`*_[]|":
        escaped = escaped.replace(sign, f"\\{sign}")
    return escaped
