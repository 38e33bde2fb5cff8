"""Landmarks: the 68 iBUG points of the speaker's face in every frame of a recording.

The tracker is replaceable: whatever satisfies :class:`visualspeech.face.tracker.Tracker` can be named in the settings.
The default one is dlib's regression-tree predictor (Kazemi & Sullivan, CVPR 2014), fed with a crop that follows the
face. Landmarks of another program can be read from files instead (:mod:`visualspeech.face.landmark_csv`).

Licence of the default tracker's model: the 68-point model file of ``face-recognition-models`` was trained on the iBUG
300-W images, whose licence excludes commercial use. Ask Imperial College London before you use it in a product, or name
another tracker.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.face.tracker import POINTS, LandmarkSettings, TrackedVideo
from visualspeech.face.tracker_loading import checked_points, load_tracker


@dataclass(frozen=True)
class Landmarks:
    """Points of one utterance.

    Parameters
    ----------
    points : (T, 68, 2) float32, image pixels (x right, y down), iBUG order; interpolated where no face was found
    detected : (T,) bool, False where the points are interpolated
    width, height : size of the frames in pixels
    findings : warnings that do not reject the utterance, one sentence each
    """

    points: np.ndarray
    detected: np.ndarray
    width: int
    height: int
    findings: tuple[str, ...] = ()


def track(
    frames: Iterable[np.ndarray],
    settings: LandmarkSettings | None = None,
    *,
    rate: float,
    path: str = "",
    first: int = 0,
    folder: str = "",
) -> Landmarks:
    """Follow the face through a recording. Frames are taken one at a time, so memory does not grow with their size.

    Parameters
    ----------
    frames : RGB frames (height, width, 3) uint8, all of one size
    settings : tracker and its settings
    rate : frame rate in Hz
    path, first : of the recording, and the number in it of the first frame; trackers are told both
    folder : in which the module of a tracker of one's own lies (:func:`load_tracker`)

    Raises
    ------
    RejectedUtterance
        There are no frames, their size changes, there is no face, or it is missing in too many frames.
    SettingError
        A tracker of one's own cannot be loaded, or returns no points.
    """
    settings = settings or LandmarkSettings()
    video = TrackedVideo(str(path), rate, first)
    tracker = load_tracker(settings, video, folder)
    found, size = [], None
    for number, frame in enumerate(frames, start=first):
        if size is not None and frame.shape[:2] != size:
            raise RejectedUtterance(
                "the frame size changes within the recording", "Convert the video to one frame size."
            )
        size = frame.shape[:2]
        found.append(checked_points(tracker.next(frame, number), settings, video, number))
    if size is None:
        raise RejectedUtterance("no video frames", "The video stream is empty: copy or record the file again.")
    detected = np.array([points is not None for points in found])
    warnings = list(getattr(tracker, "warnings", list)())
    try:
        check_coverage(detected, rate, settings)
    except RejectedUtterance as error:
        remedy = getattr(tracker, "remedy", error.remedy)
        raise RejectedUtterance("; ".join([error.reason, *warnings]), remedy) from error
    points = fill_gaps(np.stack([np.full((POINTS, 2), np.nan) if p is None else p for p in found]), detected)
    faces, findings = getattr(tracker, "faces", lambda: 1)(), [*warnings]
    if faces > 1:
        findings.append(f"{faces} faces in one frame; the largest was followed")
    if not detected.all():
        findings.append(f"no face in {(~detected).sum()} of {len(detected)} frames; their points are interpolated")
    return Landmarks(
        points=smooth(points, settings.smoothing * rate).astype(np.float32),
        detected=detected,
        width=size[1],
        height=size[0],
        findings=tuple(findings),
    )


def check_coverage(detected: np.ndarray, rate: float, settings: LandmarkSettings) -> None:
    """Reject an utterance whose face is missing for too long: ``detected`` (T,) bool at ``rate`` Hz.

    Raises
    ------
    RejectedUtterance
        No face at all, too large a share of frames, or too long a run of frames without one.
    """
    remedy = "Light and frame the face so that eyes, nose and mouth are visible throughout, or leave this file out."
    missing = int((~detected).sum())
    if missing == len(detected):
        raise RejectedUtterance("no face in any frame", remedy)
    if missing > settings.max_missing_share * len(detected):
        raise RejectedUtterance(f"no face in {missing} of {len(detected)} frames", remedy)
    longest = longest_run(~detected)
    if longest > settings.max_missing_seconds * rate:
        raise RejectedUtterance(f"no face for {longest / rate:.2f} s without interruption", remedy)


def longest_run(flags: np.ndarray) -> int:
    """Length of the longest run of True in ``flags`` (T,)."""
    edges = np.diff(np.concatenate([[0], flags.astype(int), [0]]))
    starts, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return int((ends - starts).max(initial=0))


def fill_gaps(points: np.ndarray, detected: np.ndarray) -> np.ndarray:
    """Points (T, n, 2) with those of undetected frames interpolated linearly in time, held at the ends."""
    times = np.arange(len(points))
    flat = points.reshape(len(points), -1)
    filled = np.stack([np.interp(times, times[detected], column[detected]) for column in flat.T], axis=1)
    return filled.reshape(points.shape)


def smooth(points: np.ndarray, deviation: float) -> np.ndarray:
    """Points (T, n, 2) smoothed in time by a Gaussian of ``deviation`` frames (0: unchanged).

    Beyond the ends the first and the last frame are repeated.
    """
    if deviation <= 0:
        return points
    from scipy.ndimage import gaussian_filter1d

    return gaussian_filter1d(points, deviation, axis=0, mode="nearest", truncate=4.0)
