"""The interface of landmark trackers, their points and their settings."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

POINTS = 68
# Landmarks that move with the skull only: bridge and base of the nose, corners of the eyes.
RIGID = np.array([27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 39, 42, 45])


@dataclass(frozen=True)
class LandmarkSettings:
    """How faces are found and followed.

    Parameters
    ----------
    tracker : name in :data:`visualspeech.face.landmarks.TRACKERS`
    face_pixels : side in pixels to which the face box is brought before points are predicted; points come in whole
        pixels of this picture, so a larger side means finer points, and slower (400 is 3.4x upsampling on GRID)
    predictions : predictions a frame, each on a slightly different crop, averaged
    detector_pixels : longest side in pixels of the picture in which a face is searched for
    search_every : frames between two searches of the whole frame
    likeness : correlation with the last confirmed face below which the detector is asked again (0..1)
    smoothing : standard deviation in frames of the Gaussian that smooths the points in time; 0 for none
    missing_share : share of frames without a face beyond which an utterance is rejected
    missing_run : seconds without a face beyond which an utterance is rejected
    """

    tracker: str = "dlib"
    face_pixels: int = 400
    predictions: int = 1
    detector_pixels: int = 640
    search_every: int = 25
    likeness: float = 0.8
    smoothing: float = 0.4
    missing_share: float = 0.2
    missing_run: float = 0.4


class Tracker(Protocol):
    """Follows one face through the frames of one recording; one tracker is made per recording."""

    def next(self, frame: np.ndarray) -> np.ndarray | None:
        """The points (68, 2) in pixels of the next frame, (height, width, 3) uint8 RGB; None where there is no face."""

    def faces(self) -> int:
        """The largest number of faces that a frame has held so far."""
