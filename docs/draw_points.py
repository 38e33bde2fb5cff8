"""Draw docs/points.png: the 51 lower-face points and their mesh on the generic mean face.

Run: python docs/draw_points.py
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from visualspeech.face.mean_face import MEAN_FACE  # noqa: E402
from visualspeech.face.point_sets import read_point_set  # noqa: E402

GROUPS = (
    ("jaw line (17)", "jaw", "#1b6ca8"),
    ("nose (9)", "nose", "#2e8b57"),
    ("lips (20)", "lips", "#c0392b"),
    ("cheeks, chin hollow (5): means of others", "derived", "#8e44ad"),
)


def main() -> None:
    points68, points = np.asarray(MEAN_FACE)[:, :2], read_point_set("lower_face_51")
    face = points.open_mouth(points.select(points68), 0.2)
    figure, axes = plt.subplots(figsize=(8, 6.2), dpi=110)
    axes.triplot(face[:, 0], face[:, 1], points.triangles, color="#bbbbbb", linewidth=0.8)
    others = np.concatenate([points68[17:27], points68[36:48]])
    axes.plot(others[:, 0], others[:, 1], ".", color="#dddddd", label="eyes and brows: not used")
    for name, region, colour in GROUPS:
        axes.plot(*points.region(face, region).T, "o", color=colour, markersize=5, label=name)
    for number, (x, y) in enumerate(face):
        axes.annotate(str(number), (x, y), xytext=(3, 3), textcoords="offset points", fontsize=7)
    axes.invert_yaxis()
    axes.set_aspect("equal")
    axes.axis("off")
    axes.legend(loc="upper center", ncols=2, fontsize=8, frameon=False, bbox_to_anchor=(0.5, 1.08))
    figure.savefig(Path(__file__).with_name("points.png"), bbox_inches="tight", metadata={"Software": None})


if __name__ == "__main__":
    main()
