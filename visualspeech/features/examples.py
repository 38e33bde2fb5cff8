"""The utterances that a model learns from: input streams and targets, read from their files as needed."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import NamedTuple

import numpy as np

from visualspeech.errors import DataError
from visualspeech.features.streams import Stream
from visualspeech.storage.arrays import ArrayCollection


class Example(NamedTuple):
    """One utterance: a stream of each input block that the model reads, the target (T, N) float32, its rate in Hz."""

    streams: tuple[Stream, ...]
    target: np.ndarray
    rate: float


class Examples(Sequence):
    """A sequence of :class:`Example`, one an utterance.

    Utterances are kept in memory up to a bound and read from their file again beyond it, so that memory does not grow
    with the corpus.

    Parameters
    ----------
    blocks : of each input block the feature files, opened
    targets : the files of the targets, opened
    ids : the utterances, in the order of the sequence
    cache_bytes : how much is kept in memory
    """

    def __init__(
        self,
        blocks: Sequence[ArrayCollection],
        targets: ArrayCollection,
        ids: Sequence[str],
        cache_bytes: float = 256e6,
    ) -> None:
        self._blocks = tuple(blocks)
        self._targets = targets
        self.ids = tuple(ids)
        self._free = cache_bytes
        self._kept: dict[int, Example] = {}

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, number: int) -> Example:
        """One utterance.

        Raises
        ------
        DataError
            Streams and target differ in length.
        """
        if number in self._kept:
            return self._kept[number]
        name = self.ids[number]
        target = self._targets.array(name, "appearance")
        example = Example(streams_of(name, self._blocks, len(target)), target, self._targets.rate(name))
        arrays = [array for stream in example.streams for array in stream.arrays().values()]
        size = sum(array.nbytes for array in (*arrays, target))
        if size <= self._free:
            self._free -= size
            self._kept[number] = example
        return example


def streams_of(name: str, blocks: Sequence[ArrayCollection], frames: int) -> tuple[Stream, ...]:
    """The streams of an utterance, one a block, checked against its number of frames.

    Raises
    ------
    DataError
        A stream of frames has another length.
    """
    streams = tuple(Stream(**block[name]) for block in blocks)
    for stream in streams:
        if stream.starts is None and len(stream) != frames:
            raise DataError(
                f"utterance {name} has {len(stream)} frames of features and {frames} frames of targets; delete its "
                "features and targets and run again."
            )
    return streams


@contextmanager
def opened_blocks(paths: Sequence[str], count: int) -> Iterator[tuple[ArrayCollection, ...]]:
    """The feature files of ``count`` input blocks, opened.

    Parameters
    ----------
    paths : of all shards of the first block, then of the second, and so on
    """
    shards = len(paths) // count if count else 0
    with ExitStack() as stack:
        yield tuple(
            stack.enter_context(ArrayCollection(paths[number * shards : (number + 1) * shards]))
            for number in range(count)
        )
