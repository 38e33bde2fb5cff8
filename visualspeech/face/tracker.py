"""The interface of landmark trackers, their points and their settings."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from visualspeech.fields import Settings, setting

POINTS = 68
# Landmarks that move with the skull only: bridge and base of the nose, corners of the eyes.
RIGID = np.array([27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 39, 42, 45])


def _dlib(settings: "LandmarkSettings", rate: float) -> "Tracker":
    from visualspeech.face.dlib_tracker import DlibTracker

    return DlibTracker(settings, rate)


#: Name in the settings -> function that makes a tracker of one recording from the settings and the frame rate in Hz.
TRACKERS: dict[str, Callable[["LandmarkSettings", float], "Tracker"]] = {"dlib": _dlib}


@dataclass(frozen=True)
class LandmarkSettings(Settings):
    """Detection and tracking of the speaker's face."""

    section = "landmarks"
    tracker: str = setting("dlib", "Name of the landmark tracker.", choices=TRACKERS)
    face_pixels: int = setting(
        400,
        "Side length, in pixels, to which the face box is scaled before landmarks are predicted; larger is more "
        "precise (landmarks are whole pixels of the scaled face) and slower.",
        minimum=100,
        maximum=4000,
    )
    num_jitters: int = setting(
        1, "Number of slightly shifted face boxes per frame whose landmarks are averaged.", minimum=1, maximum=100
    )
    detector_pixels: int = setting(
        640,
        "Longest side, in pixels, of the frame in which faces are detected; larger frames are scaled down.",
        minimum=80,
        maximum=10_000,
    )
    detection_interval: float = setting(
        1.0, "Time between two face detections on the whole frame, in seconds.", minimum=0, maximum=3600
    )
    similarity_threshold: float = setting(
        0.8,
        "Correlation of the face with the last confirmed one below which the face detector is run again.",
        minimum=0,
        maximum=1,
    )
    smoothing: float = setting(
        0.016,
        "Standard deviation, in seconds, of the Gaussian that smooths the landmarks over time; 0 for none.",
        minimum=0,
        maximum=10,
    )
    max_missing_share: float = setting(
        0.2,
        "An utterance is rejected if no face is found in a larger share of its frames than this.",
        minimum=0,
        maximum=1,
    )
    max_missing_seconds: float = setting(
        0.4, "An utterance is rejected if no face is found for longer than this, in seconds.", minimum=0, maximum=3600
    )


class Tracker(Protocol):
    """Follows one face through the frames of one recording; one tracker is made per recording."""

    def next(self, frame: np.ndarray) -> np.ndarray | None:
        """Points (68, 2) in pixels of the next frame, (height, width, 3) uint8 RGB; None if no face is found."""

    def faces(self) -> int:
        """The largest number of faces detected in one frame so far."""
