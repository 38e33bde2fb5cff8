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
    "|": r"\textbar{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "“": "``",
    "”": "''",
    "–": "--",
    "—": "---",
    "‘": "`",
    "’": "'",
    "…": r"\dots{}",
    "±": r"$\pm$",
    "−": "$-$",
    "×": r"$\times$",
    "·": r"$\cdot$",
    "≤": r"$\leq$",
    "≥": r"$\geq$",
    "≈": r"$\approx$",
    "∆": r"$\Delta$",
    "Δ": r"$\Delta$",
    "µ": r"$\mu$",
    "μ": r"$\mu$",
    "σ": r"$\sigma$",
    "°": r"$^\circ$",
    "²": r"$^2$",
    "†": r"\textdagger{}",
    "↓": r"$\downarrow$",
    "↑": r"$\uparrow$",
    "→": r"$\rightarrow$",
}


def tex(text: str) -> str:
    """Text escaped for LaTeX, on one line; what pdfLaTeX cannot set stays (:func:`is_in_tex`)."""
    return "".join(_TEX.get(sign, sign) for sign in " ".join(_lines(text)))


def is_in_tex(sign: str) -> bool:
    """Whether a character of escaped text is one that LaTeX with UTF-8 sets in its usual fonts: Latin letters."""
    return sign < "\u0180"


def _lines(text: str) -> list[str]:
    """The lines of a text, without the characters that end or control them."""
    return ["".join(sign for sign in line if sign.isprintable() or sign == "\u00a0") for line in text.splitlines()]


def markdown(text: str) -> str:
    """Text escaped for Markdown, also inside a table."""
    escaped = html.escape(text, quote=False)
    for sign in "\\`*_[]|":
        escaped = escaped.replace(sign, f"\\{sign}")
    return escaped
