"""Speed and steadiness of the landmarks on GRID, and which recordings are screened out.

``python -m benchmarks.landmarks_grid [every]`` (every: take each so-many-th recording; default 4). Times are process
CPU times of this one process, decoding included. Where other processes share caches and memory they still count, so
the fastest quarter of the recordings is given beside the mean.
"""

import sys
import time

import numpy as np

from tests.paths import grid_root
from visualspeech.errors import RejectedUtterance
from visualspeech.face.dlib_tracker import DlibTracker
from visualspeech.face.screening import landmark_steps, track_screened
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.media.reading import read_frames

PARTS = {"nose": range(27, 36), "mouth": range(48, 68), "jaw": range(17)}


def jitter(points: np.ndarray, part: str) -> float:
    """Mean length of the second difference in time, in pixels."""
    return float(np.linalg.norm(np.diff(points[:, list(PARTS[part])], 2, axis=0), axis=-1).mean())


class EveryFrame(DlibTracker):
    """The plain way: detect in every frame."""

    def next(self, frame):
        self._box = None
        self._frame = 1
        return super().next(frame)


def counted(frames, passed):
    """The frames, counted in ``passed[0]`` on their way."""
    for frame in frames:
        passed[0] += 1
        yield frame


def detect_every_frame(files, settings) -> float:
    """Frames a second when the face is searched for anew in every frame."""
    start, frames = time.process_time(), 0
    for file in files:
        tracker = EveryFrame(settings, 25.0)
        for frame in read_frames(file):
            tracker.next(frame)
            frames += 1
    return frames / (time.process_time() - start)


def main() -> None:
    root = grid_root()
    if root is None:
        sys.exit("GRID is not here: set GRID_ROOT to the folder that holds s1/*.mpg.")
    every = int(sys.argv[1]) if len(sys.argv) > 1 else 4
    files = sorted((root / "s1").glob("*.mpg"))[::every]
    settings = LandmarkSettings()
    plain = detect_every_frame(files[:6], settings)
    frames, seconds, tracked, rejected, step = [], [], [], {}, []
    for file in files:
        start = time.process_time()
        passed = [0]
        try:
            landmarks = track_screened(counted(read_frames(file), passed), 25.0, settings)
        except RejectedUtterance as error:
            rejected[file.stem] = error.reason
        else:
            tracked.append(landmarks.points)
            step.append(landmark_steps(landmarks.points).max())
        seconds.append(time.process_time() - start)
        frames.append(passed[0])
    speed = sum(frames) / sum(seconds)
    fastest = np.percentile(np.array(frames) / np.array(seconds), 75)
    print(
        f"{len(files)} recordings, {sum(frames)} frames: {speed:.0f} frames/s a core with tracking, screening and "
        f"decoding; {fastest:.0f} in the fastest quarter"
    )
    print(f"searching every frame: {plain:.0f} frames/s; ratio {speed / plain:.1f}")
    for part in PARTS:
        print(f"jitter {part:5s} {np.mean([jitter(points, part) for points in tracked]):.3f} px mean second difference")
    print(f"kept: largest step {max(step):.2%} of the face's width")
    print(f"rejected {len(rejected)}:")
    for name, reason in rejected.items():
        print(f"  {name}: {reason}")


if __name__ == "__main__":
    main()
