"""The interface of landmark trackers, their points and their settings."""

import re
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from visualspeech.fields import Settings, setting, setting_error

POINTS = 68
# Landmarks that move with the skull only: bridge and base of the nose, corners of the eyes.
RIGID = np.array([27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 39, 42, 45])

#: Name in the settings -> ``module:Class`` of a tracker of this package. They are imported by name at run time, so that
#: a change of one re-runs the jobs that track with it, and no others.
TRACKERS: dict[str, str] = {"dlib": "visualspeech.face.dlib_tracker:DlibTracker"}
#: The reader of landmarks that another program has written takes the place of a tracker.
CSV_READER = "visualspeech.face.landmark_csv:CsvLandmarks"
SOURCES = ("tracker", "csv")
_CLASS = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*", re.ASCII)


@dataclass(frozen=True)
class LandmarkSettings(Settings):
    """Detection and tracking of the speaker's face."""

    section = "landmarks"
    source: str = setting(
        "tracker",
        "Where landmarks come from: `tracker`, which finds them in the frames, or `csv`, files that another program "
        "has written.",
        choices=SOURCES,
    )
    folder: str = setting(
        "",
        "Source `csv`: folder of the CSV files (columns of OpenFace), one for each recording and of the same name; "
        "relative to the working folder.",
        max_length=1000,
        pattern=r"[^\r\n]*",
    )
    min_confidence: float = setting(
        0.5,
        "Source `csv`: frames with a lower `confidence` than this count as frames without a face.",
        minimum=0,
        maximum=1,
    )
    tracker: str = setting(
        "dlib",
        "Source `tracker`: `dlib`, or a class of your own as `module:Class`; its code is run.",
        max_length=200,
        pattern=r"[A-Za-z_][A-Za-z0-9_.]*(:[A-Za-z_][A-Za-z0-9_]*)?",
    )
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

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tracker not in TRACKERS and not _CLASS.fullmatch(self.tracker):
            known = " or ".join(f"`{name}`" for name in TRACKERS)
            raise setting_error(type(self), "tracker", self.tracker, f"{known}, or a class of your own, module:Class")
        if self.source == "csv" and not self.folder:
            raise setting_error(type(self), "folder", "", "the folder of the CSV files, since `source` is csv")
        if self.source != "csv" and self.folder:
            raise setting_error(type(self), "folder", self.folder, "left out, unless `source` is csv")


@dataclass(frozen=True)
class TrackedVideo:
    """What a tracker is told of the video that it will see.

    Parameters
    ----------
    path : of the recording; empty where frames do not come from a file
    rate : frame rate in Hz
    first : number of the first frame in the recording, counted from 0; above 0 where the utterance is a segment of it
    """

    path: str
    rate: float
    first: int = 0


class Tracker(Protocol):
    """Follows one face through the frames of one utterance; one tracker is made per utterance.

    A class of one's own has a constructor with the same two parameters, and the method ``next``; ``faces`` and
    ``warnings`` may be left out.
    """

    def __init__(self, settings: LandmarkSettings, video: TrackedVideo) -> None: ...

    def next(self, frame: np.ndarray, number: int) -> np.ndarray | None:
        """Points (68, 2) in pixels of the next frame; None if no face is found.

        Parameters
        ----------
        frame : (height, width, 3) uint8 RGB
        number : of the frame in the recording, counted from 0; its time is (number + 0.5) / rate
        """

    def faces(self) -> int:
        """The largest number of faces detected in one frame so far."""

    def warnings(self) -> list[str]:
        """What does not prevent the use of the utterance, one sentence each; asked for after the last frame."""
