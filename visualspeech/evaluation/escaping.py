"""Text from outside, made harmless in Markdown and LaTeX; HTML has :func:`html.escape`."""

import html

_TEX = {
    "\\": r"\textbackslash{}",
    **{sign: f"\\{sign}" for sign in "&%$#_{}"},
    "[": "{[}",  # a bracket after the end of a row would be read as its argument
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
    """Text that LaTeX sets as it stands."""
    return "".join(_TEX.get(sign, sign) for sign in text)


def markdown(text: str) -> str:
    """Text that Markdown shows as it stands, inside a table too."""
    escaped = html.escape(text, quote=False)
    for sign in "\\`*_[]|":
        escaped = escaped.replace(sign, f"\\{sign}")
    return escaped
