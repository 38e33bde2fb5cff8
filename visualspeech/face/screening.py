"""Screening: recordings whose video is broken, although it can be decoded.

A single broken utterance in the validation set disturbs early stopping, so utterances are screened before training: by
their frames (grey, frozen or jumping ones, as in damaged streams), by their landmarks (jumps) and by their pose (rigid
points that move). The limits were set on GRID, where broken utterances are clearly separated from the others;
``benchmarks/landmarks_grid.py`` prints the figures.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.face.landmarks import Landmarks, longest_run, track
from visualspeech.face.tracker import LandmarkSettings
from visualspeech.fields import Settings, setting

REMEDY = "Play the recording; copy or convert it again from its source, or leave it out."
# Frames are compared at this size: coding noise averages out, broken blocks do not.
SMALL = (90, 72)


@dataclass(frozen=True)
class ScreeningSettings(Settings):
    """Limits beyond which the video of an utterance, or its landmarks, count as broken.

    A frame jumps where it differs from the frame before by more than both limits: in absolute terms, and relative to
    the frames around it (a fast movement changes many frames, a damaged frame only one).
    """

    section = "screening"
    min_contrast: float = setting(
        4.0,
        "Standard deviation of the pixels of a frame, in grey levels, below which the frame counts as blank.",
        minimum=0,
        maximum=128,
    )
    max_blank_seconds: float = setting(
        0.0, "An utterance with more blank frames than this, in seconds, is rejected.", minimum=0, maximum=3600
    )
    max_frozen_seconds: float = setting(
        0.4,
        "An utterance is rejected if its video shows identical frames for longer than this, in seconds.",
        minimum=0,
        maximum=3600,
    )
    max_frame_change: float = setting(
        1.5,
        "Mean absolute difference to the previous frame, in grey levels, above which a frame may be a jump; an "
        "utterance with a jump is rejected.",
        minimum=0,
        maximum=255,
    )
    max_frame_change_ratio: float = setting(
        4.5,
        "The same as a multiple of the median difference around the frame; a jump exceeds both limits.",
        minimum=0,
        maximum=1000,
    )
    max_landmark_step: float = setting(
        0.035,
        "Mean step of the landmarks since the previous frame, as a share of the face's width, above which they may "
        "have jumped; an utterance with such a jump is rejected.",
        minimum=0,
        maximum=10,
    )
    max_landmark_step_ratio: float = setting(
        3.0,
        "The same as a multiple of the median step around the frame; a jump exceeds both limits.",
        minimum=0,
        maximum=1000,
    )
    max_rigid_error_ratio: float = setting(
        1.8,
        "An utterance is rejected if its rigid landmarks move by more than this multiple of the speaker's median after "
        "pose normalisation.",
        minimum=0,
        maximum=1000,
    )


@dataclass(frozen=True)
class FrameMeasures:
    """Contrast and change of the frames of one recording.

    Parameters
    ----------
    deviation : (T,) standard deviation of each frame in grey levels
    change : (T,) mean absolute difference to the frame before in grey levels, 0 for the first
    """

    deviation: np.ndarray
    change: np.ndarray


class FrameWatch:
    """Measures frames of a stream: ``watch = FrameWatch(); track(watch.through(frames)); watch.measures()``."""

    def __init__(self) -> None:
        self._deviation, self._change, self._last = [], [], None

    def through(self, frames: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
        """Yield the frames, (height, width, 3) uint8 RGB, unchanged."""
        import cv2

        for frame in frames:
            # Grey levels as the mean of the colours are accurate enough here, and cheap in the reduced frame.
            small = cv2.resize(frame, SMALL, interpolation=cv2.INTER_AREA).mean(axis=2, dtype=np.float32)
            self._deviation.append(float(small.std()))
            self._change.append(0.0 if self._last is None else float(np.abs(small - self._last).mean()))
            self._last = small
            yield frame

    def measures(self) -> FrameMeasures:
        """The measures of the frames that have passed."""
        return FrameMeasures(np.array(self._deviation), np.array(self._change))


def track_screened(
    frames: Iterable[np.ndarray],
    rate: float,
    landmark_settings: LandmarkSettings | None = None,
    settings: ScreeningSettings | None = None,
    **video,
) -> Landmarks:
    """Track the face of one recording and judge it.

    Parameters
    ----------
    video : ``path``, ``first`` and ``folder`` of :func:`visualspeech.face.landmarks.track`

    Raises
    ------
    RejectedUtterance
        The recording is broken or has no usable face; if both are true, the message is about the recording.
    """
    settings = settings or ScreeningSettings()
    watch = FrameWatch()
    try:
        landmarks = track(watch.through(_in_runs(frames)), landmark_settings, rate=rate, **video)
    except RejectedUtterance:
        check_frames(watch.measures(), rate, settings)
        raise
    check_frames(watch.measures(), rate, settings)
    check_points(landmarks.points, settings)
    return landmarks


def track_recording(
    path: str | Path,
    start: float,
    end: float,
    landmark_settings: LandmarkSettings | None = None,
    settings: ScreeningSettings | None = None,
    folder: str = "",
) -> tuple[Landmarks, float]:
    """Landmarks of a segment of a recording (:func:`track_screened`), and its frame rate in Hz.

    Parameters
    ----------
    start, end : seconds, as for :func:`visualspeech.media.reading.read_frames`
    folder : in which the module of a tracker of one's own lies

    Raises
    ------
    RejectedUtterance
        The recording cannot be read, is broken or has no usable face.
    SettingError
        A tracker of one's own cannot be loaded, or returns no points.
    """
    from visualspeech.media.reading import probe, read_frames

    rate = probe(path).rate
    video = {"path": str(path), "first": int(np.floor(start * rate + 0.5)), "folder": folder}
    return track_screened(read_frames(path, start, end), rate, landmark_settings, settings, **video), rate


def _in_runs(frames: Iterable[np.ndarray], size: int = 25) -> Iterator[np.ndarray]:
    """The frames, decoded in runs, because decoder and tracker in alternation evict each other's cached data."""
    frames = iter(frames)
    while run := list(islice(frames, size)):
        yield from run


def check_frames(measures: FrameMeasures, rate: float, settings: ScreeningSettings | None = None) -> None:
    """Check the frames of one recording at ``rate`` Hz.

    Raises
    ------
    RejectedUtterance
        Too many frames are blank or frozen, or the video jumps between two frames.
    """
    settings = settings or ScreeningSettings()
    flat = int((measures.deviation < settings.min_contrast).sum())
    if flat / rate > settings.max_blank_seconds:
        raise RejectedUtterance(f"{flat} frames show a single colour", REMEDY)
    frozen = longest_run(measures.change[1:] < 1e-3) / rate
    if frozen > settings.max_frozen_seconds:
        raise RejectedUtterance(f"the video is frozen for {frozen:.2f} s", REMEDY)
    ratio = isolated(measures.change)
    jumps = np.flatnonzero((ratio > settings.max_frame_change_ratio) & (measures.change > settings.max_frame_change))
    if len(jumps):
        raise RejectedUtterance(
            f"the video jumps at {jumps[0] / rate:.2f} s ({ratio[jumps[0]]:.0f} times the usual change between "
            "frames: damaged frames, or a cut)",
            REMEDY,
        )


def check_points(points: np.ndarray, settings: ScreeningSettings | None = None) -> None:
    """Check the landmarks of one recording, (T, 68, 2) image pixels.

    Raises
    ------
    RejectedUtterance
        The landmarks jump between two frames.
    """
    settings = settings or ScreeningSettings()
    step = landmark_steps(points)
    jumps = np.flatnonzero((step > settings.max_landmark_step) & (isolated(step) > settings.max_landmark_step_ratio))
    if len(jumps):
        raise RejectedUtterance(
            f"the landmarks jump by {step[jumps].max():.0%} of the face's width in frame {jumps[0]}", REMEDY
        )


def screen_rigid_errors(
    errors: Mapping[str, float],
    training: Collection[str],
    settings: ScreeningSettings | None = None,
    min_utterances: int = 10,
) -> dict[str, RejectedUtterance]:
    """Rejections of a speaker's utterances whose rigid points move far more than is usual for this speaker.

    Parameters
    ----------
    errors : utterance id -> RMS movement of the rigid points after normalisation, in pixels
    training : the training utterances, of which the median is taken
    min_utterances : with fewer of them the median is unreliable, and none is rejected
    """
    settings = settings or ScreeningSettings()
    known = [error for name, error in errors.items() if name in training]
    if len(known) < min_utterances:
        return {}
    usual = float(np.median(known))
    return {
        name: RejectedUtterance(
            f"nose and eyes move by {error:.2f} px after head-pose normalisation, {error / usual:.1f} times the median",
            REMEDY,
        )
        for name, error in sorted(errors.items())
        if error > settings.max_rigid_error_ratio * usual
    }


def landmark_steps(points: np.ndarray) -> np.ndarray:
    """Mean step (T,) of the landmarks (T, 68, 2) since the frame before, as a share of the width of the face."""
    width = np.median(np.ptp(points[..., 0], axis=1))
    step = np.linalg.norm(np.diff(points, axis=0), axis=2).mean(1) / max(float(width), 1e-9)
    return np.concatenate([[0.0], step])


def isolated(values: np.ndarray, reach: int = 4) -> np.ndarray:
    """Each value of (T,) as a multiple of the median of the values up to ``reach`` frames around it.

    Fast head movement changes many frames, a damaged frame only one.
    """
    if len(values) < 3:
        return np.zeros(len(values))
    padded = np.concatenate([np.full(reach, np.nan), [np.nan], values[1:], np.full(reach, np.nan)])
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).copy()
    windows[:, reach] = np.nan
    usual = np.nanmedian(windows, axis=1)
    # Without a floor, any change would be a large multiple where almost nothing moves.
    floor = max(0.5 * float(np.median(values[1:])), 1e-9)
    return values / np.maximum(usual, floor)
