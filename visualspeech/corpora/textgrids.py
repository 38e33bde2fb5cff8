"""TextGrid files of Praat and of the Montreal Forced Aligner, long or short, UTF-8 or UTF-16."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from visualspeech.corpora.records import displayable
from visualspeech.errors import RejectedUtterance, plain_reason
from visualspeech.speech.given import EDIT, Given, Interval
from visualspeech.storage.foreign import decoded, read_bytes

MAX_BYTES = 30_000_000  # some twenty hours of speech
MAX_LINE = 10_000  # characters
STATE_TIER = "states"  # as this project exports it
AGAIN = "Save it again as a TextGrid in UTF-8 (in Praat: Save as text file), or align again."
_HEAD = re.compile(r'\s*(?:File type\s*=\s*)?"ooTextFile(?: short)?"')
# A line that is a time or a number of entries, and nothing else.
_NUMBER = re.compile(
    r"\s*(?:(?:xmin|xmax|number|time|size)\s*=\s*)?([-+]?(?:nan|inf(?:inity)?|\.?\d[\d.]*(?:e[-+]?\d+)?))\s*",
    re.IGNORECASE,
)
_COUNT = re.compile(
    r'intervals\s*:\s*size\s*=\s*(\d+)|"IntervalTier"\s*\n\s*"[^\n]*"\s*\n[^\n"]*\n[^\n"]*\n\s*(\d+)\s*\n'
)


def read_textgrid(path: str | Path, word_tier: str, phone_tier: str, speaker: str = "") -> Given:
    """The words and phones of a TextGrid.

    Tiers are found by their names, capitals aside: ``words``, or ``speaker - words`` where a file has tiers of several
    speakers, as the Montreal Forced Aligner names them.

    Parameters
    ----------
    word_tier, phone_tier : names
    speaker : whose tiers are read where there are several

    Raises
    ------
    RejectedUtterance
        The file cannot be read, is no TextGrid, or lacks a tier; the reason names it.
    """
    name = displayable(Path(path).name)
    tiers, seconds = _tiers(path, name)
    words, phones = (_tier(tiers, tier, speaker, name) for tier in (word_tier, phone_tier))
    states = next((one["entries"] for one in tiers if one["name"].strip().lower() == STATE_TIER), [])
    return Given(
        name,
        *(_intervals(one["entries"], name, one["name"]) for one in (words, phones)),
        states=_intervals(states, name, STATE_TIER),
        seconds=seconds,
        word_tier=words["name"],
        phone_tier=phones["name"],
    )


def _tiers(path: str | Path, name: str) -> tuple[list[Mapping], float]:
    """The tiers of intervals of a file, as praatio reads them, and its length in seconds."""
    from praatio.utilities.textgrid_io import parseTextgridStr

    try:
        text = decoded(read_bytes(path, MAX_BYTES)).replace("\r\n", "\n").replace("\r", "\n")
    except OSError as error:
        raise RejectedUtterance(f"{name} cannot be read: {plain_reason(error)}", AGAIN) from error
    if "\0" in text or not _HEAD.match(text):
        raise RejectedUtterance(f"{name} is no TextGrid, or in another encoding than UTF-8 and UTF-16", AGAIN)
    text = _plain_numbers(text, name)
    try:
        found = parseTextgridStr(text if text.endswith("\n") else f"{text}\n", includeEmptyIntervals=True)
        tiers = [one for one in found["tiers"] if one["class"] == "IntervalTier"]
        seconds = float(found["xmax"])
    except Exception as error:  # praatio raises errors of many kinds for files that break off
        raise RejectedUtterance(f"{name} is damaged: no tiers of a TextGrid can be read", AGAIN) from error
    counts = [int(long or short) for long, short in _COUNT.findall(text)]
    for one, count in zip(tiers, counts, strict=False):
        if len(one["entries"]) != count:
            raise RejectedUtterance(
                f"{name} is damaged: its tier {one['name']!r} should have {count} intervals and has "
                f"{len(one['entries'])}",
                AGAIN,
            )
    if len(counts) != len(tiers):
        raise RejectedUtterance(f"{name} is damaged: it breaks off in its tier {len(tiers)}", AGAIN)
    return tiers, seconds


def _plain_numbers(text: str, name: str) -> str:
    """The text with times as praatio reads them: it knows no exponents and passes over signs."""
    lines = text.split("\n")
    if max(map(len, lines)) > MAX_LINE:
        raise RejectedUtterance(f"{name} is no TextGrid: a line has more than {MAX_LINE:,} characters", AGAIN)
    for number, line in enumerate(lines):
        found = _NUMBER.fullmatch(line)
        if found is None:
            continue
        try:
            value = float(found[1])
        except ValueError:
            value = math.nan
        if not math.isfinite(value) or value < -1e-3:
            raise RejectedUtterance(
                f"{name}, line {number + 1}: {line.strip()[:40]!r} is no time" + " from 0 s on" * (value < 0), EDIT
            )
        if "e" in found[1].lower() or value < 0 or found[1][0] in "-+.":
            lines[number] = line.replace(found[1], f"{max(value, 0.0):.12f}")
    return "\n".join(lines)


def _tier(tiers: Sequence[Mapping], wanted: str, speaker: str, name: str) -> Mapping:
    """The tier of a name, of the speaker where there are several."""
    own, plain = f"{speaker} - {wanted}".lower(), wanted.lower()
    names = [one["name"].strip().lower() for one in tiers]
    of_speakers = [one for one, tier in zip(tiers, names, strict=True) if tier.endswith(f" - {plain}")]
    for one, tier in zip(tiers, names, strict=True):
        if tier == plain or (speaker and tier == own):
            return one
    if len(of_speakers) == 1:
        return of_speakers[0]
    known = ", ".join(repr(one["name"][:40]) for one in tiers[:8]) or "none of intervals"
    if of_speakers:
        raise RejectedUtterance(
            f"{name} has tiers {wanted!r} of several speakers and none of {speaker!r} (its tiers: {known})",
            "Name the speaker as in the tiers: `speaker` of the corpus, the column of its table, or the folder's name.",
        )
    raise RejectedUtterance(
        f"{name} has no tier {wanted!r} (its tiers: {known})",
        "Set `alignment.word_tier` and `alignment.phone_tier` to the names of the tiers.",
    )


def _intervals(entries: Sequence, name: str, tier: str) -> tuple[Interval, ...]:
    try:
        return tuple(Interval(float(start), float(end), " ".join(label.split())) for start, end, label in entries)
    except ValueError as error:
        raise RejectedUtterance(f"{name}, tier {tier!r}: a time is no number", EDIT) from error
