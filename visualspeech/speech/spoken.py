"""What a talking head says: sound, with its alignment.

For a text, the phone times are those of the synthesised voice, a by-product of the synthesis (Fan 2015, 4.1). The voice
gives phones and not the three HMM states that models are trained with, so each phone is divided among its states in
their average proportions in the alignment of the training data, or in thirds where these are not known; pauses are
always divided in thirds, as in the alignment. For a recording, the times are those of a forced alignment, or of
recognised phones where the transcript is not known.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from visualspeech.errors import SettingError
from visualspeech.media.reading import stream_audio
from visualspeech.speech import tts
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.forced_alignment import AlignmentSettings, pronounced
from visualspeech.speech.lexicon import Lexicon
from visualspeech.speech.phones import SILENCE, STATES
from visualspeech.speech.pieces import align_pieces, recognised_pieces
from visualspeech.speech.recognition import RATE, to_int16
from visualspeech.speech.sentences import split_sentences
from visualspeech.speech.spoken_settings import VoiceSettings

THIRDS = (1 / STATES,) * STATES
SOUND_RATE = 48000  # Hz, of the sound of a recording in a video


@dataclass(frozen=True)
class Spoken:
    """One utterance to be shown.

    Parameters
    ----------
    text : as written
    samples : (n,) float32 in [-1, 1], mono
    rate : samples a second
    alignment : words, phones and states over the whole of the sound
    """

    text: str
    samples: np.ndarray
    rate: int
    alignment: Alignment


def speak_text(
    text: str, settings: VoiceSettings | None = None, shares: Mapping[str, Iterable[float]] | None = None
) -> Iterator[Spoken]:
    """Speak a text sentence by sentence, with the silences between them; memory does not grow with the text.

    Parameters
    ----------
    text : as written
    shares : share of a phone's duration that each of its three states takes, by phone

    Raises
    ------
    SettingError
        There is no pronounceable word (before anything is spoken), or no such voice.
    """
    settings = settings or VoiceSettings()
    sentences = split_sentences(text)
    for number, sentence in enumerate(sentences):
        speech = tts.synthesise(sentence, settings.voice, settings.rate_wpm, settings.pitch)
        if all(phone == SILENCE for phone, _, _ in speech.phones):
            raise SettingError(f"there is no word to pronounce in {sentence!r}; give English words or numbers.")
        last = number == len(sentences) - 1
        # Half a pause on either side of a border: every sentence comes out of silence and goes into it, as in training.
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
) -> Iterator[Spoken]:
    """Recorded speech (a sound or video file) with its alignment, piece by piece.

    Without a transcript the phones are those that the decoder recognises. Memory does not grow with the duration. The
    first piece carries the whole transcript as its text; the text of the others is empty.

    Parameters
    ----------
    transcript : what is said; None where it is not known
    rate : frame rate of the video in Hz; pieces end at frame borders, so that they join without gaps
    shares : share of a phone's duration that each of its three states takes, by phone; used without a transcript

    Raises
    ------
    SettingError
        The transcript is empty (before anything is read).
    RejectedUtterance
        The file cannot be read, there is no speech in it, or the transcript is not what is said.
    """
    if transcript is not None and not transcript.strip():
        raise SettingError(f"the text of {path} is empty; give what is said in it, or leave --text out.")
    words = None if transcript is None else pronounced(transcript, lexicon or Lexicon())
    heard = (to_int16(part) for part in stream_audio(path, RATE))
    given, held, done, text = stream_audio(path, SOUND_RATE), np.zeros(0, np.float32), 0, transcript or ""
    if words is None:
        found = ((end, timed(phones, (), shares)) for end, phones in recognised_pieces(heard, rate, settings))
    else:
        found = align_pieces(heard, words, settings, rate)
    for end, alignment in found:
        count = round(round(end / RATE * rate) / rate * SOUND_RATE) - done
        while len(held) < count and (more := next(given, None)) is not None:
            held = np.concatenate([held, more])
        yield Spoken(text, held[:count], SOUND_RATE, alignment)
        held, done, text = held[count:], done + count, ""


def state_shares(alignments: Iterable[Alignment]) -> dict[str, tuple[float, ...]]:
    """Average share of a phone's duration that each of its three states takes, by phone; a third in pauses."""
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
        parts = THIRDS if phone == SILENCE else tuple((shares or {}).get(phone, THIRDS))
        borders = [start, *(start + (end - start) * np.cumsum(parts)[:-1]), end]
        tiers[2].extend(
            Segment(str(k + 1), float(a), float(b), len(tiers[1])) for k, (a, b) in enumerate(pairwise(borders))
        )
        tiers[1].append(Segment(phone, start, end, len(tiers[0]) - 1))
    return Alignment(*(tuple(tier) for tier in tiers))


def _with_silence(text: str, speech: tts.Speech, before: float, after: float, shares) -> Spoken:
    """The speech between two stretches of silence, which join with the pauses it has at its own ends."""
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
    if phones[0][0] == SILENCE:
        phones = [(SILENCE, 0.0, phones[0][2]), *phones[1:]]
    elif begin > 0:
        phones = [(SILENCE, 0.0, begin), *phones]
    if phones[-1][0] == SILENCE:
        return [*phones[:-1], (SILENCE, phones[-1][1], end)]
    return [*phones, (SILENCE, phones[-1][2], end)] if end > phones[-1][2] else phones
