"""What a model reads of an utterance: streams of class indices or of values, at frames or at segments."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.errors import DataError


@dataclass(frozen=True)
class Layout:
    """The columns of a block's streams, and how a model reads them.

    Parameters
    ----------
    sizes : number of classes of each categorical column; a model sees them as one-hot vectors side by side
    dimension : number D of real-valued columns
    segmental : a row is a segment with a start time, not a frame
    window : frames before and after each frame that a model reads beside it; zero outside the utterance
    """

    sizes: tuple[int, ...] = ()
    dimension: int = 0
    segmental: bool = False
    window: int = 0

    @property
    def width(self) -> int:
        """Number of inputs of a model that sees classes as one-hot vectors."""
        return self.frames * (sum(self.sizes) + self.dimension)

    @property
    def frames(self) -> int:
        """Number of frames that a model reads at once."""
        return 2 * self.window + 1


@dataclass(frozen=True)
class Stream:
    """One utterance of a block: categorical, dense or both; T rows are frames, or segments that have starts.

    Parameters
    ----------
    index : (T, C) int, class of each categorical column; None where there is none
    values : (T, D) float32; None where there is none
    starts : (T,) seconds, ascending, of segments; None where rows are frames
    """

    index: np.ndarray | None = None
    values: np.ndarray | None = None
    starts: np.ndarray | None = None

    def __len__(self) -> int:
        return len(next(one for one in (self.index, self.values) if one is not None))

    def arrays(self) -> dict[str, np.ndarray]:
        """The arrays by name, as they are stored."""
        return {name: values for name, values in vars(self).items() if values is not None}


def check_stream(stream: Stream, layout: Layout, name: str) -> None:
    """Check that a stream has the columns of a layout, classes in range, finite values, and at least one row.

    Raises
    ------
    DataError
        It has not; the message names the block ``name``.
    """
    columns = (
        stream.index.shape[1] if stream.index is not None else 0,
        stream.values.shape[1] if stream.values is not None else 0,
    )
    wanted = (len(layout.sizes), layout.dimension)
    if (stream.starts is not None) != layout.segmental:
        found, read = ("frames", "segments") if layout.segmental else ("segments", "frames")
        raise DataError(
            f"input block `{name}`: the rows of a stream are {found}, the model reads {read}. Delete its features and "
            "run again."
        )
    if columns != wanted:
        raise DataError(
            f"input block `{name}`: a stream has {columns[0]} categorical and {columns[1]} real-valued columns, the "
            f"model reads {wanted[0]} and {wanted[1]}. Delete its features and run again."
        )
    lengths = {key: len(values) for key, values in stream.arrays().items()}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{key} {length}" for key, length in lengths.items())
        raise DataError(
            f"input block `{name}`: the arrays of a stream differ in length ({found}). Delete its features and run "
            "again."
        )
    if not len(stream):
        raise DataError(f"input block `{name}`: a stream has no frame; the utterance is empty.")
    if layout.sizes and (stream.index.min() < 0 or (stream.index.max(axis=0) >= np.array(layout.sizes)).any()):
        raise DataError(
            f"input block `{name}`: a class is outside its inventory ({', '.join(map(str, layout.sizes))} classes); "
            "the features were made for another model. Delete them and run again."
        )
    if layout.dimension and not np.isfinite(stream.values).all():
        raise DataError(f"input block `{name}`: a value is not a finite number. Delete its features and run again.")


def joined(streams: Sequence[Stream]) -> tuple[np.ndarray, np.ndarray]:
    """The columns of several streams side by side: classes (T, C) int64 and values (T, D) float32."""
    frames = len(streams[0])
    index = [stream.index for stream in streams if stream.index is not None]
    values = [stream.values for stream in streams if stream.values is not None]
    return (
        np.concatenate(index, axis=1).astype(np.int64) if index else np.zeros((frames, 0), np.int64),
        np.concatenate(values, axis=1).astype(np.float32) if values else np.zeros((frames, 0), np.float32),
    )
