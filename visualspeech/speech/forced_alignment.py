"""Forced alignment: the words, phones and HMM states of an utterance with their times (PocketSphinx, 100 Hz)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from visualspeech.errors import DataError, RejectedUtterance
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.speech.lexicon import Lexicon, Pronunciation
from visualspeech.speech.phones import CLASSES, SILENCE, STATES
from visualspeech.speech.recognition import (
    RATE,
    STEP,
    RecognisedPhone,
    padded,
    recognise_phones,
    recognise_words,
    speech_part,
)
from visualspeech.speech.sound import to_int16

NO_SPEECH = "there is no speech in the sound"
TOO_SHORT = "the words of the transcript do not fit into the sound"
CHECK = "Check the microphone and the sound track of the recording."
LISTEN = "Listen to it: correct the transcript to what is said, or leave the utterance out."
MAX_DURATION = 120.0  # seconds; the memory of the search grows with the square of the duration (0.5 GB here)
MIN_SPEECH = 0.1  # minimum share of the frames that are recognised as phones, pauses and noise apart
_MAX_PEAK = 2.0  # of floating-point samples; resampling overshoots 1 a little, 16-bit steps exceed it by far
_MIN_STATE = 0.002  # seconds; minimum duration of a state at the beginning or end of the sound
_MAX_OUTSIDE = 0.05  # seconds; how much of the first and last phone may lie outside the sound
_DIGITS = 5  # decimal places of times in seconds


class Aligner:
    """Aligns utterances with one lexicon; each has a decoder of its own, so results do not depend on their order."""

    def __init__(self, settings: AlignmentSettings | None = None, lexicon: Lexicon | None = None) -> None:
        self.settings = settings or AlignmentSettings()
        self.lexicon = lexicon or Lexicon()

    def align(self, sound: str | Path | np.ndarray, transcript: str) -> Alignment:
        """Align one utterance, see :func:`align`."""
        return align(sound, transcript, self.lexicon, self.settings)


def align(
    sound: str | Path | np.ndarray,
    transcript: str,
    lexicon: Lexicon | None = None,
    settings: AlignmentSettings | None = None,
) -> Alignment:
    """Align the speech of one utterance with its transcript.

    Parameters
    ----------
    sound : path of a recording (sound or video), or its samples (n,), mono, 16 kHz: int16, or floating-point in [-1, 1]
    transcript : as written

    Raises
    ------
    RejectedUtterance
        The recording cannot be read, there is no speech, a word cannot be pronounced, or the transcript is not what is
        said.
    DataError
        The samples are of another type or shape, or out of range.
    """
    settings = settings or AlignmentSettings()
    samples = _samples(sound)
    if len(samples) > MAX_DURATION * RATE:
        raise RejectedUtterance(
            f"{len(samples) / RATE:.0f} s are too long for one utterance (limit {MAX_DURATION:.0f} s)",
            "Cut it into sentences: files of their own, or rows of a table with start and end.",
        )
    if not np.any(samples):
        raise RejectedUtterance(NO_SPEECH, CHECK)
    return align_words(samples, pronounced(transcript, lexicon or Lexicon()), settings)


def _samples(sound: str | Path | np.ndarray) -> np.ndarray:
    """Samples (n,) int16, mono, 16 kHz, of a recording; see :func:`align`."""
    if isinstance(sound, str | Path):
        from visualspeech.media.reading import read_audio

        return to_int16(read_audio(sound, RATE))
    samples = np.ascontiguousarray(sound)
    floating = np.issubdtype(samples.dtype, np.floating)
    if samples.ndim != 1 or not (floating or samples.dtype == np.int16):
        raise DataError(
            f"the samples are {samples.dtype} of shape {samples.shape}; give int16, or floating-point in [-1, 1], of "
            "shape (n,), mono, 16 kHz."
        )
    if not floating:
        return samples
    if not np.abs(samples).max(initial=0) <= _MAX_PEAK:
        raise DataError("floating-point samples must lie in [-1, 1]; divide them by their full scale.")
    return to_int16(samples)


@dataclass(frozen=True)
class Pronounced:
    """Words of a transcript with their pronunciations.

    Parameters
    ----------
    words : in the order of the transcript, in lower case
    pronunciations : of each word
    guessed : (word, pronunciation) of each word that the dictionary does not list
    """

    words: tuple[str, ...]
    pronunciations: Mapping[str, tuple[Pronunciation, ...]]
    guessed: tuple[tuple[str, Pronunciation], ...] = ()

    def slice(self, first: int, last: int) -> "Pronounced":
        """The words from number ``first`` to ``last`` (exclusive)."""
        words = self.words[first:last]
        pronunciations = {word: self.pronunciations[word] for word in dict.fromkeys(words)}
        return Pronounced(words, pronunciations, tuple(pair for pair in self.guessed if pair[0] in pronunciations))


def align_words(samples: np.ndarray, spoken: Pronounced, settings: AlignmentSettings) -> Alignment:
    """Align the samples (n,) of one utterance, int16, mono, 16 kHz, with its words, see :func:`align`."""
    start, end = speech_part(samples, settings.speech_threshold, settings.speech_margin)
    words = list(spoken.words)
    # The second attempt covers the whole sound, in case speech below the loudness threshold was cut off.
    for first, last, padding in ((start, end, settings.padding), (0, len(samples), 2 * settings.padding)):
        sound = padded(samples[first:last], padding, settings.padding_noise)
        phones = recognise_words(sound, words, spoken.pronunciations, settings.pause_probability)
        rejection = _rejection(phones, sound, words, settings)
        if rejection is None:
            phones = _without_closures(_moved(phones, first / RATE - round(padding * RATE) / RATE), settings)
            phones = _placed(phones, len(samples) / RATE)
            if phones is not None:
                return _assembled(phones, words, spoken.guessed)
            rejection = RejectedUtterance(TOO_SHORT, LISTEN)
    raise rejection


def _rejection(phones, sound, words, settings) -> RejectedUtterance | None:
    """Why these phones are not accepted as the alignment of the sound; None where they are."""
    free = recognise_phones(sound)
    if _frames_of_speech(free) < MIN_SPEECH * len(sound) / STEP:
        return RejectedUtterance(NO_SPEECH, CHECK)
    if phones is None:
        return RejectedUtterance(TOO_SHORT, LISTEN)
    spoken = [phone for phone in phones if phone.word != -1]
    shortest = np.mean([phone.frames <= STATES for phone in spoken])
    overall, each = mismatch(phones, free)
    worst = int(np.argmax(each))
    if overall > settings.max_mismatch or shortest > settings.max_short_phone_share:
        return RejectedUtterance(
            f"the transcript is not what is said (mismatch {overall:.0f}, limit {settings.max_mismatch:g}; "
            f"{shortest:.0%} of its phones are too short, limit {settings.max_short_phone_share:.0%})",
            LISTEN,
        )
    if each[worst] > settings.max_word_mismatch:
        return RejectedUtterance(
            f"the word {words[worst]!r} of the transcript is not said "
            f"(mismatch {each[worst]:.0f}, limit {settings.max_word_mismatch:g})",
            LISTEN,
        )
    missing = [word for word, value in zip(words, each, strict=True) if value > settings.word_mismatch_threshold]
    if len(missing) >= max(2, settings.rejected_word_share * len(words)):
        return RejectedUtterance(
            f"the transcript is not what is said: {len(missing)} of {len(words)} words do not match the sound, "
            f"{_listed(missing)} (mismatch above {settings.word_mismatch_threshold:g}, limit "
            f"{settings.rejected_word_share:.0%} of the words)",
            LISTEN,
        )
    return None


def _listed(words: list[str], most: int = 5) -> str:
    """Words for a message: at most ``most`` of them."""
    return ", ".join(map(repr, words[:most])) + " ..." * (len(words) > most)


def has_speech(samples: np.ndarray) -> bool:
    """Whether enough of the samples (n,), int16, mono, 16 kHz, is recognised as phones."""
    return bool(np.any(samples)) and _frames_of_speech(recognise_phones(samples)) >= MIN_SPEECH * len(samples) / STEP


def _frames_of_speech(free: list[RecognisedPhone]) -> int:
    return sum(phone.frames for phone in free if phone.word != -1)


def mismatch(phones: list[RecognisedPhone], free: list[RecognisedPhone]) -> tuple[float, np.ndarray]:
    """How much better an unconstrained sequence of phones scores on a sound than the phones of the transcript.

    Parameters
    ----------
    phones : recognised with the transcript
    free : recognised in the same sound without the transcript

    Returns
    -------
    difference of the log scores of the whole sound per frame of speech, and the mean difference per frame of each word
    """
    given, best = _frame_scores(phones), _frame_scores(free)
    length = min(len(given), len(best))
    difference = best[:length] - given[:length]
    words = np.repeat([phone.word for phone in phones], [phone.frames for phone in phones])[:length]
    each = [difference[words == k].mean() for k in range(max(words) + 1)]
    return float(difference.sum() / np.sum(words != -1)), np.array(each)


def _frame_scores(phones: list[RecognisedPhone]) -> np.ndarray:
    return np.repeat([phone.score for phone in phones], [phone.frames for phone in phones])


def pronounced(transcript: str, lexicon: Lexicon) -> Pronounced:
    """Words of a transcript with their pronunciations.

    Raises
    ------
    RejectedUtterance
        The transcript holds no word, or a word that cannot be pronounced.
    """
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
    return Pronounced(tuple(words), pronunciations, tuple((word, found[word][0]) for word in unknown))


def _moved(phones: list[RecognisedPhone], shift: float) -> list[RecognisedPhone]:
    """Phones moved by ``shift`` seconds, with adjacent pauses joined."""
    moved: list[RecognisedPhone] = []
    for phone in phones:
        borders = tuple(border + shift for border in phone.borders)
        if moved and moved[-1].word == phone.word == -1:
            borders = (moved.pop().borders[0], borders[-1])
        moved.append(replace(phone, borders=borders))
    return moved


def _without_closures(phones: list[RecognisedPhone], settings: AlignmentSettings) -> list[RecognisedPhone]:
    """Join pauses that are too short to the stop after them, whose closure they are, or to the word before."""
    kept = list(phones)
    for i in range(len(phones) - 2, 0, -1):
        start, end = phones[i].borders[0], phones[i].borders[-1]
        if phones[i].word != -1 or end - start >= settings.min_pause:
            continue
        if kept[i + 1].label in CLASSES["stop"] | CLASSES["affricate"]:
            kept[i + 1] = replace(kept[i + 1], borders=(start, *kept[i + 1].borders[1:]))
        else:
            kept[i - 1] = replace(kept[i - 1], borders=(*kept[i - 1].borders[:-1], end))
        del kept[i]
    return kept


def _placed(phones: list[RecognisedPhone], duration: float) -> list[RecognisedPhone] | None:
    """Phones that cover 0 s to ``duration`` without gaps; the three states of a pause are equally long.

    The borders inside a pause mean nothing, and joining and cutting pauses would leave some without all three states.
    The closure of a stop that opens a recording may reach into the padding: its states keep ``_MIN_STATE`` seconds.
    None where more than ``_MAX_OUTSIDE`` seconds of the first or last phone lie outside the sound.
    """
    inside = [one for one in phones if one.word != -1 or (one.borders[-1] > 0 and one.borders[0] < duration)]
    flat = np.array([*(border for phone in inside for border in phone.borders[:-1]), inside[-1].borders[-1]])
    if inside[0].borders[-1] < -_MAX_OUTSIDE or inside[-1].borders[0] > duration + _MAX_OUTSIDE:
        return None
    least = _MIN_STATE * np.arange(len(flat))
    if least[-1] > duration:
        return None
    flat = np.clip(flat, least, duration - least[::-1])
    flat[0], flat[-1] = 0.0, duration
    cut, first = [], 0
    for phone in inside:
        last = first + len(phone.borders) - 1
        pause = phone.word == -1
        borders = np.linspace(flat[first], flat[last], STATES + 1) if pause else flat[first : last + 1]
        cut.append(replace(phone, borders=tuple(borders.tolist())))
        first = last
    return cut


def _assembled(recognised: list[RecognisedPhone], spoken: list[str], guessed) -> Alignment:
    words: list[Segment] = []
    phones: list[Segment] = []
    states: list[Segment] = []
    previous = None
    for phone in recognised:
        start, *inner, end = (round(border, _DIGITS) for border in phone.borders)
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
