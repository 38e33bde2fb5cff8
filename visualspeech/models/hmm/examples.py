"""Training utterances of HMMs: phones with their times, and appearance, read from files as needed."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from visualspeech.features.examples import Examples
from visualspeech.models.hmm.segments import Example, PhoneTrack, phone_track
from visualspeech.speech.alignment import read_alignments
from visualspeech.storage import ArrayCollection


class TimedExamples(Sequence):
    """A sequence of (phone track, appearance (T, N), rate in Hz), one item per utterance.

    Parameters
    ----------
    features : open feature files
    ids : utterances, in the order of the sequence
    tracks : phones by utterance, see :func:`read_tracks`
    """

    def __init__(self, features: ArrayCollection, ids: Sequence[str], tracks: Mapping[str, PhoneTrack]) -> None:
        self._streams = Examples(features, ids)
        self._tracks = [tracks[name] for name in ids]
        self._rates = [features.rate(name) for name in ids]

    def __len__(self) -> int:
        return len(self._tracks)

    def __getitem__(self, number: int) -> Example:
        return self._tracks[number], self._streams[number][1], self._rates[number]


def read_tracks(
    paths: Iterable[str | Path], phones: Sequence[str], before: int = 1, after: int = 1
) -> dict[str, PhoneTrack]:
    """The phones of every utterance in alignment files, see :func:`visualspeech.models.hmm.segments.phone_track`.

    Raises
    ------
    DataError
        A phone is not in the inventory.
    """
    return {
        name: phone_track(alignment, phones, before, after)
        for path in paths
        for name, alignment in read_alignments(path).items()
    }
