"""Landmark files as OpenFace writes them."""

import numpy as np

HEADER = ["frame", "face_id", "timestamp", "confidence", "success", "gaze_0_x", "eye_lmk_x_0"]
POINTS = [f"{axis}_{number}" for axis in "xy" for number in range(68)]


def rows(points, rate=25.0, face=0, confidence=0.98, success=1, shift=0.0):
    """Values of the rows of landmarks (T, 68, 2), in the order of the header."""
    return [
        [i + 1, face, round(i / rate + shift, 3), confidence, success, 0.01, 200.5, *one[:, 0], *one[:, 1]]
        for i, one in enumerate(points)
    ]


def write(path, values, header=None, separator=", ", end="\n"):
    """Write a file with OpenFace's spaces after the commas."""
    lines = [separator.join(header or [*HEADER, *POINTS])]
    lines += [separator.join(one if isinstance(one, str) else f"{one:g}" for one in row) for row in values]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes((end.join(lines) + end).encode())
    return path


def moving(frames=20, seed=0):
    """Landmarks (frames, 68, 2) that move a little in a frame of 200 x 160 pixels, in hundredths of a pixel."""
    rng = np.random.default_rng(seed)
    points = rng.uniform((60, 40), (140, 120), (68, 2)) + 0.25 * np.arange(frames)[:, None, None]
    return np.round(points, 2)
