"""How still the head is after pose normalisation on GRID, beside simpler methods; effect of the assumed focal length.

Run: python -m benchmarks.pose_grid [EVERY]

Reads every EVERY-th recording (8). The figures, in pixels:

- rigid: RMS movement of the 13 rigid points around their own means, within recordings
- everywhere: the same around their means over all recordings, which includes changes of posture between them
- jitter: mean length of the second difference over time
- spread: RMS movement of a part around its mean, within recordings
"""

import time
from dataclasses import replace

import numpy as np

from benchmarks.command import grid, run_main
from benchmarks.landmarks_grid import PARTS, jitter
from visualspeech.errors import RejectedUtterance
from visualspeech.face.head import PoseSettings, fit_head
from visualspeech.face.pose import estimate, rigid_error, to_frontal, to_image
from visualspeech.face.screening import track_screened
from visualspeech.face.tracker import RIGID
from visualspeech.media.reading import read_frames


def normalised_in_the_plane(points: np.ndarray, goal: np.ndarray, affine: bool) -> np.ndarray:
    """Frames (T, 68, 2), each mapped onto the goal's rigid points by the best similarity or affine transform."""
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


def main(every: int = 8) -> None:
    recordings = []
    for file in sorted((grid() / "s1").glob("*.mpg"))[::every]:
        try:
            recordings.append(track_screened(read_frames(file), RATE).points.astype(float))
        except RejectedUtterance as error:
            print(f"rejected {file.stem}: {error.reason}")
    sample = np.concatenate([points[5::10] for points in recordings])
    begin = time.process_time()
    head = fit_head(sample, (360, 288))
    fitted = time.process_time() - begin
    begin = time.process_time()
    poses = [estimate(points, head, rate=RATE) for points in recordings]
    frontal = [to_frontal(points, pose, head) for points, pose in zip(recordings, poses, strict=True)]
    speed = sum(map(len, recordings)) / (time.process_time() - begin)
    back = max(
        np.abs(to_image(flat, pose, head) - points).max()
        for flat, pose, points in zip(frontal, poses, recordings, strict=True)
    )
    print(f"{len(recordings)} recordings; head fitted in {fitted:.1f} s, poses at {speed:.0f} frames/s per core")
    print(f"round trip: {back:.1e} px; worst recording {max(rigid_error(f, head) for f in frontal):.2f} px")
    names = [f"jit.{part}" for part in PARTS] + [f"sp.{part}" for part in PARTS]
    print(f"{'':16s} {'rigid':>6s} {'worst':>6s} {'everywhere':>10s} " + " ".join(f"{n[:7]:>7s}" for n in names))
    show("recorded", recordings)
    show("head pose", frontal)
    goal = head.mean_points
    show("similarity", [normalised_in_the_plane(points, goal, False) for points in recordings])
    show("affine", [normalised_in_the_plane(points, goal, True) for points in recordings])
    for focal in (1.0, 4.0):
        other = fit_head(sample, (360, 288), replace(PoseSettings(), focal_length=focal))
        show(
            f"focal {focal:g}", [to_frontal(points, estimate(points, other, rate=RATE), other) for points in recordings]
        )
    for rotation, translation in ((0.0, 0.0), (0.16, 0.04)):
        settings = replace(PoseSettings(), rotation_smoothing=rotation, translation_smoothing=translation)
        show(
            f"smoothed {rotation:g}, {translation:g} s",
            [to_frontal(points, estimate(points, head, settings, rate=RATE), head) for points in recordings],
        )


if __name__ == "__main__":
    run_main(main, __doc__)
