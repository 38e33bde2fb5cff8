"""Draw docs/points.png and docs/points_34.png: the points of a set and their mesh on the generic mean face.

Run: python docs/draw_points.py
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from visualspeech.face.mean_face import MEAN_FACE  # noqa: E402
from visualspeech.face.point_sets import read_point_set  # noqa: E402

BLUE, GREEN, RED, VIOLET = "#1b6ca8", "#2e8b57", "#c0392b", "#8e44ad"
DRAWINGS = {
    "lower_face_51": (
        "points.png",
        ("jaw line (17)", "jaw", BLUE),
        ("nose (9)", "nose", GREEN),
        ("lips (20)", "lips", RED),
        ("cheeks, chin hollow (5): means of others", "derived", VIOLET),
    ),
    "lips_jaw_nostrils_34": (
        "points_34.png",
        ("jaw (9)", "jaw", BLUE),
        ("nostrils (5)", "nostrils", GREEN),
        ("lips (20)", "lips", RED),
    ),
}


def draw(name: str, file: str, *groups: tuple[str, str, str]) -> None:
    points68, points = np.asarray(MEAN_FACE)[:, :2], read_point_set(name)
    face = points.open_mouth(points.select(points68), 0.2)
    figure, axes = plt.subplots(figsize=(8, 6.2), dpi=110)
    axes.triplot(face[:, 0], face[:, 1], points.triangles, color="#bbbbbb", linewidth=0.8)
    used = np.any(points.selection > 0, axis=0)
    held = np.isin(np.arange(len(points68)), points.held)
    axes.plot(*points68[~used & ~held].T, ".", color="#dddddd", label="not used")
    if held.any():
        axes.plot(*points68[held].T, "x", color="#999999", markersize=5, label="held as recorded")
    for label, region, colour in groups:
        axes.plot(*points.region(face, region).T, "o", color=colour, markersize=5, label=label)
    for number, (x, y) in enumerate(face):
        axes.annotate(str(number), (x, y), xytext=(3, 3), textcoords="offset points", fontsize=7)
    axes.invert_yaxis()
    axes.set_aspect("equal")
    axes.axis("off")
    axes.legend(loc="upper center", ncols=2, fontsize=8, frameon=False, bbox_to_anchor=(0.5, 1.08))
    figure.savefig(Path(__file__).with_name(file), bbox_inches="tight", metadata={"Software": None})


def main() -> None:
    for name, (file, *groups) in DRAWINGS.items():
        draw(name, file, *groups)


if __name__ == "__main__":
    main()
