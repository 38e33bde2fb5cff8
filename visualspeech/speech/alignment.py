"""Forced alignment: which word, phone and HMM state is spoken when (PocketSphinx, 100 frames a second)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, RejectedUtterance, SettingError
from visualspeech.speech.lexicon import Lexicon, Pronunciation
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.storage import read_table

RATE = 16000  # Hz, of the acoustic model
TIERS = ("word", "phone", "state")
COLUMNS = ("id", "tier", "index", "parent", "label", "start", "end")
_FRAME = 0.01  # seconds
_DIGITS = 5  # of times in seconds


@dataclass(frozen=True)
class AlignmentSettings:
    """Parameters of the alignment.

    Parameters
    ----------
    padding : seconds of quiet noise put before and after the sound, so that it may begin and end with speech
    noise : amplitude of that noise, root mean square in 16-bit steps
    delay : seconds by which a frame's first sample lies before the border that the frame stands for (see ``_times``)
    """

    padding: float = 0.2
    noise: float = 5.0
    delay: float = 0.0

    def __post_init__(self) -> None:
        for name in ("padding", "noise", "delay"):
            if not 0 <= getattr(self, name) <= 1000:
                raise SettingError(f"alignment.{name} is {getattr(self, name)}; it must not be negative.")


@dataclass(frozen=True)
class Segment:
    """One interval of a tier: label, start and end in seconds, index of the interval of the tier above (-1: none)."""

    label: str
    start: float
    end: float
    parent: int = -1


@dataclass(frozen=True)
class Alignment:
    """Words, phones and states of one utterance; each tier follows without a gap from 0 to the utterance's end.

    Parameters
    ----------
    words, phones, states : the three tiers; pauses are "sil", states "1" to "3"
    guessed : (word, pronunciation) of the words that the dictionary does not list, as they were aligned
    """

    words: tuple[Segment, ...]
    phones: tuple[Segment, ...]
    states: tuple[Segment, ...]
    guessed: tuple[tuple[str, Pronunciation], ...] = ()

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.words[-1].end

    def tier(self, name: str) -> tuple[Segment, ...]:
        """Intervals of the tier ``word``, ``phone`` or ``state``."""
        return {"word": self.words, "phone": self.phones, "state": self.states}[name]


class Aligner:
    """Aligns utterances; the answer to one does not depend on those before it (each has a decoder of its own)."""

    def __init__(self, settings: AlignmentSettings | None = None, lexicon: Lexicon | None = None) -> None:
        self.settings = settings or AlignmentSettings()
        self.lexicon = lexicon or Lexicon()

    def align(self, samples: np.ndarray, transcript: str) -> Alignment:
        """Align one utterance, see :func:`align`."""
        return align(samples, transcript, self.lexicon, self.settings)


def align(
    samples: np.ndarray, transcript: str, lexicon: Lexicon | None = None, settings: AlignmentSettings | None = None
) -> Alignment:
    """Align the sound of one utterance with what is said in it.

    Parameters
    ----------
    samples : (n,) int16, mono, 16 kHz
    transcript : as written

    Raises
    ------
    RejectedUtterance
        There is nothing to align, a word cannot be pronounced, or the sound is not this transcript's.
    """
    settings = settings or AlignmentSettings()
    lexicon = lexicon or Lexicon()
    samples = np.ascontiguousarray(samples)
    if samples.dtype != np.int16 or samples.ndim != 1:
        raise DataError(f"speech must be int16 of shape (n,), not {samples.dtype} of shape {samples.shape}")
    words, pronunciations, guessed = _pronounced(transcript, lexicon)
    for attempt in (settings, replace(settings, padding=3 * settings.padding, noise=4 * settings.noise)):
        phones = _recognised(samples, words, pronunciations, attempt)
        phones = phones and _without_padding(phones, len(samples) / RATE)
        if phones:
            break
    else:
        raise RejectedUtterance(
            "the words of the transcript cannot be found in the sound",
            "Listen to it: correct the transcript to what is said, or leave the utterance out.",
        )
    return _assembled(phones, words, guessed)


def _pronounced(transcript: str, lexicon: Lexicon):
    words = lexicon.words(transcript)
    if not words:
        raise RejectedUtterance("the transcript is empty", "Write down what is said in the recording.")
    unknown = [word for word in dict.fromkeys(words) if word not in lexicon]
    found = lexicon.guess(unknown) if unknown else {}
    mute = [word for word in unknown if not found[word]]
    if mute:
        raise RejectedUtterance(
            f"no pronunciation for {', '.join(map(repr, mute))}", "Write the transcript in English words."
        )
    pronunciations = {word: found.get(word) or lexicon.pronunciations(word) for word in dict.fromkeys(words)}
    return words, pronunciations, tuple((word, found[word][0]) for word in unknown)


@dataclass(frozen=True)
class _Phone:
    """A recognised phone: index of its word (-1: a pause), label, and the borders of its states in seconds, (4,)."""

    word: int
    label: str
    borders: tuple[float, ...]


def _recognised(samples, words, pronunciations, settings) -> list[_Phone] | None:
    """Phones with times of the padded sound, or None where the decoder finds no way through."""
    from pocketsphinx import Decoder

    # A decoder costs some milliseconds without a language model and with the utterance's own words alone; it carries
    # nothing (adapted means, noise estimates, added words) from one utterance to the next. bestpath fails at times.
    decoder = Decoder(loglevel="FATAL", bestpath=False, lm=None, dict=None)
    names = {word: f"w{i}" for i, word in enumerate(pronunciations)}
    entries = [
        (names[word] if k == 0 else f"{names[word]}({k + 1})", " ".join(phones).upper())
        for word, many in pronunciations.items()
        for k, phones in enumerate(many)
    ]
    for k, (name, phones) in enumerate(entries):
        decoder.add_word(name, phones, k == len(entries) - 1)
    data = _padded(samples, settings).tobytes()
    try:
        decoder.set_align_text(" ".join(names[word] for word in words))
        _decode(decoder, data)
        decoder.set_alignment()
        _decode(decoder, data)
        # Flattened at once: the nested iterators do not outlive one another.
        tree = [
            (word.name, [(phone.name, [(state.start, state.duration) for state in phone]) for phone in word])
            for word in decoder.get_alignment()
        ]
    except RuntimeError:
        return None
    phones, index = [], -1
    for name, parts in tree:
        spoken = name.startswith("w")
        index += spoken
        for label, states in parts:
            frames = np.array([states[0][0], *(start + length for start, length in states)])
            borders = frames * _FRAME + settings.delay - settings.padding
            phones.append(_Phone(index if spoken else -1, label.lower() if spoken else SILENCE, tuple(borders)))
    return phones if index == len(words) - 1 else None


def _decode(decoder, data: bytes) -> None:
    decoder.start_utt()
    decoder.process_raw(data, full_utt=True)
    decoder.end_utt()


def _padded(samples: np.ndarray, settings: AlignmentSettings) -> np.ndarray:
    random = np.random.default_rng(0)
    noise = random.normal(0, settings.noise, (2, round(settings.padding * RATE)))
    before, after = np.round(noise).astype(np.int16)
    return np.concatenate([before, samples, after])


def _without_padding(phones: list[_Phone], duration: float) -> list[_Phone] | None:
    """Phones that follow each other from 0 to ``duration``, pauses joined and of three equal states.

    The borders inside a pause mean nothing, and joining and cutting pauses would leave some without all three states.
    None where a spoken state lies outside the sound.
    """
    joined: list[_Phone] = []
    for phone in phones:
        if joined and joined[-1].word == phone.word == -1:
            phone = _Phone(-1, SILENCE, (joined.pop().borders[0], phone.borders[-1]))
        joined.append(phone)
    cut = []
    for i, phone in enumerate(joined):
        borders = np.clip(phone.borders, 0.0, duration)
        borders[0] = 0.0 if i == 0 else borders[0]
        borders[-1] = duration if i == len(joined) - 1 else borders[-1]
        if phone.word == -1:
            if borders[0] == borders[-1]:
                continue
            borders = np.linspace(borders[0], borders[-1], STATES + 1)
        if np.any(np.diff(borders) <= 0):
            return None
        cut.append(_Phone(phone.word, phone.label, tuple(borders)))
    return cut


def _assembled(recognised: list[_Phone], spoken: list[str], guessed) -> Alignment:
    words: list[Segment] = []
    phones: list[Segment] = []
    states: list[Segment] = []
    previous = None
    for phone in recognised:
        start, *inner, end = (round(float(border), _DIGITS) for border in phone.borders)
        if phone.word == previous != -1:
            words[-1] = Segment(words[-1].label, words[-1].start, end)
        else:
            words.append(Segment(SILENCE if phone.word == -1 else spoken[phone.word], start, end))
        previous = phone.word
        borders = [start, *inner, end]
        states += [
            Segment(str(k + 1), *pair, len(phones)) for k, pair in enumerate(zip(borders, borders[1:], strict=False))
        ]
        phones.append(Segment(phone.label, start, end, len(words) - 1))
    return Alignment(tuple(words), tuple(phones), tuple(states), guessed)


def to_table(alignments: Mapping[str, Alignment]):
    """Alignments by utterance as a data frame: id, tier, index, parent, label, start, end (seconds)."""
    import pandas

    rows = [
        (name, tier, i, one.parent, one.label, one.start, one.end)
        for name, alignment in alignments.items()
        for tier in TIERS
        for i, one in enumerate(alignment.tier(tier))
    ]
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def from_table(table, utterance_id: str) -> Alignment:
    """The alignment of one utterance out of such a table.

    Raises
    ------
    DataError
        The table does not hold the utterance.
    """
    rows = table[table["id"] == utterance_id]
    if not len(rows):
        raise DataError(f"the alignment table holds no utterance {utterance_id}")
    return _of_rows(rows)


def read_alignments(path: str | Path) -> Iterator[tuple[str, Alignment]]:
    """Yield (utterance id, alignment) of a table file, in its order."""
    table = read_table(path, ("id", "tier", "label"))
    for name, rows in table.groupby("id", sort=False):
        yield str(name), _of_rows(rows)


def _of_rows(rows) -> Alignment:
    tiers = {
        tier: tuple(
            Segment(str(label), float(start), float(end), int(parent))
            for label, start, end, parent in part[["label", "start", "end", "parent"]].itertuples(index=False)
        )
        for tier, part in rows.groupby("tier", sort=False)
    }
    return Alignment(*(tiers[tier] for tier in TIERS))
