"""Synthetic markers in space: a face in millimetres, x to its left, y up, z forward."""

import numpy as np

_HALF = {  # of the left side: group -> positions
    "BRO": [(15, 40, 62), (27, 44, 60), (38, 43, 55), (48, 38, 46)],
    "BM": [(12, 52, 60), (26, 55, 58), (39, 54, 52), (50, 49, 42)],
    "C": [
        (28, 12, 56),
        (44, 14, 48),
        (57, 12, 34),
        (34, -2, 55),
        (50, -4, 44),
        (34, -16, 52),
        (48, -20, 40),
        (28, -30, 50),
    ],
}
_MOUTH = [(24, -30, 56), (14, -24, 62), (0, -22, 65), (-14, -24, 62), (-24, -30, 56), (-14, -38, 60), (0, -41, 62),
          (14, -38, 60)]  # fmt: skip


def markers(seed: int = 0) -> tuple[list[str], np.ndarray]:
    """Names and positions (46, 3) of an idle face; the numbers inside a group are dealt out at random."""
    random = np.random.default_rng(seed)
    found: dict[str, tuple] = {}
    groups = {f"CH{i}": (14 * (i - 2), -62 + 3 * (i == 2), 52) for i in (1, 2, 3)}
    groups |= {f"FH{i}": (22 * (i - 2), 78, 55) for i in (1, 2, 3)}
    found |= groups
    for side, sign in (("L", 1), ("R", -1)):
        for group, first in (("BRO", 1), ("BM", 0), ("C", 1)):
            places = random.permutation(np.array(_HALF[group], float))
            found |= {f"{side}{group}{first + i}": place * [sign, 1, 1] for i, place in enumerate(places)}
    found |= {f"Mou{1 + i}": place for i, place in enumerate(random.permutation(np.array(_MOUTH, float)))}
    names = sorted(found)
    return names, np.array([found[name] for name in names], float)


def at(names: list[str], idle: np.ndarray, group: str, place: tuple) -> int:
    """Row of the marker of a group that lies nearest to a place."""
    rows = [row for row, name in enumerate(names) if name.startswith(group)]
    return min(rows, key=lambda row: float(np.linalg.norm(idle[row] - place)))
