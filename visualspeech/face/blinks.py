"""Blinks, by the opening of the eyes in the landmarks.

The opening is the eye aspect ratio, height over width of an eye, as the mean of both eyes (Soukupova & Cech, "Real-time
eye blink detection using facial landmarks", CVWW 2016, Eq. 1). It depends on the person and the camera, so that it is
compared with its median over the recording.
"""

import numpy as np

#: Share of the median opening below which the eyes count as closed.
CLOSED = 0.7
#: Two blinks are a double blink if the eyes are open for less than this between them, in seconds.
DOUBLE = 0.5


def eye_opening(landmarks: np.ndarray) -> np.ndarray:
    """Eye aspect ratio (T,) of landmarks (T, 68, 2), of both eyes together."""
    points = np.asarray(landmarks, np.float64)

    def apart(a: int, b: int) -> np.ndarray:
        return np.linalg.norm(points[:, a] - points[:, b], axis=1)

    heights = apart(37, 41) + apart(38, 40) + apart(43, 47) + apart(44, 46)
    return heights / (2 * (apart(36, 39) + apart(42, 45)))


def eyes_closed(landmarks: np.ndarray, share: float = CLOSED) -> np.ndarray:
    """Whether the eyes are closed in each frame of landmarks (T, 68, 2), (T,) bool.

    Parameters
    ----------
    share : of the median opening, below which they are
    """
    opening = eye_opening(landmarks)
    return opening < share * np.median(opening)


def blinks(closed: np.ndarray) -> np.ndarray:
    """First frame, and frame after the last, of each run of closed eyes, (n, 2) int, of ``closed`` (T,) bool."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], np.asarray(closed, int), [0]])))
    return edges.reshape(-1, 2)


def double_blinks(landmarks: np.ndarray, rate: float) -> int:
    """Number of blinks that follow another one within :data:`DOUBLE` seconds.

    Parameters
    ----------
    landmarks : (T, 68, 2) of one recording
    rate : frame rate in Hz
    """
    found = blinks(eyes_closed(landmarks))
    return int(((found[1:, 0] - found[:-1, 1]) / rate < DOUBLE).sum())
