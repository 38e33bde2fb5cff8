"""The alignment of an utterance: which word, phone and HMM state is spoken when; and its table files."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from visualspeech.errors import DamagedFile
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.storage.tables import read_table
from visualspeech.timing import frame_times, interval_of_frame

TIERS = ("word", "phone", "state")
COLUMNS = ("id", "tier", "index", "parent", "label", "start", "end")
_NUMBERS = COLUMNS[2:4] + COLUMNS[5:]
_TOLERANCE = 1e-4  # seconds between the end of a segment and the start of the next that are no gap


@dataclass(frozen=True, slots=True)
class Segment:
    """One interval of a tier.

    Parameters
    ----------
    label : word, phone, or number of the state
    start, end : seconds
    parent : index of the segment of the tier above that it belongs to; -1 for none
    """

    label: str
    start: float
    end: float
    parent: int = -1


@dataclass(frozen=True)
class Alignment:
    """Words, phones and HMM states of one utterance; each tier covers it from 0 s to its end without gaps.

    Parameters
    ----------
    words, phones, states : the tiers; a pause is labelled "sil", the states of a phone "1" to "3"
    guessed : (word, pronunciation) of each word that the dictionary does not list, as it was aligned
    """

    words: tuple[Segment, ...]
    phones: tuple[Segment, ...]
    states: tuple[Segment, ...]
    guessed: tuple[tuple[str, tuple[str, ...]], ...] = ()

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.words[-1].end

    def tier(self, name: str) -> tuple[Segment, ...]:
        """Segments of the tier ``word``, ``phone`` or ``state``."""
        return {"word": self.words, "phone": self.phones, "state": self.states}[name]


def starts_of(segments: tuple[Segment, ...]) -> np.ndarray:
    """Starts of the segments of a tier in seconds, (n,) float64."""
    return np.array([one.start for one in segments], np.float64)


def silent_frames(alignment: Alignment, frames: int, rate: float) -> np.ndarray:
    """Frames without speech, (frames,) bool: those whose time lies in a pause of the phone tier.

    Parameters
    ----------
    frames, rate : number of frames and frame rate in Hz of the visual stream
    """
    silent = np.array([one.label == SILENCE for one in alignment.phones])
    return silent[interval_of_frame(starts_of(alignment.phones), frame_times(frames, rate))]


def to_table(alignments: Mapping[str, Alignment]):
    """Alignments by utterance as a data frame with the columns id, tier, index, parent, label, start, end (seconds)."""
    import pandas

    rows = [
        (name, tier, i, one.parent, one.label, one.start, one.end)
        for name, alignment in alignments.items()
        for tier in TIERS
        for i, one in enumerate(alignment.tier(tier))
    ]
    return pandas.DataFrame(rows, columns=list(COLUMNS))


class Alignments(dict):
    """Alignments of one file by utterance; asking for one that it does not hold raises :class:`StorageError`."""

    def __init__(self, path: str | Path, found: Mapping[str, Alignment]) -> None:
        super().__init__(found)
        self.path = path

    def __missing__(self, utterance_id: str):
        raise _unreadable(self.path, f"utterance {utterance_id} is missing")


def read_alignments(path: str | Path, ids: Collection[str] | None = None) -> Alignments:
    """Alignments in a table file by utterance, in the order of the file.

    Parameters
    ----------
    path : TSV file, as :func:`to_table` lays it out; the rows of a tier may be in any order
    ids : utterances to read, None for all; one that is not in the file is left out

    Raises
    ------
    StorageError
        The file is missing, or holds a row that is no part of an alignment, of whatever utterance; the message names
        the file and the line.
    """
    import pandas

    table = read_table(path, ("id", "tier", "label"), _NUMBERS, COLUMNS)
    table = table.assign(line=np.arange(2, len(table) + 2))  # line 1 holds the names of the columns
    # A row with a damaged id is of no wanted utterance, so all rows are checked before some are chosen.
    owners, names = pandas.factorize(table["id"])
    tiers = table["tier"].map({tier: number for number, tier in enumerate(TIERS)}).fillna(-1).to_numpy(int)
    order = np.lexsort((table["index"].to_numpy(float), tiers, owners))
    table, group = table.iloc[order], (len(TIERS) * owners + tiers)[order]
    _check_values(path, table)
    counts = np.bincount(group, minlength=len(TIERS) * len(names))
    for number in np.flatnonzero(counts == 0)[:1]:
        owner, tier = divmod(int(number), len(TIERS))
        raise _unreadable(path, f"utterance {names[owner]} has no segment of the tier {TIERS[tier]}")
    ends = np.cumsum(counts)
    _check_structure(path, table, group, counts, ends - counts)
    _check_ends(path, table, ends, names)
    parents = table["parent"].astype(int)
    columns = (table["label"], table["start"].astype(float), table["end"].astype(float), parents)
    rows = list(zip(*(column.tolist() for column in columns), strict=True))
    found = {}
    for number, name in enumerate(names):
        if ids is None or name in ids:
            tiers = range(len(TIERS) * number, len(TIERS) * (number + 1))
            segments = (tuple(Segment(*row) for row in rows[ends[tier] - counts[tier] : ends[tier]]) for tier in tiers)
            found[str(name)] = Alignment(*segments)
    return Alignments(path, found)


def alignments_of(paths: Iterable[str | Path], ids: Iterable[str]) -> dict[str, Alignment]:
    """Alignments of some utterances from several files; raises as :func:`read_alignments`, or where one is missing."""
    wanted, paths = set(ids), list(paths)
    found = {name: one for path in paths for name, one in read_alignments(path, wanted).items()}
    for name in sorted(wanted - set(found))[:1]:
        raise _unreadable(", ".join(map(str, paths)), f"utterance {name} is missing")
    return found


def _check_values(path, table) -> None:
    """Refuse rows that are wrong by themselves."""
    numbers = table[list(_NUMBERS)].to_numpy(float)
    whole = table[["index", "parent"]].to_numpy(float)
    state = (table["tier"] == "state").to_numpy()
    number = table["label"].isin([str(1 + number) for number in range(STATES)]).to_numpy()
    _refuse(path, table, ~table["tier"].isin(TIERS).to_numpy(), f"the tier must be one of {', '.join(TIERS)}")
    _refuse(path, table, ~np.isfinite(numbers).all(axis=1), "index, parent, start and end must be numbers")
    _refuse(path, table, (whole != np.floor(whole)).any(axis=1), "index and parent must be whole numbers")
    _refuse(path, table, numbers[:, 3] < numbers[:, 2], "the segment ends before it starts")
    _refuse(path, table, state & ~number, f"the label of a state must be a number from 1 to {STATES}")


def _check_structure(path, table, group: np.ndarray, counts: np.ndarray, firsts: np.ndarray) -> None:
    """Refuse rows that do not fit the others: rows sorted by utterance, tier and index.

    Parameters
    ----------
    group : (R,) number of the utterance's tier that a row belongs to
    counts, firsts : rows of each group, and the number of its first row
    """
    position = np.arange(len(group)) - firsts[group]
    parent = table["parent"].to_numpy(float)
    word = group % len(TIERS) == 0
    above = np.where(word, 0, counts[group - 1])
    start, end = table["start"].to_numpy(float), table["end"].to_numpy(float)
    apart = np.zeros(len(group), bool)
    apart[1:] = (position[1:] > 0) & (np.abs(start[1:] - end[:-1]) > _TOLERANCE)
    _refuse(path, table, table["index"].to_numpy(float) != position, "the index must number the segments of its tier")
    _refuse(path, table, (parent < -word.astype(int)) | (parent >= above), "the parent is no segment of the tier above")
    _refuse(path, table, apart, "the segment does not start where the one before it ends")


def _check_ends(path, table, ends: np.ndarray, names) -> None:
    """Refuse utterances whose tiers end at different times: the last rows of one of them are missing."""
    last = table["end"].to_numpy(float)[ends - 1].reshape(-1, len(TIERS))
    for number in np.flatnonzero(np.ptp(last, axis=1) > _TOLERANCE)[:1]:
        raise _unreadable(path, f"the tiers of utterance {names[number]} end at different times; rows are missing")


def _refuse(path, table, bad: np.ndarray, reason: str) -> None:
    for at in np.flatnonzero(bad)[:1]:
        row = table.iloc[at]
        raise _unreadable(path, f"line {row['line']} (utterance {row['id']}, tier {row['tier']}): {reason}")


def _unreadable(path, reason: str) -> DamagedFile:
    return DamagedFile(path, f"it holds no alignments: {reason}")
