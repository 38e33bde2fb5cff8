"""Alignments made by other programs: labelled intervals of words and phones become an :class:`Alignment`.

Whatever is wrong with them is a :class:`RejectedUtterance` that names file, tier, time and label. Nothing is guessed:
the times are those of the intervals, apart from rounding (:data:`ROUNDING`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.phone_sets import UNKNOWN_SOUND, PhoneSet
from visualspeech.speech.phones import SILENCE, STATES

ROUNDING = 0.005  # seconds: shorter gaps, and overlaps, are rounding of the times
MAX_OUTSIDE = 0.05  # seconds that a phone may end after the sound; sound tracks are cut differently by programs
WARN_LENGTH = 0.2  # seconds between the length of the file and of the sound, from which on it is reported
_STATE_ROUNDING = 0.001  # seconds between the border of a phone and of its states
_LEAST = 1e-4  # seconds of a phone
_DIGITS = 5  # decimal places of times in seconds
#: Labels of pauses in a tier of words; "silence" and "pause" are words.
_PAUSES = frozenset(("", SILENCE, "sp", "<eps>", "<sil>", "<s>", "</s>", "<p:>", "#", "_"))
EDIT = "Correct it there (in Praat, or align again), or leave the utterance out."


@dataclass(frozen=True, slots=True)
class Interval:
    """A labelled interval of a tier: seconds, and the label without white space around it."""

    start: float
    end: float
    label: str


@dataclass(frozen=True)
class Given:
    """The intervals of one utterance in a file.

    Parameters
    ----------
    file, word_tier, phone_tier : names, for messages
    words, phones : in the order of time; gaps are pauses
    states : of a tier of states that this project wrote; empty if there is none
    seconds : length that the file says the sound has; 0 if it says none
    """

    file: str
    words: tuple[Interval, ...]
    phones: tuple[Interval, ...]
    states: tuple[Interval, ...] = ()
    seconds: float = 0.0
    word_tier: str = "words"
    phone_tier: str = "phones"


@dataclass(frozen=True)
class Assembled:
    """An alignment, and what a user should know of it: pairs of finding and remedy."""

    alignment: Alignment
    warnings: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class _Phone:
    label: str
    start: float
    end: float
    word: int  # number of its word, -1 of a pause


def cut(given: Given, begin: float, end: float) -> Given:
    """The part of a file from ``begin`` to ``end`` seconds (0: to its end), with times from ``begin``."""
    last = end or math.inf

    def part(intervals: Sequence[Interval]) -> tuple[Interval, ...]:
        inside = (
            Interval(max(one.start, begin) - begin, min(one.end, last) - begin, one.label)
            for one in intervals
            if min(one.end, last) - max(one.start, begin) > ROUNDING
        )
        return tuple(inside)

    seconds = max(0.0, min(given.seconds, last) - begin) if given.seconds else 0.0
    tiers = {name: part(getattr(given, name)) for name in ("words", "phones", "states")}
    return replace(given, **tiers, seconds=seconds)


def assembled(given: Given, seconds: float, phones: PhoneSet, from_tier: bool = False) -> Assembled:
    """The alignment that intervals describe: tiers without gaps from 0 s to the end of the sound.

    Sound to which the aligner gave no phones (``spn``) counts as a pause, with a warning.

    Parameters
    ----------
    seconds : duration of the sound
    phones : phone set of the labels
    from_tier : whether the states are those of the tier of states; else, and where it does not fit, thirds of the phone

    Raises
    ------
    RejectedUtterance
        A time is no number, negative, or after the end of the sound; intervals overlap or end before they start; a
        label is no phone of the set; a phone is in no word, or a word has no phones.
    """
    for tier in ("word", "phone"):
        _check_times(given, getattr(given, f"{tier}s"), getattr(given, f"{tier}_tier"))
    words = [one for one in given.words if one.label.lower() not in _PAUSES]
    spoken, unknown = _spoken(given, words, phones)
    if not spoken:
        raise RejectedUtterance(f"{given.file}: the tier {given.phone_tier!r} has no phone of speech", EDIT)
    tiled = _tiled(_inside(given, spoken, seconds), seconds)
    for one in tiled:
        if one.end - one.start < _LEAST:
            raise RejectedUtterance(
                f"{given.file}, tier {given.phone_tier!r}, {one.start:.3f} s: {one.label!r} has no duration", EDIT
            )
    alignment, misfits = _tiers(tiled, words, given.states if from_tier else (), from_tier)
    warnings = []
    if unknown:
        first = unknown[0]
        warnings.append((
            f"{given.file}: sound without phones counts as a pause: {len(unknown)} interval{'s' * (len(unknown) > 1)}, "
            f"the first {first.label!r} at {first.start:.2f} s",
            "Add the unknown words to the dictionary of the aligner and align again, or leave the utterance out.",
        ))  # fmt: skip
    if misfits:
        warnings.append((
            f"{given.file}: the tier of states does not fit {misfits} of its phones, whose states are thirds",
            "Nothing need be done where the phones were corrected by hand.",
        ))  # fmt: skip
    if given.seconds and abs(given.seconds - seconds) >= WARN_LENGTH:
        warnings.append((
            f"{given.file} is {given.seconds:.2f} s long, the sound of the recording {seconds:.2f} s",
            "Check that it belongs to this recording.",
        ))  # fmt: skip
    return Assembled(alignment, tuple(warnings))


def _at(given: Given, one: Interval, tier: str) -> str:
    return f"{given.file}, tier {tier!r}, {one.start:.2f} s: {one.label!r}"


def _check_times(given: Given, intervals: Sequence[Interval], tier: str) -> None:
    before = None
    for one in intervals:
        if not (math.isfinite(one.start) and math.isfinite(one.end)):
            raise RejectedUtterance(f"{given.file}, tier {tier!r}: a time of {one.label!r} is no number", EDIT)
        if one.start < -ROUNDING:
            raise RejectedUtterance(f"{_at(given, one, tier)} starts before 0 s", EDIT)
        if one.end <= one.start:
            raise RejectedUtterance(f"{_at(given, one, tier)} ends at {one.end:.2f} s, not after its start", EDIT)
        if before is not None and one.start < before.end - ROUNDING:
            raise RejectedUtterance(
                f"{_at(given, one, tier)} begins before {before.label!r} ends at {before.end:.2f} s", EDIT
            )
        before = one


def _spoken(given: Given, words: Sequence[Interval], phones: PhoneSet) -> tuple[list[_Phone], list[Interval]]:
    """Phones of speech with the words that they belong to, and the intervals of sound without phones."""
    starts = np.array([one.start for one in words])
    found: list[_Phone] = []
    unknown: list[Interval] = []
    noisy: set[int] = set()
    for one in given.phones:
        middle = (one.start + one.end) / 2
        word = int(np.searchsorted(starts, middle, side="right")) - 1
        inside = word >= 0 and middle < words[word].end
        if one.label.lower() in UNKNOWN_SOUND and one.label not in phones.table:
            unknown.append(one)
            noisy |= {word} if inside else set()
            continue
        names = phones.phones(one.label)
        if names is None:
            raise RejectedUtterance(
                f"{_at(given, one, given.phone_tier)} is no phone of the phone set {phones.name}",
                "Set `alignment.phones` to the set of the labels: arpabet, ipa, as_is, or a table that has this label.",
            )
        if names == (SILENCE,):
            continue
        if not inside:
            raise RejectedUtterance(
                f"{_at(given, one, given.phone_tier)} lies in no word of the tier {given.word_tier!r}", EDIT
            )
        borders = np.linspace(one.start, one.end, len(names) + 1).tolist()
        found += [_Phone(name, *borders[k : k + 2], word) for k, name in enumerate(names)]
    for number in sorted(set(range(len(words))) - {one.word for one in found} - noisy)[:1]:
        where = _at(given, words[number], given.word_tier)
        raise RejectedUtterance(f"{where} has no phones in the tier {given.phone_tier!r}", EDIT)
    return found, unknown


def _inside(given: Given, spoken: Sequence[_Phone], seconds: float) -> list[_Phone]:
    """Phones cut at the end of the sound."""
    last = spoken[-1]
    if last.end > seconds + MAX_OUTSIDE or last.start >= seconds - ROUNDING:
        raise RejectedUtterance(
            f"{given.file}, tier {given.phone_tier!r}: {last.label!r} ends at {last.end:.2f} s, after the end of the "
            f"sound at {seconds:.2f} s",
            "Check that the file belongs to this recording, and that its times are seconds.",
        )
    return [replace(one, end=min(one.end, seconds)) for one in spoken]


def _tiled(spoken: Sequence[_Phone], seconds: float) -> list[_Phone]:
    """Phones without gaps from 0 s to ``seconds``, with pauses between them where a gap is none of rounding."""
    tiled: list[_Phone] = []
    time = 0.0
    for one in spoken:
        start = one.start
        if start - time > ROUNDING:
            word = one.word if tiled and tiled[-1].word == one.word else -1
            tiled.append(_Phone(SILENCE, time, start, word))
        elif tiled and start > time:
            tiled[-1] = replace(tiled[-1], end=start)
        else:
            start = time
        tiled.append(replace(one, start=start))
        time = one.end
    if seconds - time > ROUNDING:
        tiled.append(_Phone(SILENCE, time, seconds, -1))
    tiled[-1] = replace(tiled[-1], end=seconds)
    return tiled


def _tiers(
    tiled: Sequence[_Phone], spoken: Sequence[Interval], states: Sequence[Interval], from_tier: bool
) -> tuple[Alignment, int]:
    """The three tiers, and the number of phones of speech whose states are not in a tier that should have them."""
    words: list[Segment] = []
    phones: list[Segment] = []
    parts: list[Segment] = []
    misfits, previous = 0, None
    starts = np.array([one.start for one in states])
    for phone in tiled:
        start, end = round(phone.start, _DIGITS), round(phone.end, _DIGITS)
        if phone.word == previous != -1:
            words[-1] = replace(words[-1], end=end)
        else:
            label = SILENCE if phone.word == -1 else "_".join(spoken[phone.word].label.lower().split())
            words.append(Segment(label, start, end))
        previous = phone.word
        borders = _borders(states, starts, start, end)
        misfits += from_tier and borders is None and phone.label != SILENCE
        borders = borders or [round(time, _DIGITS) for time in np.linspace(start, end, STATES + 1).tolist()]
        parts += [Segment(str(k + 1), *borders[k : k + 2], len(phones)) for k in range(STATES)]
        phones.append(Segment(phone.label, start, end, len(words) - 1))
    return Alignment(tuple(words), tuple(phones), tuple(parts)), int(misfits)


def _borders(states: Sequence[Interval], starts: np.ndarray, start: float, end: float) -> list[float] | None:
    """Borders of the three states of a phone in a tier of states; None where they are not its states."""
    first = int(np.searchsorted(starts, start - _STATE_ROUNDING))
    own = states[first : first + STATES]
    if [one.label for one in own] != [str(k + 1) for k in range(STATES)]:
        return None
    if abs(own[0].start - start) > _STATE_ROUNDING or abs(own[-1].end - end) > _STATE_ROUNDING:
        return None
    borders = [start, *(round(one.start, _DIGITS) for one in own[1:]), end]
    return borders if all(a < b for a, b in zip(borders, borders[1:], strict=False)) else None
