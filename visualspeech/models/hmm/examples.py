"""The utterances that HMMs learn from: phones with their times, and appearance, read from files as needed."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from visualspeech.features.examples import Examples
from visualspeech.models.hmm.segments import PhoneTrack, phone_track
from visualspeech.speech.rows import read_alignment_rows
from visualspeech.storage import ArrayCollection


class TimedExamples(Sequence):
    """A sequence of (phone track, appearance (T, N), rate in Hz), one an utterance.

    Parameters
    ----------
    features : the feature files, opened
    ids : the utterances, in the order of the sequence
    tracks : their phones, from :func:`read_tracks`
    """

    def __init__(self, features: ArrayCollection, ids: Sequence[str], tracks: Mapping[str, PhoneTrack]) -> None:
        self._streams = Examples(features, ids)
        self._tracks = [tracks[name] for name in ids]
        self._rates = [features.rate(name) for name in ids]

    def __len__(self) -> int:
        return len(self._tracks)

    def __getitem__(self, number: int) -> tuple[PhoneTrack, np.ndarray, float]:
        return self._tracks[number], self._streams[number][1], self._rates[number]


def read_tracks(paths: Iterable[str | Path], phones: Sequence[str]) -> dict[str, PhoneTrack]:
    """The phones of all utterances of alignment files, in time.

    Raises
    ------
    DataError
        A phone is not in the inventory.
    """
    return {name: phone_track(rows, phones) for path in paths for name, rows in read_alignment_rows(path).items()}
