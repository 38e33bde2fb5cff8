"""The utterances a model learns from: pairs of label indices and appearance, read from the feature files as needed."""

from collections.abc import Sequence

import numpy as np

from visualspeech.errors import DataError
from visualspeech.storage import ArrayCollection


def labels_of(name: str, features: ArrayCollection, parts: ArrayCollection | None = None) -> np.ndarray:
    """Labels of an utterance: (T, 4) int16, with its label parts (T, 4 + P) where their files are given.

    Raises
    ------
    DataError
        Labels and label parts are of different length.
    """
    labels = features.array(name, "labels")
    if parts is None:
        return labels
    further = parts.array(name, "parts")
    if len(further) != len(labels):
        raise DataError(
            f"utterance {name} has {len(labels)} label frames and {len(further)} frames of label parts; "
            "delete its label parts and run again."
        )
    return np.column_stack([labels, further])


class Examples(Sequence):
    """A sequence of (labels (T, 4) int16, appearance (T, N) float32), one pair an utterance.

    Utterances are kept in memory up to a bound and read from their file again beyond it, so that memory does not grow
    with the corpus.

    Parameters
    ----------
    features : the feature files, opened
    ids : the utterances, in the order of the sequence
    cache_bytes : how much is kept in memory
    parts : files with the label parts (T, P), opened, where labels are to have them as further columns
    """

    def __init__(
        self,
        features: ArrayCollection,
        ids: Sequence[str],
        cache_bytes: float = 256e6,
        parts: ArrayCollection | None = None,
    ) -> None:
        self._features = features
        self._parts = parts
        self.ids = tuple(ids)
        self._free = cache_bytes
        self._kept: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """One utterance.

        Raises
        ------
        DataError
            Labels and appearance are of different length.
        """
        if number in self._kept:
            return self._kept[number]
        name = self.ids[number]
        labels = labels_of(name, self._features, self._parts)
        appearance = self._features.array(name, "appearance")
        if len(labels) != len(appearance):
            raise DataError(
                f"utterance {name} has {len(labels)} label frames and {len(appearance)} appearance frames; "
                "delete its features and run again."
            )
        size = labels.nbytes + appearance.nbytes
        if size <= self._free:
            self._free -= size
            self._kept[number] = (labels, appearance)
        return labels, appearance
