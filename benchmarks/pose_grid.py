"""How still the head is after normalisation on GRID, beside simpler ways, and what the assumed focal length matters.

``python -m benchmarks.pose_grid [every]`` (every: take each so-many-th recording; default 8). The figures, in pixels:

- rigid: RMS movement of the 13 rigid points around their own means, within recordings
- everywhere: the same around their means over all recordings, so that leaning and moving the chair count
- jitter: mean length of the second difference in time
- spread: RMS movement of a part around its mean, within recordings
"""

import sys
import time
from dataclasses import replace

import numpy as np

from benchmarks.landmarks_grid import PARTS, jitter
from tests.paths import grid_root
from visualspeech.errors import RejectedUtterance
from visualspeech.face.head import PoseSettings, fit_head
from visualspeech.face.pose import estimate, rigid_error, to_frontal, to_image
from visualspeech.face.screening import track_screened
from visualspeech.face.tracker import RIGID
from visualspeech.media.reading import read_frames


def normalised_by_a_plane_map(points: np.ndarray, goal: np.ndarray, affine: bool) -> np.ndarray:
    """Frames (T, 68, 2) brought onto the goal's rigid points by the best similarity or affine map of each frame."""
    moved = np.empty_like(points)
    for number, frame in enumerate(points):
        seen, wanted = frame[RIGID], goal[RIGID]
        one, zero = np.ones(len(seen)), np.zeros(len(seen))
        if affine:
            design = np.column_stack([seen, one])
            moved[number] = np.column_stack([frame, np.ones(68)]) @ np.linalg.lstsq(design, wanted, rcond=None)[0]
        else:
            rows_x = np.column_stack([seen[:, 0], -seen[:, 1], one, zero])
            rows_y = np.column_stack([seen[:, 1], seen[:, 0], zero, one])
            a, b, x, y = np.linalg.lstsq(np.vstack([rows_x, rows_y]), wanted.T.ravel(), rcond=None)[0]
            moved[number] = frame @ np.array([[a, b], [-b, a]]) + (x, y)
    return moved


def spread(points: np.ndarray, part) -> float:
    """RMS distance of the part's points from their means in time."""
    chosen = points[:, list(part)]
    return float(np.sqrt(((chosen - chosen.mean(0)) ** 2).sum(2).mean()))


def show(name: str, recordings: list[np.ndarray]) -> None:
    """One line of the table."""
    rigid = np.sqrt(np.mean([spread(points, RIGID) ** 2 for points in recordings]))
    print(
        f"{name:16s} {rigid:6.3f} {max(spread(points, RIGID) for points in recordings):6.3f} "
        f"{spread(np.concatenate(recordings), RIGID):10.3f} "
        + " ".join(f"{np.mean([jitter(points, part) for points in recordings]):7.3f}" for part in PARTS)
        + " "
        + " ".join(f"{np.mean([spread(points, PARTS[part]) for points in recordings]):7.3f}" for part in PARTS)
    )


RATE = 25.0  # Hz, of GRID


def main() -> None:
    root = grid_root()
    if root is None:
        sys.exit("GRID is not here: set GRID_ROOT to the folder that holds s1/*.mpg.")
    every = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    recordings = []
    for file in sorted((root / "s1").glob("*.mpg"))[::every]:
        try:
            recordings.append(track_screened(read_frames(file), RATE).points.astype(float))
        except RejectedUtterance as error:
            print(f"left out {file.stem}: {error.reason}")
    sample = np.concatenate([points[5::10] for points in recordings])
    start = time.process_time()
    head = fit_head(sample, (360, 288))
    fitted = time.process_time() - start
    start = time.process_time()
    poses = [estimate(points, head, rate=RATE) for points in recordings]
    frontal = [to_frontal(points, pose, head) for points, pose in zip(recordings, poses, strict=True)]
    speed = sum(map(len, recordings)) / (time.process_time() - start)
    back = max(
        np.abs(to_image(flat, pose, head) - points).max()
        for flat, pose, points in zip(frontal, poses, recordings, strict=True)
    )
    print(f"{len(recordings)} recordings; head fitted in {fitted:.1f} s, poses at {speed:.0f} frames/s a core")
    print(f"there and back: {back:.1e} px; worst recording {max(rigid_error(f, head) for f in frontal):.2f} px")
    names = [f"jit.{part}" for part in PARTS] + [f"sp.{part}" for part in PARTS]
    print(f"{'':16s} {'rigid':>6s} {'worst':>6s} {'everywhere':>10s} " + " ".join(f"{n[:7]:>7s}" for n in names))
    show("recorded", recordings)
    show("head pose", frontal)
    goal = head.mean_points
    show("similarity", [normalised_by_a_plane_map(points, goal, False) for points in recordings])
    show("affine", [normalised_by_a_plane_map(points, goal, True) for points in recordings])
    for focal in (1.0, 4.0):
        other = fit_head(sample, (360, 288), replace(PoseSettings(), focal_length=focal))
        show(
            f"focal {focal:g}", [to_frontal(points, estimate(points, other, rate=RATE), other) for points in recordings]
        )
    for rotation, place in ((0.0, 0.0), (0.16, 0.04)):
        settings = replace(PoseSettings(), rotation_smoothing=rotation, translation_smoothing=place)
        show(
            f"smoothed {rotation:g}, {place:g} s",
            [to_frontal(points, estimate(points, head, settings, rate=RATE), head) for points in recordings],
        )


if __name__ == "__main__":
    main()
