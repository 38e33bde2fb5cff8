"""What an input block is: how it is fitted, what it reads of an utterance, and how it is kept.

A block of kind ``log_mel`` lives in the module ``log_mel`` beside this one, whose ``BLOCK`` is its class; there is no
list to enter it in, so that a new kind leaves the results of the others alone. It is torch-free, so that features are
computed by light jobs and a talking head can encode new speech.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import MappingProxyType
from typing import ClassVar, Protocol

import numpy as np

from visualspeech.errors import DamagedFile, SettingError, StorageError
from visualspeech.features.streams import Layout, Stream
from visualspeech.speech.alignment import Alignment, read_alignments
from visualspeech.speech.sound import Sound, StoredSamples
from visualspeech.speech.substitutes import in_phones
from visualspeech.storage.layouts import TEXT, FileLayout, check_plain
from visualspeech.storage.models import read_model_of, write_model


@dataclass(frozen=True)
class Source:
    """What a block is computed from, of one utterance.

    Parameters
    ----------
    frames, rate : length and rate in Hz of the visual stream that the block's stream accompanies
    alignment : words, phones and states with their times; None where no block needs ``text``
    sound : the recording; None where no block needs ``audio``
    begin : time in seconds in the sound of the visual stream's beginning, where it accompanies a part of the sound
    parameters : (frames, N) recorded parameters of the visual coding, an array or what NumPy makes one of; None where
        no block needs ``faces``, and for new speech
    id : of a recorded utterance; empty for new speech
    speaker : who speaks in a recorded utterance; empty for new speech
    """

    frames: int
    rate: float
    alignment: Alignment | None = None
    sound: Sound | None = None
    begin: float = 0.0
    parameters: "np.ndarray | StoredParameters | None" = None
    id: str = ""
    speaker: str = ""


@dataclass(frozen=True, eq=False)
class StoredParameters:
    """Recorded parameters of an utterance in a file of arrays, read where they are made an array.

    Parameters
    ----------
    arrays : opened reader or collection with the array ``appearance``
    utterance : id
    """

    arrays: object
    utterance: str

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return np.asarray(self.arrays.array(self.utterance, "appearance"), dtype)


class Block(Protocol):
    """An input block, fitted.

    A block that is computed from sound says so with ``needs = ("audio",)``; see :func:`needs_of`. One whose rows are
    segments says so with ``segmental = True``, so that planning knows it. One whose streams need less than its fit has
    ``encoding_needs(settings)``, see :func:`encoding_needs`, and ``encoded_from``. One that is computed from another
    block of the system has ``made_of``, see :func:`parts_of`, and its ``fit`` takes the fitted blocks by name as a
    fourth argument. One that keeps what only training utterances need has ``for_new_speech()``, the block without it.
    One that normalises per speaker has ``with_speakers(sources)``, see :func:`with_unseen_speakers`. One that needs an
    optional package has ``unavailable()``, see :func:`unavailable`. One that knows the phones of ARPAbet alone says so
    with ``arpabet = True``.
    """

    kind: ClassVar[str]
    #: Subclass of :class:`visualspeech.fields.Settings`; None for a block without settings.
    settings: ClassVar[type | None]
    #: What :meth:`state` gives, against which a file is checked before :meth:`restore` sees it.
    stored: ClassVar[FileLayout]

    @classmethod
    def fit(cls, settings: Mapping, phones: Sequence[str], training: Iterable[Source]) -> "Block":
        """The block for a corpus.

        Parameters
        ----------
        settings : those of the block in the system's settings, defaults filled in
        phones : inventory of the corpus
        training : training utterances; read only by blocks that learn from them, which may go through them repeatedly
            where it is no iterator
        """

    @property
    def layout(self) -> Layout:
        """Columns of its streams."""

    def encode(self, sources: Sequence[Source]) -> Iterator[Stream]:
        """The stream of each utterance."""

    def state(self) -> tuple[dict[str, np.ndarray], dict]:
        """What :meth:`restore` makes the block of: arrays, and plain data."""

    @classmethod
    def restore(cls, arrays: Mapping[str, np.ndarray], plain: Mapping) -> "Block":
        """The inverse of :meth:`state`."""


def block_kinds() -> list[str]:
    """Names of all kinds of input blocks."""
    own = __name__.rpartition(".")[2]
    return sorted(one.name for one in iter_modules(import_module(__package__).__path__) if one.name != own)


def block_module(kind: str) -> str:
    """Name of the module of a kind."""
    return f"{__package__}.{kind}"


def block_class(kind: str) -> type[Block]:
    """The class of a kind.

    Raises
    ------
    StorageError
        The kind is unknown.
    """
    if kind not in block_kinds():
        raise StorageError(f"the input block kind {kind!r} is unknown. Known: {', '.join(block_kinds())}.")
    return import_module(block_module(kind)).BLOCK


def needs_of(block: "type[Block] | Block") -> tuple[str, ...]:
    """What a block, or its class, is fitted on and computed from.

    ``text`` (the alignment; where it says nothing), ``audio`` (the sound), ``faces`` (recorded parameters).
    """
    return tuple(getattr(block, "needs", ("text",)))


def encoding_needs(block: "type[Block] | Block", settings: Mapping | None = None) -> tuple[str, ...]:
    """As :func:`needs_of`, of what a stream is computed from, where that is less than what the block is fitted on.

    Parameters
    ----------
    block : fitted, or a class
    settings : of a block of this class, defaults filled in; not needed for a fitted one
    """
    if isinstance(block, type):
        return tuple(block.encoding_needs(settings)) if hasattr(block, "encoding_needs") else needs_of(block)
    return tuple(getattr(block, "encoded_from", needs_of(block)))


def parts_of(block: "type[Block]") -> Mapping[str, str]:
    """Settings of a block of this class that name another block, which it is computed from -> the kind of that one."""
    return getattr(block, "made_of", {})


def fit_block(
    kind: str,
    settings: Mapping,
    phones: Sequence[str],
    training: Iterable[Source],
    blocks: "Mapping[str, Block]" = MappingProxyType({}),
) -> Block:
    """A block for a corpus, see :meth:`Block.fit`; ``blocks`` are those that it is computed from, by name."""
    return block_class(kind).fit(settings, phones, training, *([blocks] if blocks else []))


def for_new_speech(block: Block) -> Block:
    """A block without what only training utterances need, as it is kept with a model."""
    return block.for_new_speech() if hasattr(block, "for_new_speech") else block


def with_unseen_speakers(block: Block, sources: Iterable[Source]) -> Block:
    """A block that also knows the speakers who have no training utterance, from all utterances of theirs.

    Only their sound is used, as it is where a speaker is new; other blocks stay as they are.
    """
    return block.with_speakers(sources) if hasattr(block, "with_speakers") else block


def unavailable(block: "type[Block]") -> str:
    """Why blocks of this class cannot be computed with what is installed, and what to do; empty if they can."""
    return block.unavailable() if hasattr(block, "unavailable") else ""


def needs_arpabet(block: "type[Block] | Block") -> bool:
    """Whether a block, or its class, knows the phones of ARPAbet alone; a class that says nothing takes any."""
    return bool(getattr(block, "arpabet", False))


def is_segmental(block: "type[Block] | Block") -> bool:
    """Whether the rows of a block, or of its class, are segments; a class that says nothing has frames."""
    return bool(getattr(block, "segmental", False))


def restore(kind: str, arrays: Mapping[str, np.ndarray], plain: Mapping, path: str | Path = "") -> Block:
    """A fitted block from its state, which the file ``path`` holds.

    Raises
    ------
    StorageError
        The kind is unknown, or the state is not one of that kind.
    """
    if kind not in block_kinds():
        raise DamagedFile(path, f"the input block kind {kind[:40]!r} is unknown. Known: {', '.join(block_kinds())}")
    cls = block_class(kind)
    cls.stored.check(path, arrays, plain)
    try:
        return cls.restore(arrays, plain)
    except SettingError as error:
        raise DamagedFile(path, f"its input block {kind} has settings that do not go together: {error}") from error
    except DamagedFile as error:  # of a block inside it, which does not know the file
        raise DamagedFile(path, error.reason) from error


def save_block(path: str | Path, block: Block) -> None:
    """Write a fitted block as one safetensors file."""
    arrays, plain = block.state()
    write_model(path, arrays, {"kind": "block", "block": block.kind, "state": plain})


def load_block(path: str | Path) -> Block:
    """Read what :func:`save_block` wrote; raises as :func:`restore`."""
    arrays, settings = read_model_of(path, "input block", ["block"])
    check_plain(path, settings, _BLOCK)
    return restore(settings["block"], arrays, settings["state"], path)


_BLOCK = {
    "type": "object",
    "required": ["kind", "block", "state"],
    "additionalProperties": False,
    "properties": {"kind": TEXT, "block": TEXT, "state": {"type": "object"}},
}


def phones_of(block: Block) -> tuple[str, ...]:
    """The inventory of a fitted block; empty where it reads no phones."""
    return tuple(getattr(block, "phones", ()))


def read_sources(
    alignment: str | Path | None,
    targets,
    ids: Collection[str],
    phones: Sequence[str] = (),
    complete: bool = False,
    audio=None,
    faces: bool = False,
    speakers: Mapping[str, str] = MappingProxyType({}),
) -> dict[str, Source]:
    """What blocks are computed from, of the utterances of one shard, by id.

    Parameters
    ----------
    alignment : table of the shard; None where no alignment is needed
    targets : open reader or collection, which gives length and rate of each utterance
    ids : the utterances that are wanted; those without targets, or without the alignment or sound that is needed, are
        left out
    phones : inventory; a phone that it lacks, because no training utterance has it, is replaced by the most similar one
        (:mod:`visualspeech.speech.substitutes`); empty: none is replaced
    complete : whether there must be an alignment of all of them; raises :class:`StorageError` where one is missing
    audio : open reader or collection of the sound, which is read when a block asks for it; None where it is not needed
    faces : whether the recorded parameters are needed, which are read from the targets when a block asks for them
    speakers : who speaks, by id
    """
    alignments = None if alignment is None else read_alignments(alignment)
    for name in ids if complete and alignments is not None else ():
        alignments[name]
    found = {}
    for name in sorted(ids) if alignments is None else alignments:
        if name in ids and name in targets and (complete or audio is None or name in audio):
            found[name] = Source(
                targets.length(name, "appearance"),
                targets.rate(name),
                None if alignments is None else in_phones(alignments[name], phones)[0],
                None if audio is None else Sound(StoredSamples(audio, name), audio.rate(name)),
                parameters=StoredParameters(targets, name) if faces else None,
                id=name,
                speaker=speakers.get(name, ""),
            )
    return found


@dataclass(frozen=True)
class Sources:
    """Some utterances of all shards, read anew each time that they are gone through.

    Parameters
    ----------
    alignments : tables of the shards; empty where no alignment is needed
    targets, ids, audio, faces, speakers : see :func:`read_sources`
    """

    alignments: Sequence[str | Path]
    targets: object
    ids: Collection[str]
    audio: object = None
    faces: bool = False
    speakers: Mapping[str, str] = field(default_factory=dict)

    def __iter__(self) -> Iterator[Source]:
        # Without an alignment, one pass over all shards.
        for path in self.alignments or [None]:
            yield from read_sources(
                path, self.targets, self.ids, audio=self.audio, faces=self.faces, speakers=self.speakers
            ).values()
