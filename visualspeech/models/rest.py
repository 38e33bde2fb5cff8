"""The face at rest: what a speaker's face looks like in silence, as parameters of the visual coding, and when it is."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np

from visualspeech.errors import DataError
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phones import SILENCE
from visualspeech.timing import frame_times

REST = 0.12  # seconds from the border of a pause until the face is fully at rest, as measured on speaker s1 of GRID
_SHORT_SILENCE = {"after": 0.12, "before": 0.12}  # seconds to speech in recordings without a long silence


def resting_frames(
    alignment: Alignment, frames: int, rate: float, after: float = 0.25, before: float = 0.5
) -> np.ndarray:
    """Frames of one utterance in which the face is at rest, (frames,) bool: silence away from speech.

    The mouth closes soon after speech, but opens long before it, to draw breath.

    Parameters
    ----------
    frames, rate : number of frames and frame rate (Hz) of the visual stream
    after, before : minimum time in seconds after speech and before speech
    """
    times, resting = frame_times(frames, rate), np.ones(frames, bool)
    for phone in alignment.phones:
        if phone.label != SILENCE:
            resting &= (times < phone.start - before) | (times > phone.end + after)
    return resting


def pause_weights(alignment: Alignment, frames: int, rate: float, ramp: float) -> np.ndarray:
    """Weight of the face at rest, (frames,): 0 in speech, rising to 1 within ``ramp`` seconds from a pause's border.

    Before the start and after the end there is silence, so the first and last pause have only one border.
    """
    times = frame_times(frames, rate)
    depth = np.zeros(frames)
    first, last = min(0.0, alignment.phones[0].start), alignment.phones[-1].end
    for one in alignment.phones:
        if one.label == SILENCE:
            since = np.inf if one.start <= first else times - one.start
            until = np.inf if one.end >= last else one.end - times
            inside = (times >= one.start) & ((times < one.end) | (one.end >= last))
            depth = np.where(inside, np.minimum(since, until) * np.ones(frames), depth)
    share = np.clip(depth / ramp, 0, 1)
    return share * share * (3 - 2 * share)


def resting_face(utterances: Callable[[], Iterable[tuple]]) -> np.ndarray:
    """The face at rest, (N,) float32: mean over long silences, or over short ones where no utterance has a long one.

    Parameters
    ----------
    utterances : returns, each time it is called, an iterable of (:class:`Alignment`, appearance (frames, N), rate in
        Hz), one item per utterance, so that they need not be in memory together

    Raises
    ------
    DataError
        No utterance has silence.
    """

    def silences(**away) -> Iterator[np.ndarray]:
        return (values[resting_frames(spoken, len(values), rate, **away)] for spoken, values, rate in utterances())

    # Recordings that are cut close to the speech have no long silence.
    return rest_of(silences() if any(map(len, silences())) else silences(**_SHORT_SILENCE))


def rest_of(silences: Iterable[np.ndarray]) -> np.ndarray:
    """The face at rest, (N,) float32: the mean over all frames of silence.

    Parameters
    ----------
    silences : appearance (frames, N) of these frames, one array per utterance

    Raises
    ------
    DataError
        There are no such frames.
    """
    total, count = 0.0, 0
    for appearance in silences:
        total, count = total + np.asarray(appearance, np.float64).sum(axis=0), count + len(appearance)
    if not count:
        raise DataError(
            "the training utterances have no silence that shows the face at rest; record with half a second of silence "
            "before and after each sentence."
        )
    return (total / count).astype(np.float32)
