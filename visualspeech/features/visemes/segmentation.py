"""Visual speech cut into gestures where its acceleration changes sign (Thangthai 2016, section 3; Taylor et al. 2012).

Visual parameters have many dimensions, and so has their acceleration. The one that counts here is the acceleration
along the direction of motion, which is the derivative of the speed |v|. Where it turns from negative to positive, the
articulators have slowed down and set out again: they change direction, or pause between two movements. Each such
minimum of the speed ends a gesture. The other changes of sign, the maxima of the speed, lie in the middle of a movement
and end none.

The speed is that of the parameters as the visual coding scales them. Parameters of an AAM are projections onto
orthonormal modes, so that each counts by the energy that it has in the face: without weights, the speed is that of the
face itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.resampling import at_times


@dataclass(frozen=True)
class Gestures:
    """The gestures of an utterance of T frames, which follow each other without gaps.

    Parameters
    ----------
    starts : (G,) first frame of each, ascending from 0
    frames : T
    """

    starts: np.ndarray
    frames: int

    @property
    def lengths(self) -> np.ndarray:
        """Frames of each gesture, (G,)."""
        return np.diff(np.append(self.starts, self.frames))

    def of_frames(self) -> np.ndarray:
        """Number of the gesture that each frame belongs to, (T,)."""
        return np.repeat(np.arange(len(self.starts)), self.lengths)


def speed(values: np.ndarray, rate: float, smoothing: float) -> np.ndarray:
    """Speed (T,) of visual parameters, in their unit per second, of the values after smoothing.

    Parameters
    ----------
    values : (T, N) at ``rate`` Hz; before the first and after the last frame they are taken as constant
    smoothing : standard deviation in seconds of the Gaussian window
    """
    from scipy.ndimage import gaussian_filter1d

    slope = gaussian_filter1d(np.asarray(values, np.float64), smoothing * rate, axis=0, order=1, mode="nearest")
    return np.sqrt(np.square(slope).sum(axis=1)) * rate


def gestures_of(values: np.ndarray, rate: float, smoothing: float, min_length: float) -> Gestures:
    """The gestures of an utterance: from one minimum of its speed to the next.

    Of minima that lie closer together than a gesture may be short, the deeper ones count. An utterance that is shorter
    than two gestures can be is one gesture.

    Parameters
    ----------
    values : (T, N) visual parameters at ``rate`` Hz
    smoothing : seconds, see :func:`speed`
    min_length : least length of a gesture in seconds

    Raises
    ------
    DataError
        There is no frame, or a value is not a finite number.
    """
    from scipy.signal import find_peaks

    values = np.asarray(values)
    if values.ndim != 2 or not len(values) or not np.isfinite(values).all():
        raise DataError(
            f"visual parameters of shape {values.shape} cannot be cut into gestures: they must be finite numbers, of "
            "one frame at least. Delete the targets of the system and run again."
        )
    least = max(1, int(np.ceil(min_length * rate - 1e-6)))
    found = find_peaks(-speed(values, rate, smoothing), distance=least)[0]
    inner = found[(found >= least) & (found <= len(values) - least)]
    return Gestures(np.concatenate([[0], inner]).astype(np.int64), len(values))


def resampled(values: np.ndarray, gestures: Gestures, points: int) -> np.ndarray:
    """Each gesture at ``points`` times spread evenly over it: (G, points, N) float32.

    Parameters
    ----------
    values : (T, N) of the utterance
    """
    at = (np.arange(points) + 0.5) / points
    parts = np.split(np.asarray(values, np.float64), gestures.starts[1:])
    # With its own number of frames as rate, a gesture lasts one second.
    return np.array([at_times(part, len(part), at) for part in parts], np.float32)


def stretched(shapes: np.ndarray, lengths: Sequence[int]) -> np.ndarray:
    """Shapes (G, points, N) brought to the lengths of gestures and put behind each other: (sum of lengths, N) float32.

    Parameters
    ----------
    lengths : (G,) frames
    """
    points = shapes.shape[1]
    parts = [
        at_times(shape.astype(np.float64), points, (np.arange(length) + 0.5) / length)
        for shape, length in zip(shapes, lengths, strict=True)
    ]
    return np.concatenate(parts).astype(np.float32)
