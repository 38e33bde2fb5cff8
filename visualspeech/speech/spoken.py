"""The speech of a talking head: sound with its alignment.

For a text, phone times are a by-product of the speech synthesis (Fan 2015, 4.1). The synthesiser gives phones but not
the three HMM states that models are trained with. Each phone is therefore divided among its states in their average
proportions in the training alignments, or in thirds if these are not known; pauses are always divided in thirds, as in
the alignment. For a recording, times are those of a forced alignment, or of phone recognition if there is no
transcript. What is driven by sound alone needs neither: only pauses, by the level of the recording.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from visualspeech.errors import SettingError
from visualspeech.media.reading import stream_audio
from visualspeech.media.spooling import Spool
from visualspeech.speech import tts
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.forced_alignment import AlignmentSettings, pronounced
from visualspeech.speech.lexicon import Lexicon
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.speech.pieces import align_pieces, recognised_pieces
from visualspeech.speech.segmentation import alignment_of, pauses
from visualspeech.speech.sentences import split_sentences
from visualspeech.speech.sound import RATE, Sound, to_int16
from visualspeech.speech.spoken_settings import VoiceSettings

THIRDS = (1 / STATES,) * STATES
SOUND_RATE = 48000  # Hz, of the sound of a recording in a video
PIECE = 20.0  # seconds of a recording that are handed on at a time where nothing is aligned ...
BESIDE = 1.0  # ... and seconds beside them whose pauses are told, too


@dataclass(frozen=True)
class Spoken:
    """Speech to be shown, with its alignment.

    Parameters
    ----------
    text : as written
    samples : (n,) float32 in [-1, 1], mono
    rate : sample rate in Hz
    alignment : words, phones and states of the whole sound
    sound : the recording of which this is a part, for models that read sound; None: the samples are all of it
    begin : time in seconds in ``sound`` of the first sample
    """

    text: str
    samples: np.ndarray
    rate: int
    alignment: Alignment
    sound: Sound | None = None
    begin: float = 0.0


def speak_text(
    text: str,
    settings: VoiceSettings | None = None,
    shares: Mapping[str, Iterable[float]] | None = None,
    own: Callable[[str], Sequence[str]] | None = None,
) -> Iterator[Spoken]:
    """Speak a text sentence by sentence, with the silences between them; memory does not grow with the text.

    Parameters
    ----------
    text : as written
    shares : share of a phone's duration that each of its three states takes, by phone
    own : pronunciation of a word in the dictionary of the speaker, see :func:`visualspeech.speech.tts.synthesise`

    Raises
    ------
    SettingError
        There is no pronounceable word (raised before anything is spoken), or no such voice.
    """
    settings = settings or VoiceSettings()
    sentences = split_sentences(text)
    for number, sentence in enumerate(sentences):
        speech = tts.synthesise(sentence, settings.voice, settings.rate_wpm, settings.pitch, own)
        if all(phone == SILENCE for phone, _, _ in speech.phones):
            raise SettingError(f"there is no word to pronounce in {sentence!r}; give English words or numbers.")
        last = number == len(sentences) - 1
        # Each sentence gets half of the pause on either side: it begins and ends in silence, as in training.
        before = settings.leading_silence if number == 0 else settings.sentence_pause / 2
        yield _with_silence(
            sentence, speech, before, settings.trailing_silence if last else settings.sentence_pause / 2, shares or {}
        )


def speak_recording(
    path: str | Path,
    transcript: str | None,
    rate: float,
    lexicon: Lexicon | None = None,
    settings: AlignmentSettings | None = None,
    shares: Mapping[str, Iterable[float]] | None = None,
    with_sound: bool = False,
) -> Iterator[Spoken]:
    """Recorded speech (a sound or video file) with its alignment, piece by piece.

    Without a transcript, phones are recognised. Memory does not grow with the duration. The text of the first piece is
    the whole transcript; that of the others is empty.

    Parameters
    ----------
    transcript : what is said; None if it is not known
    rate : frame rate of the video in Hz; pieces end at frame borders, so that they join without gaps
    shares : share of a phone's duration that each of its three states takes, by phone; used without a transcript
    with_sound : whether models read the sound too, for which the file is read once more

    Raises
    ------
    SettingError
        The transcript is empty (raised before the file is read).
    RejectedUtterance
        The file cannot be read, there is no speech in it, or the transcript does not match it.
    """
    if transcript is not None and not transcript.strip():
        raise SettingError(f"the text of {path} is empty; give what is said in it, or leave --text out.")
    words = None if transcript is None else pronounced(transcript, lexicon or Lexicon())
    sound = spooled(path) if with_sound else None
    heard = (to_int16(block) for block in stream_audio(path, RATE))
    if words is None:
        found = ((end, timed(phones, (), shares)) for end, phones in recognised_pieces(heard, rate, settings))
    else:
        found = align_pieces(heard, words, settings, rate)
    yield from _played(path, found, rate, transcript or "", sound)


def speak_sound(path: str | Path, rate: float, text: str = "") -> Iterator[Spoken]:
    """Recorded speech for a model that reads sound alone, piece by piece: nothing is recognised or aligned.

    The alignment of a piece tells speech from pauses (:mod:`visualspeech.speech.segmentation`), some of them before and
    after the piece: a piece may begin and end anywhere. Memory does not grow with the duration.

    Parameters
    ----------
    rate : frame rate of the model in Hz; pieces end at frame borders
    text : what is said, if it is known; it is handed on with the first piece

    Raises
    ------
    RejectedUtterance
        The file cannot be read, is too short, or there is no speech in it.
    """
    sound = spooled(path)
    quiet, step = pauses(sound), max(1, round(PIECE * rate)) / rate
    ends = [*np.arange(step, sound.seconds - 0.5 / rate, step).tolist(), sound.seconds]
    found = (
        (
            round(end * RATE),
            alignment_of(quiet, max(0.0, begin - BESIDE), min(end + BESIDE, sound.seconds), begin),
        )
        for begin, end in zip([0.0, *ends], ends, strict=False)
    )
    yield from _played(path, found, rate, text, sound)


def spooled(path: str | Path) -> Sound:
    """The sound of a recording in a temporary file.

    Raises
    ------
    RejectedUtterance
        The file cannot be read.
    """
    samples = Spool(np.int16)
    for block in stream_audio(path, RATE):
        samples.append(to_int16(block))
    return Sound(samples)


def _played(
    path: str | Path, found: Iterable[tuple[int, Alignment]], rate: float, text: str, sound: Sound | None
) -> Iterator[Spoken]:
    """Pieces of a recording, each given by its last sample (exclusive) at 16 kHz, with the sound that is played."""
    given, held, done = stream_audio(path, SOUND_RATE), np.zeros(0, np.float32), 0
    for end, alignment in found:
        count = round(round(end / RATE * rate) / rate * SOUND_RATE) - done
        while len(held) < count and (more := next(given, None)) is not None:
            held = np.concatenate([held, more])
        yield Spoken(text, held[:count], SOUND_RATE, alignment, sound, done / SOUND_RATE)
        held, done, text = held[count:], done + count, ""


def state_shares(alignments: Iterable[Alignment]) -> dict[str, tuple[float, ...]]:
    """Average shares of a phone's duration that its three states take, by phone; thirds for pauses."""
    totals: dict[str, np.ndarray] = {}
    for alignment in alignments:
        for state in alignment.states:
            phone = alignment.phones[state.parent].label
            totals.setdefault(phone, np.zeros(STATES))[int(state.label) - 1] += state.end - state.start
    return {
        phone: THIRDS if phone == SILENCE else tuple((spent / spent.sum()).tolist())
        for phone, spent in sorted(totals.items())
        if spent.sum() > 0
    }


def timed(
    phones: Iterable[tuple[str, float, float]],
    words: Iterable[tuple[str, float, float]] = (),
    shares: Mapping[str, Iterable[float]] | None = None,
) -> Alignment:
    """An alignment from phones and words with times (label, start, end in seconds), with three states per phone.

    Phones follow each other without gaps from 0 s on; a phone belongs to the word in which its middle lies.
    """
    tiers: tuple[list[Segment], ...] = ([], [], [])
    spoken, before = list(words), None
    for phone, start, end in phones:
        middle = (start + end) / 2
        inside = (i for i, (_, a, b) in enumerate(spoken) if a <= middle < b)
        word = -1 if phone == SILENCE else next(inside, -2)
        if tiers[0] and word == before:
            tiers[0][-1] = Segment(tiers[0][-1].label, tiers[0][-1].start, end)
        else:
            tiers[0].append(Segment(spoken[word][0] if word >= 0 else SILENCE if word == -1 else "", start, end))
        before = word
        of_states = THIRDS if phone == SILENCE else tuple((shares or {}).get(phone, THIRDS))
        borders = [start, *(start + (end - start) * np.cumsum(of_states)[:-1]), end]
        tiers[2].extend(
            Segment(str(k + 1), float(a), float(b), len(tiers[1])) for k, (a, b) in enumerate(pairwise(borders))
        )
        tiers[1].append(Segment(phone, start, end, len(tiers[0]) - 1))
    return Alignment(*(tuple(tier) for tier in tiers))


def _with_silence(text: str, speech: tts.Speech, before: float, after: float, shares) -> Spoken:
    """The speech with silence before and after it, joined with the pauses at its own ends."""
    lead, tail = (round(seconds * speech.rate) for seconds in (before, after))
    length = len(speech.samples) + lead + tail
    samples = np.zeros(length, np.float32)
    samples[lead : length - tail] = speech.samples.astype(np.float32) / 32768
    moved = lead / speech.rate
    phones = [(label, start + moved, end + moved) for label, start, end in speech.phones]
    phones = _between(phones, moved, length / speech.rate)
    words = [(label, start + moved, end + moved) for label, start, end in speech.words]
    return Spoken(text, samples, speech.rate, timed(phones, words, shares))


def _between(phones: list[tuple[str, float, float]], begin: float, end: float) -> list[tuple[str, float, float]]:
    """Phones from 0 s to ``end`` with pauses where there are none at either end; speech begins at ``begin``."""
    if phones[0][0] == SILENCE:
        phones = [(SILENCE, 0.0, phones[0][2]), *phones[1:]]
    elif begin > 0:
        phones = [(SILENCE, 0.0, begin), *phones]
    if phones[-1][0] == SILENCE:
        return [*phones[:-1], (SILENCE, phones[-1][1], end)]
    return [*phones, (SILENCE, phones[-1][2], end)] if end > phones[-1][2] else phones
