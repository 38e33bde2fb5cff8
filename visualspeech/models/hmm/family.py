"""Phone HMMs as a family of models: they read the phones of an utterance with their times; one row starts another."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile, DataError
from visualspeech.features.blocks.base import Block
from visualspeech.features.examples import Example
from visualspeech.features.streams import Stream
from visualspeech.models.block_states import BLOCK_ARRAYS, BLOCKS, pack, unpack
from visualspeech.models.hmm.mge import refine
from visualspeech.models.hmm.model import ARRAYS, PLAIN, Hmm, HmmSettings
from visualspeech.models.hmm.segments import Factor, PhoneTrack
from visualspeech.models.hmm.training import fit_monophones, fit_tied
from visualspeech.models.task import Fitted, Task, check_examples, check_streams
from visualspeech.storage.layouts import RATE, TEXT, FileLayout
from visualspeech.storage.models import check_model, read_model, write_model

FAMILY = "hmm"


@dataclass(frozen=True)
class HmmModel:
    """HMMs with the input block that they read.

    Parameters
    ----------
    hmm : monophone, tied-state or MGE-trained
    blocks : one segmental block of phone contexts
    rate : frame rate of the training utterances in Hz
    coding : digest of the visual coding whose parameters are predicted
    """

    hmm: Hmm
    blocks: Mapping[str, Block]
    rate: float
    coding: str = ""

    @property
    def outputs(self) -> int:
        """Dimension N of the parameters."""
        return self.hmm.gaussians.mean.shape[1] // 3

    def predict(self, streams: Sequence[Stream], frames: int, rate: float) -> np.ndarray:
        """Parameters (frames, N) float32 at ``rate`` Hz of the phones of one utterance.

        Raises
        ------
        DataError
            There is no frame, or the stream does not fit the block.
        """
        check_streams(streams, self.blocks)
        return self.hmm.predict(track_of(streams[0], *columns_of(self.blocks)), frames, rate)

    def save(self, path: str | Path) -> None:
        """Write it as one safetensors file."""
        arrays, blocks = pack(self.blocks)
        own, state = self.hmm.state()
        settings = {"kind": "model", "family": FAMILY, "hmm": state, "blocks": blocks, "rate": float(self.rate)}
        write_model(path, {**arrays, **own}, {**settings, "coding": self.coding})


def track_of(stream: Stream, divisions: int = 1, factors: tuple[Factor, ...] = ()) -> PhoneTrack:
    """The phones of an utterance; the phone itself is in the middle one of the columns that hold phones.

    Parameters
    ----------
    divisions : rows of each phone; if there are several, the last column holds their number
    factors : columns of numbers that follow those of the phones
    """
    columns = stream.index.shape[1] - len(factors) - (divisions > 1)
    return PhoneTrack(stream.index.astype(np.int64), stream.starts, (columns - 1) // 2, divisions, factors)


class Tracks(Sequence):
    """Utterances as HMMs with these input blocks are trained on them: (phone track, values (T, N), rate in Hz)."""

    def __init__(self, examples: Sequence[Example], blocks: Mapping[str, Block]) -> None:
        self._examples, self._columns = examples, columns_of(blocks)

    def __len__(self) -> int:
        return len(self._examples)

    def __getitem__(self, number: int) -> tuple[PhoneTrack, np.ndarray, float]:
        streams, target, rate = self._examples[number]
        return track_of(streams[0], *self._columns), target, rate


def columns_of(blocks: Mapping[str, Block]) -> tuple[int, tuple[Factor, ...]]:
    """Divisions of a phone and factors of the one block that HMMs read: what its columns hold beside phones."""
    block = next(iter(blocks.values()))
    return block.divisions, tuple(Factor(*one) for one in getattr(block, "factors", ()))


def symbols_of(block: Block) -> tuple[str, ...]:
    """The phones that the columns of a segmental block number: its inventory, or more than that."""
    return tuple(getattr(block, "symbols", block.phones))


def fit(task: Task) -> Fitted:
    """Train the HMMs of a row: from the utterances (monophone), or from the row before (tied, mge).

    Raises
    ------
    DataError
        There is no utterance to learn from, the row reads no block of phone contexts, or its parent is missing.
    """
    row, settings = task.row, HmmSettings(**task.row.settings, seed=task.row.seed)
    blocks = list(task.blocks.values())
    if len(blocks) != 1 or not blocks[0].layout.segmental:
        raise DataError(
            f"`models.{row.name}.reads` must name one segmental block, of kind phone_track or full_context."
        )
    check_examples(task.training, task.blocks, "training")
    training, validation = (Tracks(part, task.blocks) for part in (task.training, task.validation))
    if settings.variant == "monophone":
        hmm = fit_monophones(training, symbols_of(blocks[0]), settings)
    else:
        if not task.parents:
            raise DataError(f"`models.{row.name}` is of the variant {settings.variant} and needs `from`.")
        start = replace(load(task.parents[0]).hmm, settings=settings)
        hmm = fit_tied(start, training) if settings.variant == "tied" else refine(start, training, validation)
    return Fitted(HmmModel(hmm, task.blocks, float(task.training[0].rate), task.coding), hmm.history_table())


def load(path: str | Path) -> HmmModel:
    """Read saved HMMs; raises as :func:`restore`."""
    return restore(*read_model(path), path)


def restore(arrays: Mapping[str, np.ndarray], settings: Mapping, path: str | Path) -> HmmModel:
    """The HMMs in a file's content; raises as :func:`visualspeech.storage.models.check_model`."""
    check_model(arrays, settings, path, "phone HMMs", ["model"], LAYOUT, FAMILY)
    blocks = unpack(arrays, settings["blocks"], path)
    hmm = Hmm.restore(arrays, settings["hmm"], path)
    layout = hmm.tying.layout
    read = layout.sizes(len(hmm.phones)), (layout.divisions, layout.factors), hmm.phones
    fits = [
        block.layout.segmental and (block.layout.sizes, columns_of({name: block}), symbols_of(block)) == read
        for name, block in blocks.items()
    ]
    if fits != [True] or layout.centre != (layout.columns - 1) // 2:
        raise DamagedFile(path, "its phones are not those of its input block")
    return HmmModel(hmm, blocks, settings["rate"], settings["coding"])


LAYOUT = FileLayout({**ARRAYS, **BLOCK_ARRAYS}, {"hmm": PLAIN, "blocks": BLOCKS, "rate": RATE, "coding": TEXT})
