"""Interface to PocketSphinx: from sound and words to timed and scored phones.

Every call creates its own decoder. Without a language model and with the words of the utterance only, that takes some
milliseconds. No state (adapted means, noise estimates, added words) is carried from one utterance to the next, so the
result depends neither on the order of the utterances nor on their shard.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from visualspeech.speech.phones import SILENCE

RATE = 16000  # Hz, of the acoustic model
STEP = 160  # samples from one frame to the next
WINDOW = 410  # samples of a frame
# Frame i begins at sample i * STEP and its middle is WINDOW / 2 later. The border between two frames lies midway
# between their middles, so the border that the decoder calls frame i is at sample i * STEP + DELAY.
DELAY = (WINDOW - STEP) / 2
BEAM = 1e-300  # probability ratio to the best path below which a path is pruned


@dataclass(frozen=True)
class RecognisedPhone:
    """A recognised phone.

    Parameters
    ----------
    word : index of its word, -1 for a pause or noise
    label : ARPAbet in lower case, or "sil"
    borders : of its states in seconds, ascending, from the phone's start to its end
    score : mean log score per frame relative to the best state of each frame, in the decoder's units
    """

    word: int
    label: str
    borders: tuple[float, ...]
    score: float

    @property
    def frames(self) -> int:
        """Number of frames."""
        return round((self.borders[-1] - self.borders[0]) * RATE / STEP)


def speech_part(samples: np.ndarray, level: float, margin: float) -> tuple[int, int]:
    """First and last sample (exclusive) of the speech, by loudness.

    The decoder aligns the first word too early where room noise or lip clicks precede it, so these are cut off.

    Parameters
    ----------
    samples : (n,) int16 at 16 kHz
    level : loudness threshold, as a share of the range in decibels (200 to 6800 Hz) from quiet (10th percentile) to
        loud (95th percentile) frames; levels are median-filtered over 90 ms
    margin : seconds that are kept before and after the speech
    """
    from scipy.ndimage import median_filter

    if len(samples) < WINDOW:
        return 0, len(samples)
    half = WINDOW // 2
    frames = np.lib.stride_tricks.sliding_window_view(np.pad(samples, half).astype(np.float32), WINDOW)[::STEP]
    decibels = np.empty(len(frames))
    for first in range(0, len(frames), 1000):  # a long recording is not unrolled at once
        power = np.abs(np.fft.rfft(frames[first : first + 1000] * np.hanning(WINDOW), 512)) ** 2
        band = slice(round(200 / RATE * 512), round(6800 / RATE * 512))
        decibels[first : first + 1000] = 10 * np.log10(power[:, band].sum(axis=1) + 100)
    decibels = median_filter(decibels, 9)
    quiet, loud = np.percentile(decibels, [10, 95])
    speech = np.flatnonzero(decibels >= quiet + level * (loud - quiet))
    kept = round(margin * RATE)
    return max(0, speech[0] * STEP - kept), min(len(samples), speech[-1] * STEP + kept)


def padded(samples: np.ndarray, padding: float, noise: float) -> np.ndarray:
    """Samples with ``padding`` seconds of noise of ``noise`` 16-bit steps (RMS) before and after; always the same."""
    random = np.random.default_rng(0)
    before, after = np.round(random.normal(0, noise, (2, round(padding * RATE)))).astype(np.int16)
    return np.concatenate([before, samples, after])


def recognise_words(
    samples: np.ndarray,
    words: Sequence[str],
    pronunciations: Mapping[str, Sequence[Sequence[str]]],
    pause: float,
) -> list[RecognisedPhone] | None:
    """Phones of given words in the sound, with optional pauses between words.

    Parameters
    ----------
    samples : (n,) int16 at 16 kHz
    words : in the order of the transcript
    pronunciations : of each word; the decoder chooses among them
    pause : probability of a pause between two words

    Returns
    -------
    phones with times from the first sample; None if the words do not fit into the sound
    """
    decoder, names = _of_words(pronunciations, pause)
    data = samples.tobytes()
    try:
        decoder.set_align_text(" ".join(names[word] for word in words))
        _decode(decoder, data)
        decoder.set_alignment()
        _decode(decoder, data)
        # Flattened at once: an inner iterator is valid only until the outer one advances.
        tree = [
            (word.name, [(phone.name, phone.score, [(s.start, s.duration) for s in phone]) for phone in word])
            for word in decoder.get_alignment()
        ]
    except RuntimeError:
        return None
    found, index = [], -1
    for name, phones in tree:
        spoken = name.startswith("w")
        index += spoken
        for label, score, states in phones:
            borders = [states[0][0], *(start + length for start, length in states)]
            frames = borders[-1] - borders[0]
            label = label.lower() if spoken else SILENCE
            found.append(RecognisedPhone(index if spoken else -1, label, _seconds(borders), score / frames))
    return found if index == len(words) - 1 else None


def recognise_beginning(
    samples: np.ndarray,
    words: Sequence[str],
    pronunciations: Mapping[str, Sequence[Sequence[str]]],
    pause: float,
) -> list[tuple[float, float]]:
    """Times of those of the given words that are said in a sound, which may end before the last word.

    Memory and time are proportional to the duration (2 s for 40 s of sound), because no state alignment is traced back.

    Parameters
    ----------
    samples, words, pronunciations, pause : as for :func:`recognise_words`

    Returns
    -------
    (start, end) in seconds of each word that is said, from the first on; the last few may be wrong if the sound ends
    within a word
    """
    decoder, names = _of_words(pronunciations, pause)
    count = len(words)
    chain = [(i, i + 1, 1.0, names[word]) for i, word in enumerate(words)]
    decoder.add_fsg(
        "words", decoder.create_fsg("words", 0, count + 1, chain + [(i, count + 1, 1.0) for i in range(count + 1)])
    )
    decoder.activate_search("words")
    try:
        _decode(decoder, samples.tobytes())
        found = [(segment.word, segment.start_frame, segment.end_frame + 1) for segment in decoder.seg()]
    except (RuntimeError, TypeError):  # no hypothesis at all
        return []
    return [_seconds((first, last)) for name, first, last in found if name.startswith("w")]


def recognise_phones(samples: np.ndarray) -> list[RecognisedPhone]:
    """Best sequence of phones for the sound by unconstrained phone recognition; empty if there is none."""
    decoder = _decoder()
    decoder.add_allphone_file("phones", None)
    decoder.activate_search("phones")
    try:
        _decode(decoder, samples.tobytes())
    except RuntimeError:
        return []
    logmath = decoder.logmath
    found = []
    for segment in decoder.seg():
        borders = (segment.start_frame, segment.end_frame + 1)
        spoken = segment.word.isalpha() and segment.word != "SIL"
        label = segment.word.lower() if spoken else SILENCE
        score = logmath.log(segment.ascore) / (borders[1] - borders[0])
        found.append(RecognisedPhone(0 if spoken else -1, label, _seconds(borders), score))
    return found


def _of_words(pronunciations: Mapping[str, Sequence[Sequence[str]]], pause: float):
    """A decoder that knows only the given words, and their names in it."""
    # With the default beams the search loses whole sentences of clear speech.
    decoder = _decoder(beam=BEAM, pbeam=BEAM, wbeam=BEAM, silprob=pause)
    names = {word: f"w{i}" for i, word in enumerate(pronunciations)}
    entries = [
        (names[word] if k == 0 else f"{names[word]}({k + 1})", " ".join(phones).upper())
        for word, many in pronunciations.items()
        for k, phones in enumerate(many)
    ]
    for k, (name, phones) in enumerate(entries):
        decoder.add_word(name, phones, k == len(entries) - 1)
    return decoder, names


def _decoder(**options):
    from pocketsphinx import Decoder

    # With bestpath some utterances fail with "Failed to stop utterance processing"; compallsen makes scores comparable.
    return Decoder(loglevel="FATAL", bestpath=False, compallsen=True, lm=None, dict=None, **options)


def _decode(decoder, data: bytes) -> None:
    decoder.start_utt()
    decoder.process_raw(data, full_utt=True)
    decoder.end_utt()


def _seconds(frames: Sequence[int]) -> tuple[float, ...]:
    return tuple((frame * STEP + DELAY) / RATE for frame in frames)
