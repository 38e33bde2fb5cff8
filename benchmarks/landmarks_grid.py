"""Speed and jitter of landmark tracking on GRID, and which recordings the screening rejects.

Run: python -m benchmarks.landmarks_grid [EVERY]

Tracks every EVERY-th recording (4). Times are processor time of this process, decoding included. Other processes slow
it down through shared caches and memory, so the fastest quarter of the recordings is given beside the mean.
"""

import time

import numpy as np

from benchmarks.command import grid, run_main
from visualspeech.errors import RejectedUtterance
from visualspeech.face.dlib_tracker import DlibTracker
from visualspeech.face.screening import landmark_steps, track_screened
from visualspeech.face.tracker import LandmarkSettings, TrackedVideo
from visualspeech.media.reading import read_frames

PARTS = {"nose": range(27, 36), "mouth": range(48, 68), "jaw": range(17)}


def jitter(points: np.ndarray, part: str) -> float:
    """Mean length of the second difference in time, in pixels."""
    return float(np.linalg.norm(np.diff(points[:, list(PARTS[part])], 2, axis=0), axis=-1).mean())


class EveryFrame(DlibTracker):
    """For comparison: detection in every frame."""

    def next(self, frame, number):
        self._box = None
        self._frame = 1
        return super().next(frame, number)


def counted(frames, passed):
    """The frames, counted in ``passed[0]``."""
    for frame in frames:
        passed[0] += 1
        yield frame


def detect_every_frame(files, settings) -> float:
    """Frames per second with detection in every frame."""
    begin, frames = time.process_time(), 0
    for file in files:
        tracker = EveryFrame(settings, TrackedVideo(str(file), 25.0))
        for number, frame in enumerate(read_frames(file)):
            tracker.next(frame, number)
            frames += 1
    return frames / (time.process_time() - begin)


def main(every: int = 4) -> None:
    files = sorted((grid() / "s1").glob("*.mpg"))[::every]
    settings = LandmarkSettings()
    plain = detect_every_frame(files[:6], settings)
    frames, seconds, tracked, rejected, step = [], [], [], {}, []
    for file in files:
        begin = time.process_time()
        passed = [0]
        try:
            landmarks = track_screened(counted(read_frames(file), passed), 25.0, settings)
        except RejectedUtterance as error:
            rejected[file.stem] = error.reason
        else:
            tracked.append(landmarks.points)
            step.append(landmark_steps(landmarks.points).max())
        seconds.append(time.process_time() - begin)
        frames.append(passed[0])
    speed = sum(frames) / sum(seconds)
    fastest = np.percentile(np.array(frames) / np.array(seconds), 75)
    print(
        f"{len(files)} recordings, {sum(frames)} frames: {speed:.0f} frames/s per core with tracking, screening and "
        f"decoding; {fastest:.0f} in the fastest quarter"
    )
    print(f"detection in every frame: {plain:.0f} frames/s; ratio {speed / plain:.1f}")
    for part in PARTS:
        print(f"jitter {part:5s} {np.mean([jitter(points, part) for points in tracked]):.3f} px mean second difference")
    print(f"kept: largest step {max(step):.2%} of the face's width")
    print(f"rejected {len(rejected)}:")
    for name, reason in rejected.items():
        print(f"  {name}: {reason}")


if __name__ == "__main__":
    run_main(main, __doc__)
