"""Which tracked frames the speaker's head is fitted to."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from visualspeech.errors import CorpusError, RejectedUtterance


def picture_size(landmarks, ids: Sequence[str]) -> tuple[int, int]:
    """The (width, height) in pixels that most of the utterances have.

    Raises
    ------
    CorpusError
        There are no utterances.
    """
    sizes = Counter(_size(landmarks, one) for one in ids)
    if not sizes:
        raise CorpusError("no training utterance has a tracked face. See the findings of the check and the landmarks.")
    return max(sizes, key=lambda size: (sizes[size], size))


def other_sizes(landmarks, ids: Sequence[str]) -> dict[str, RejectedUtterance]:
    """A rejection for each utterance whose pictures are not of the usual size: one camera is assumed for a speaker."""
    usual = picture_size(landmarks, ids)
    return {
        one: RejectedUtterance(
            "its pictures are {}x{} pixels, those of most utterances {}x{}".format(*_size(landmarks, one), *usual),
            "Convert it to the common size, or make it a corpus of its own.",
        )
        for one in ids
        if _size(landmarks, one) != usual
    }


def sample_points(landmarks, ids: Sequence[str], frames: int) -> tuple[np.ndarray, tuple[int, int]]:
    """Landmarks of frames spread evenly over utterances, and the size of the pictures they are seen in.

    Parameters
    ----------
    landmarks : opened landmark files
    ids : the training utterances
    frames : most frames in all; memory does not grow with the corpus

    Returns
    -------
    (n, 68, 2) image pixels, and (width, height)
    """
    size = picture_size(landmarks, ids)
    fitting = [one for one in sorted(ids) if _size(landmarks, one) == size]
    # Where there are more utterances than frames, some of them, evenly; else so many of each.
    chosen = [fitting[place] for place in np.unique(np.linspace(0, len(fitting) - 1, frames).round().astype(int))]
    each = max(1, frames // len(chosen))
    return np.concatenate([_spread(landmarks, one, each) for one in chosen])[:frames], size


def _spread(landmarks, one: str, count: int) -> np.ndarray:
    seen = np.flatnonzero(landmarks.array(one, "detected"))
    seen = seen[np.unique(np.linspace(0, len(seen) - 1, count).round().astype(int))] if len(seen) else seen
    return landmarks.array(one, "points")[seen]


def _size(landmarks, one: str) -> tuple[int, int]:
    attributes = landmarks.reader(one).attributes(one)
    return int(attributes["width"]), int(attributes["height"])
