"""Sampling of the tracked frames to which a speaker's head is fitted, and screening of frame sizes."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from visualspeech.errors import CorpusError, RejectedUtterance
from visualspeech.face.head import HeadModel, PoseSettings, fit_head


def frame_size(landmarks, ids: Sequence[str]) -> tuple[int, int]:
    """The most common frame size of the utterances, (width, height) in pixels.

    Raises
    ------
    CorpusError
        There are no utterances.
    """
    sizes = Counter(_size(landmarks, one) for one in ids)
    if not sizes:
        raise CorpusError("no training utterance has a tracked face. See the findings of the check and the landmarks.")
    return max(sizes, key=lambda size: (sizes[size], size))


def screen_frame_sizes(landmarks, ids: Sequence[str], training: Sequence[str]) -> dict[str, RejectedUtterance]:
    """Rejections of a speaker's utterances of another than the most common frame size, as one camera is assumed.

    Parameters
    ----------
    landmarks : opened landmark files
    ids : the speaker's utterances
    training : those of them that the size is taken from

    Raises
    ------
    CorpusError
        There are no training utterances.
    """
    usual = frame_size(landmarks, training)
    return {
        one: RejectedUtterance(
            "its frames are {}x{} pixels, those of most utterances {}x{}".format(*_size(landmarks, one), *usual),
            "Convert it to the common size, or list it under another speaker.",
        )
        for one in ids
        if _size(landmarks, one) != usual
    }


def fit_speaker_head(speaker: str, landmarks, ids: Sequence[str], settings: PoseSettings | None = None) -> HeadModel:
    """Fit the head of one speaker to frames spread evenly over training utterances.

    Parameters
    ----------
    speaker : for messages
    landmarks : opened landmark files that hold these utterances
    ids : the speaker's training utterances

    Raises
    ------
    CorpusError
        There are no utterances.
    DataError
        As :func:`visualspeech.face.head.fit_head`.
    """
    if not ids:
        raise CorpusError(
            f"no training utterance of the speaker {speaker!r} has a tracked face. See the findings of the check and "
            "of the landmarks; leave this speaker out, or record the speaker again."
        )
    settings = settings or PoseSettings()
    points, size = sample_landmarks(landmarks, ids, settings.max_frames)
    return fit_head(points, size, settings)


def sample_landmarks(landmarks, ids: Sequence[str], frames: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Landmarks of frames spread evenly over the utterances of the most common frame size, and that size.

    Parameters
    ----------
    landmarks : opened landmark files
    ids : the training utterances
    frames : maximum number of frames, which bounds the memory

    Returns
    -------
    (n, 68, 2) image pixels, and (width, height)

    Raises
    ------
    CorpusError
        There are no utterances.
    """
    size = frame_size(landmarks, ids)
    fitting = [one for one in sorted(ids) if _size(landmarks, one) == size]
    # If there are more utterances than frames, some utterances are used, else equally many frames of each.
    chosen = [fitting[number] for number in np.unique(np.linspace(0, len(fitting) - 1, frames).round().astype(int))]
    each = max(1, frames // len(chosen))
    return np.concatenate([_spread(landmarks, one, each) for one in chosen])[:frames], size


def _spread(landmarks, one: str, count: int) -> np.ndarray:
    seen = np.flatnonzero(landmarks.array(one, "detected"))
    seen = seen[np.unique(np.linspace(0, len(seen) - 1, count).round().astype(int))] if len(seen) else seen
    return landmarks.array(one, "points")[seen]


def _size(landmarks, one: str) -> tuple[int, int]:
    attributes = landmarks.reader(one).attributes(one)
    return int(attributes["width"]), int(attributes["height"])
