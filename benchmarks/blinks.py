"""Blinks in the recordings of GRID, and the recordings that are chosen as background with and without regard to them.

Run: python -m benchmarks.blinks [EVERY]

Tracks every EVERY-th recording (1). Prints how many have a double blink, by threshold of the eye aspect ratio; how many
of the recordings chosen for 9 s of background have one, of all recordings and of 50 random samples of two fifths of
them; and how far the chosen ones lie from the most usual one. Light is the mean colour of the face.
"""

from itertools import islice

import numpy as np

from benchmarks.command import grid, run_main
from visualspeech.animation import background
from visualspeech.errors import RejectedUtterance
from visualspeech.face.blinks import DOUBLE, blinks, double_blinks, eyes_closed
from visualspeech.face.drift import FaceReference
from visualspeech.face.screening import track_recording
from visualspeech.face.tracker import RIGID
from visualspeech.media.reading import read_frames

RATE, SECONDS = 25.0, 9.0


def light(file, points: np.ndarray) -> np.ndarray:
    """Mean colour (3,) of the face below the brows, in the eleventh frame."""
    import cv2

    frame = next(islice(read_frames(file), 10, None))
    face = np.zeros(frame.shape[:2], np.uint8)
    cv2.fillConvexPoly(face, cv2.convexHull(np.rint(points[10, :36]).astype(np.int32)), 255)
    return np.array(cv2.mean(frame, face)[:3], np.float32)


def chosen(faces: dict, names, mind: bool) -> list[str]:
    """Recordings of those named that are chosen; with ``mind`` false as if no recording had a double blink."""
    known = background.blinks.double_blinks
    try:
        if not mind:
            background.blinks.double_blinks = lambda *_: 0
        return background.choose_recordings(((name, *faces[name]) for name in names), SECONDS, RATE)
    finally:
        background.blinks.double_blinks = known


def apart(faces: dict, names: list[str]) -> list[float]:
    """Distance of each recording to the first, in pixels of the head's position plus grey levels."""
    seats = [np.median(faces[name][0][:, RIGID], axis=0) for name in names]
    lights = [faces[name][1].texture for name in names]
    return [
        float(np.sqrt(((seat - seats[0]) ** 2).mean()) + np.sqrt(((one - lights[0]) ** 2).mean()))
        for seat, one in zip(seats, lights, strict=True)
    ]


def main(every: int = 1) -> None:
    faces = {}
    for file in sorted((grid() / "s1").glob("*.mpg"))[::every]:
        try:
            points = track_recording(file, 0, 0)[0].points
        except RejectedUtterance:
            continue
        faces[file.stem] = points, FaceReference(np.zeros(1, np.float32), light(file, points))
    for share in (0.6, 0.65, 0.7, 0.75, 0.8):
        found = [blinks(eyes_closed(points, share)) for points, _ in faces.values()]
        pairs = sum(((one[1:, 0] - one[:-1, 1]) / RATE < DOUBLE).any() for one in found)
        count = sum(map(len, found))
        print(f"closed below {share:.2f} of the median: {count} blinks, {pairs} of {len(faces)} with a double blink")
    for mind in (False, True):
        names = chosen(faces, faces, mind)
        doubled = [double_blinks(faces[name][0], RATE) for name in names]
        distances = ", ".join(f"{one:.1f}" for one in apart(faces, names))
        random, total, bad = np.random.default_rng(0), 0, 0
        for _ in range(50):
            sample = sorted(random.choice(list(faces), len(faces) * 2 // 5, replace=False))
            taken = chosen(faces, sample, mind)
            total, bad = total + len(taken), bad + sum(double_blinks(faces[name][0], RATE) > 0 for name in taken)
        print(
            f"{'with' if mind else 'without'} the rule: {', '.join(names)}, double blinks {doubled}, distances "
            f"{distances}; of samples {bad} of {total} chosen recordings with a double blink"
        )


if __name__ == "__main__":
    run_main(main, __doc__)
