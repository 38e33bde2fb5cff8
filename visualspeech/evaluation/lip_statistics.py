"""Predicted lips against the tracked ones at the camera's frames: statistics in which all systems are comparable.

The truth is what was tracked (landmarks of the normalised face, or motion capture), not what a visual coding makes of
it, at the frames in which it was recorded. A prediction is decoded to points by its coding and read at the times of
these frames. Prediction and truth are each taken less their mean over the utterance, points as well as openings and
widths. Lengths are in units of the speaker's own head.

As in :mod:`visualspeech.evaluation.metrics`, statistics of utterances are sums from which the figures of a corpus
follow; :mod:`visualspeech.evaluation.lip_metrics` defines these.
"""

import numpy as np

from visualspeech.errors import DataError
from visualspeech.evaluation.articulation import cross_correlation
from visualspeech.evaluation.metrics import quotient
from visualspeech.evaluation.scoring import centred, frame_point_distance
from visualspeech.evaluation.tracked import BILABIAL, TrackedSpeaker
from visualspeech.face.mouth import Mouth
from visualspeech.features.resampling import at_times
from visualspeech.speech.alignment import Alignment, silent_frames
from visualspeech.speech.closures import least_openings
from visualspeech.timing import frame_times

#: Rates of closure -> statistics of the recorded faces that they are computed from.
RECORDED = {"closure": ("recorded_closed", "closures"), "silence": ("recorded_silent_closed", "silent_frames")}
CONSTANT = 1e-9  # of the mean square: less variance than this is rounding


def at_frames(points: np.ndarray, rate: float, frames: int, camera_rate: float) -> np.ndarray:
    """Points (T, P, d) at ``rate`` Hz as they are in the middle of each frame of the camera, (frames, P, d).

    Linear between the points' own frames; constant before the first and after the last.
    """
    flat = np.asarray(points, np.float64).reshape(len(points), -1)
    return at_times(flat, rate, frame_times(frames, camera_rate)).reshape(frames, *points.shape[1:])


def lip_statistics(
    predicted: np.ndarray,
    true: np.ndarray,
    mouths: tuple[Mouth, Mouth],
    alignment: Alignment,
    rate: float,
    speaker: TrackedSpeaker,
) -> dict[str, float]:
    """Statistics of one utterance: the columns that the measures of :data:`ACROSS` need, so far as the faces give them.

    Parameters
    ----------
    predicted, true : points (T, P, d) and (T, Q, d) at the camera's frames
    mouths : the lips among the predicted points, and among the true ones
    rate : of the camera in Hz

    Raises
    ------
    DataError
        The lengths or the lips differ, there are no frames, or a value is not finite.
    """
    pairs = tuple(zip((predicted, true), mouths, strict=True))
    lips = [centred(np.asarray(points)[:, list(mouth.lips)]) for points, mouth in pairs]
    if len(predicted) != len(true) or not len(true) or np.shape(predicted)[2] != np.shape(true)[2]:
        raise DataError(f"the predicted points are of shape {np.shape(predicted)}, the recorded ones {np.shape(true)}.")
    for name, values in zip(("predicted", "recorded"), lips, strict=True):
        if not np.isfinite(values).all():
            frame = int(np.argwhere(~np.isfinite(values))[0][0])
            raise DataError(f"the {name} lips of frame {frame} are not finite numbers.")
    frames, (predicted_lips, true_lips) = len(true), lips
    found = {"frames": frames, "utterances": 1}
    if all(mouth.lips for mouth in mouths):
        jerks = [float(np.sum(np.diff(values, n=3, axis=0) ** 2)) / speaker.unit**2 for values in lips]
        distance = float(frame_point_distance(predicted_lips, true_lips).mean())
        found["lip_distance_sum"] = frames * 100 * distance / speaker.eye_distance
        found |= {f"jerk.{number}": jerk for number, jerk in enumerate(jerks)}
    if all(mouth.corners for mouth in mouths):
        found |= _moments("width", [mouth.width(points) / speaker.unit for points, mouth in pairs])
    if all(mouth.upper and mouth.lower for mouth in mouths):
        opening = [mouth.opening(points) / speaker.unit for points, mouth in pairs]
        lags = enumerate(cross_correlation(*opening, rate))
        found |= _moments("opening", opening) | {f"lag.{number}": float(value) for number, value in lags}
        found |= _closures(opening, alignment, rate, speaker)
    return found


def _moving(values: np.ndarray) -> np.ndarray:
    """A stream (T,) less its mean; exactly 0 where it changes by no more than rounding."""
    moved = centred(values)
    return moved if np.sum(moved**2) > CONSTANT * np.sum(np.square(values, dtype=np.float64)) else np.zeros(len(moved))


def _moments(name: str, pair) -> dict[str, float]:
    """Sums over frames of 1, x, y, x^2, y^2 and x y of two streams less their means."""
    x, y = map(_moving, pair)
    sums = (np.ones(len(x)), x, y, x * x, y * y, x * y)
    return {f"{name}.{number}": float(values.sum()) for number, values in enumerate(sums)}


def _closures(pair, alignment: Alignment, rate: float, speaker: TrackedSpeaker) -> dict[str, float]:
    """Counts of closed lips in occurrences of p, b, m and in the frames of silence."""
    found: dict[str, float] = {}
    silent, known = silent_frames(alignment, len(pair[0]), rate), speaker.occurrences > 0
    closed = speaker.closed / speaker.unit
    for prefix, opening in zip(("", "recorded_"), map(centred, pair), strict=True):
        least = least_openings(opening, alignment, rate, BILABIAL)
        found[f"{prefix}closed"] = float(np.count_nonzero(least <= closed))
        found[f"{prefix}silent_closed"] = float(np.count_nonzero(opening[silent] <= closed))
        found["closures"] = float(len(least)) if known else 0.0
    return found | {"silent_frames": float(silent.sum()) if known else 0.0}


def recorded_closures(table) -> dict[str, float]:
    """Both rates of closure of the recorded faces of a table's utterances, by measure; NaN without occurrences."""
    if "closures" not in table:
        return {}
    sums = {name: np.array([table[column].sum() for column in columns], float) for name, columns in RECORDED.items()}
    return {name: float(quotient(pair)) for name, pair in sums.items()}
