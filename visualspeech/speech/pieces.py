"""Alignment of recordings of any duration, in pieces that end at pauses of the speaker.

The memory of a forced alignment grows with the square of the duration, and networks are trained on sentences. The
decoder therefore finds how many of the remaining words are said in a window of the sound. The window is cut at the
longest pause well inside it, where the words on both sides are certain, and the piece before the cut is aligned like a
recording of its own.
"""

from collections.abc import Iterable, Iterator

import numpy as np

from visualspeech.errors import RejectedUtterance
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.forced_alignment import (
    CHECK,
    LISTEN,
    MIN_SPEECH,
    NO_SPEECH,
    TOO_SHORT,
    AlignmentSettings,
    Pronounced,
    align_words,
    has_speech,
)
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.speech.recognition import RATE, padded, recognise_beginning, recognise_phones, speech_part

WINDOW = 40.0  # seconds; a shorter recording is one piece
_FIRST, _LAST = 8.0, 32.0  # seconds from the start of a window; earliest and latest cut
_FASTEST = 7.0  # words per second
_PAUSE = 0.15  # seconds; shorter pauses may be the closure of a stop
MIN_SECONDS = 0.2  # of a recording without a transcript
MIN_LEVEL_RANGE = 3.0  # dB; sound of a steadier level is noise
_LAST_WORDS = 2  # number of uncertain words at the end of a window, unless ...
_ENDED = 3.0  # ... this many seconds of silence follow them


def align_pieces(
    sound: Iterable[np.ndarray], spoken: Pronounced, settings: AlignmentSettings | None = None, rate: float = 100.0
) -> Iterator[tuple[int, Alignment]]:
    """Align a recording piece by piece; memory does not grow with its duration.

    Parameters
    ----------
    sound : consecutive blocks of samples, int16, mono, 16 kHz
    spoken : all words of the transcript
    rate : frame rate in Hz; pieces end at frame borders

    Yields
    ------
    for each piece its last sample (exclusive) in the recording, and its alignment, with times from its start

    Raises
    ------
    RejectedUtterance
        The words do not match the sound; for a recording of several pieces the reason names the time of the piece.
    """
    settings, held = settings or AlignmentSettings(), _Held(sound)
    word = 0  # number of the first word that is not aligned yet
    while True:
        last, samples, begin = held.fill(), held.samples, held.begin
        length, words = len(samples), spoken.slice(word, len(spoken.words))
        if not last:
            window = samples[: round(WINDOW * RATE)]
            words = spoken.slice(word, word + round(_FASTEST * WINDOW))
            until, count = _cut(recognise(window, words, settings))
            length = _at_border(begin, until, rate)
            words = words.slice(0, count)
        try:
            alignment = _aligned(samples[:length], words, settings)
        except RejectedUtterance as error:
            if last and not begin:
                raise
            if error.reason == NO_SPEECH and not last:
                words, alignment = words.slice(0, 0), _silence(length)
            else:
                position = f"from {_clock(begin)} to {_clock(begin + length)}"
                reason = error.reason
                if last and reason in (NO_SPEECH, TOO_SHORT):
                    reason = f"the last {len(words.words)} words of the text, from {words.words[0]!r} on, are not said"
                raise RejectedUtterance(f"{position}: {reason}", LISTEN) from error
        yield begin + length, alignment
        if last:
            return
        held.drop(length)
        word += len(words.words)


def recognised_pieces(
    sound: Iterable[np.ndarray], rate: float = 100.0, settings: AlignmentSettings | None = None
) -> Iterator[tuple[int, list[tuple[str, float, float]]]]:
    """Phones of a recording without a transcript, piece by piece, by unconstrained phone recognition.

    Parameters
    ----------
    sound, rate : see :func:`align_pieces`

    Yields
    ------
    for each piece its last sample (exclusive) in the recording, and its phones (label, start, end) in seconds from its
    start, without gaps

    Raises
    ------
    RejectedUtterance
        There is no speech in the recording.
    """
    settings, held, heard = settings or AlignmentSettings(), _Held(sound), 0.0
    while True:
        last, begin = held.fill(), held.begin
        window = held.samples[: round(WINDOW * RATE)]
        length, phones = len(window), _phones(window, settings)
        if not last:
            borders = [(start, end) for label, start, end in phones if label == SILENCE]
            spans = np.clip(np.array(borders).reshape(-1, 2), _FIRST, _LAST)
            longest = spans[np.argmax(spans[:, 1] - spans[:, 0])] if len(spans) else (_LAST, _LAST)
            length = _at_border(begin, float(np.mean(longest)) if longest[1] > longest[0] else _LAST, rate)
            until = length / RATE
            phones = [(label, start, min(end, until)) for label, start, end in phones if start < until]
        heard += sum(end - start for label, start, end in phones if label != SILENCE)
        if last and begin + length < MIN_SECONDS * RATE:
            raise RejectedUtterance(
                f"only {(begin + length) / RATE:.3f} s of sound, too short for speech", "Give a longer recording."
            )
        if last and heard < MIN_SPEECH * (begin + length) / RATE:
            raise RejectedUtterance(NO_SPEECH, CHECK)
        yield begin + length, phones
        if last:
            return
        held.drop(length)


def _phones(samples: np.ndarray, settings: AlignmentSettings) -> list[tuple[str, float, float]]:
    """Recognised phones (label, start, end), from the first sample to the last."""
    seconds = len(samples) / RATE
    if _level_range(samples) < MIN_LEVEL_RANGE:
        return [(SILENCE, 0.0, seconds)]
    moved = round(settings.padding * RATE) / RATE
    found = [
        (one.label, np.clip(one.borders[0] - moved, 0, seconds), np.clip(one.borders[-1] - moved, 0, seconds))
        for one in recognise_phones(padded(samples, settings.padding, settings.padding_noise))
    ]
    found = [one for one in found if one[2] > one[1]] or [(SILENCE, 0.0, seconds)]
    starts = [0.0, *(float(start) for _, start, _ in found[1:]), seconds]
    joined: list[tuple[str, float, float]] = []
    for (label, _, _), start, end in zip(found, starts, starts[1:], strict=False):
        if joined and label == joined[-1][0] == SILENCE:
            start = joined.pop()[1]
        joined.append((label, start, end))
    return joined


def _level_range(samples: np.ndarray) -> float:
    """Range in dB from quiet to loud 20 ms of samples; below 2 for steady noise, far above it for speech."""
    frames = samples[: len(samples) // 320 * 320].reshape(-1, 320).astype(np.float64)
    levels = 10 * np.log10(np.maximum((frames**2).mean(axis=1), 1e-3))
    return float(np.subtract(*np.percentile(levels, [95, 10]))) if len(levels) else 0.0


class _Held:
    """The part of the sound that is held in memory: one window and at most one more block."""

    def __init__(self, sound: Iterable[np.ndarray]) -> None:
        self._sound = iter(sound)
        self.samples = np.zeros(0, np.int16)
        self.begin = 0  # position of its first sample in the recording

    def fill(self) -> bool:
        """Read until more than a window is held; returns whether the recording has ended before."""
        while len(self.samples) <= WINDOW * RATE:
            more = next(self._sound, None)
            if more is None:
                return True
            self.samples = np.concatenate([self.samples, more])
        return False

    def drop(self, count: int) -> None:
        self.samples, self.begin = self.samples[count:], self.begin + count


def _at_border(begin: int, seconds: float, rate: float) -> int:
    """Number of samples from ``begin`` to the frame border nearest to ``seconds`` after it."""
    return round(round((begin / RATE + seconds) * rate) / rate * RATE) - begin


def recognise(window: np.ndarray, words: Pronounced, settings: AlignmentSettings) -> list[tuple[float, float]]:
    """(start, end) in seconds of the words that are said in a window, see :func:`recognise_beginning`."""
    if not words.words or not np.any(window):
        return []
    # The decoder places words into a long silence before them, and fails on digital silence.
    first, _ = speech_part(window, settings.speech_threshold, settings.speech_margin)
    noise = np.random.default_rng(0).normal(0, settings.padding_noise, len(window))
    window = np.clip(window + np.rint(noise), -32768, 32767).astype(np.int16)
    sound = padded(window[first:], settings.padding, settings.padding_noise)[: -max(1, round(settings.padding * RATE))]
    found = recognise_beginning(sound, words.words, words.pronunciations, settings.pause_probability)
    moved = first / RATE - settings.padding
    return [(start + moved, end + moved) for start, end in found]


def _cut(words: list[tuple[float, float]]) -> tuple[float, int]:
    """Where to cut a window, in seconds, and the number of words before the cut."""
    if not words:
        return _LAST, 0
    times = np.array(words)
    # Gap k is before word k; the gap after the last word is certain only where the silence is long.
    ends, starts = np.r_[0.0, times[:, 1]], np.r_[times[:, 0], WINDOW]
    certain = len(starts) if starts[-1] - ends[-1] >= _ENDED else max(1, len(words) - _LAST_WORDS + 1)
    ends, starts = ends[:certain], starts[:certain]
    first, last = np.clip(ends, _FIRST, _LAST), np.clip(starts, _FIRST, _LAST)
    best = int(np.argmax(last - first))
    if last[best] - first[best] < _PAUSE:
        # Without a pause the cut is between two words, as late as possible.
        best = int(np.argmax(np.where(starts <= _LAST, starts, -1)))
        return float(starts[best]), best
    return float(first[best] + last[best]) / 2, best


def _aligned(samples: np.ndarray, words: Pronounced, settings: AlignmentSettings) -> Alignment:
    if words.words:
        if not np.any(samples):
            raise RejectedUtterance(NO_SPEECH, CHECK)
        return align_words(samples, words, settings)
    if has_speech(samples):
        raise RejectedUtterance("there is speech that is not in the transcript", LISTEN)
    return _silence(len(samples))


def _silence(length: int) -> Alignment:
    """Alignment of ``length`` samples without speech."""
    seconds = length / RATE
    borders = np.linspace(0, seconds, STATES + 1).tolist()
    states = tuple(Segment(str(k + 1), borders[k], borders[k + 1], 0) for k in range(STATES))
    return Alignment((Segment(SILENCE, 0.0, seconds),), (Segment(SILENCE, 0.0, seconds, 0),), states)


def _clock(sample: int) -> str:
    seconds = sample / RATE
    return f"{int(seconds // 60)}:{seconds % 60:04.1f}"
