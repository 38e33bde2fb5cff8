"""Pictures of classes of dynamic visemes: the faces at the beginning, middle and end of their mean gestures."""

from collections.abc import Sequence

import numpy as np

from visualspeech.evaluation import plots
from visualspeech.face.aam.model import Aam
from visualspeech.face.aam.modes import face_pictures
from visualspeech.face.aam.reference import Reference
from visualspeech.features.visemes.classes import VisemeClasses

SHOWN = 8
MOMENTS = ("start", "middle", "end")


def mean_gestures(classes: VisemeClasses) -> list[tuple[int, float, np.ndarray]]:
    """Number, share of the training gestures, and mean gesture (points, D) of each class, the most frequent first."""
    shares = classes.counts / max(classes.counts.sum(), 1)
    return [
        (int(number), float(shares[number]), classes.means[number]) for number in np.argsort(-shares, kind="stable")
    ]


def viseme_pictures(classes: VisemeClasses, aam: Aam, reference: Reference, count: int = SHOWN) -> bytes:
    """A PNG of the most frequent classes, a column each: the face as a gesture begins, in its middle, as it ends."""
    chosen = mean_gestures(classes)[:count]
    faces = np.concatenate([gesture[moments(len(gesture))] for _, _, gesture in chosen])
    pictures = np.array(face_pictures(aam, reference, faces))
    grid = pictures.reshape(len(chosen), len(MOMENTS), *pictures.shape[1:]).swapaxes(0, 1)
    return plots.mode_pictures(grid, MOMENTS, [f"{number} ({share:.1%})" for number, share, _ in chosen])


def moments(points: int) -> Sequence[int]:
    """Points of a shape at its beginning, in its middle and at its end."""
    return [0, points // 2, points - 1]
