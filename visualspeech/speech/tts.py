"""Speech synthesis and letter-to-sound rules, through eSpeak NG.

Phones are ARPAbet in lower case without stress digits, as in the alignment. Every call runs in its own process (see
:mod:`visualspeech.speech.espeak`), so the same text gives the same samples.
"""

import json
import re
import subprocess
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from visualspeech.errors import SettingError, VisualSpeechError
from visualspeech.speech import espeak, mnemonics
from visualspeech.speech.phones import SILENCE

VOICE = "en-us"
VOICE_NAME = r"[A-Za-z0-9][A-Za-z0-9/+_-]*"  # of any voice or variant

# Mnemonics of eSpeak NG's American voice. An "r" after a vowel that ends in "r" is not repeated: see _merge.
_ARPABET = {
    **{
        "p": "p",
        "b": "b",
        "t": "t",
        "t#": "t",
        "t2": "t",
        "?": "t",
        "d": "d",
        "d#": "d",
        "k": "k",
        "g": "g",
        "tS": "ch",
    },
    **{"dZ": "jh", "f": "f", "v": "v", "T": "th", "D": "dh", "s": "s", "z": "z", "S": "sh", "Z": "zh", "h": "hh"},
    **{
        "m": "m",
        "n": "n",
        "N": "ng",
        "l": "l",
        "l#": "l",
        "r": "r",
        "r-": "r",
        "w": "w",
        "w#": "w",
        "j": "y",
        "x": "k",
    },
    **{"n-": "ah n", "@L": "ah l", "m-": "ah m", "C": "k"},
    **{
        "I": "ih",
        "I2": "ih",
        "I#": "ih",
        "i": "iy",
        "i:": "iy",
        "E": "eh",
        "E2": "eh",
        "a": "ae",
        "aa": "ae",
        "a#": "ah",
    },
    **{
        "A:": "aa",
        "A": "aa",
        "A#": "aa",
        "0": "aa",
        "0#": "aa",
        "O": "ao",
        "O:": "ao",
        "O2": "ao",
        "V": "ah",
        "@": "ah",
    },
    **{
        "@2": "ah",
        "@5": "ah",
        "@-": "ah",
        "U": "uh",
        "U2": "uh",
        "u": "uw",
        "u:": "uw",
        "3": "er",
        "3:": "er",
        "@r": "er",
    },
    **{"eI": "ey", "aI": "ay", "OI": "oy", "aU": "aw", "oU": "ow", "aI@": "ay ah", "aI3": "ay er", "aU@": "aw ah"},
    **{
        "A@": "aa r",
        "O@": "ao r",
        "o@": "ao r",
        "U@": "uh r",
        "e@": "eh r",
        "i@3": "ih r",
        "i@": "iy ah",
        "A~": "aa n",
    },
}
_PAUSES = ("_", "_:", "_|", "_!", "_^_", "_::")
_IGNORED = (";", "_", "", ":")
_STOPS = ("p", "b", "t", "d", "k", "g", "ch", "jh")


@dataclass(frozen=True)
class Speech:
    """Synthetic speech with its true times.

    Parameters
    ----------
    samples : (n,) int16, mono
    rate : sample rate in Hz
    words : (word, start, end) in seconds
    phones : (ARPAbet, start, end) in seconds, without gaps from 0 to the end; pauses are "sil"
    """

    samples: np.ndarray
    rate: int
    words: tuple[tuple[str, float, float], ...]
    phones: tuple[tuple[str, float, float], ...]


def synthesise(
    text: str,
    voice: str = VOICE,
    rate_wpm: int = 160,
    pitch: int = 45,
    own: Callable[[str], Sequence[str]] | None = None,
) -> Speech:
    """Synthetic speech of a text.

    Parameters
    ----------
    text : what to say, as written
    voice : name of a voice of eSpeak NG
    rate_wpm : words per minute, 80 to 450
    pitch : 0 (low) to 100 (high)
    own : function of a word: its pronunciation in a dictionary of one's own, ARPAbet with or without stress digits;
        empty for words that the voice pronounces by its rules

    Raises
    ------
    SettingError
        The text has no word, there is no such voice, or the speed or pitch is out of range.
    VisualSpeechError
        The synthesiser failed.
    """
    if not re.search(r"\w", text):
        raise SettingError("there is nothing to say: the text has no word. Give a sentence.")
    if not 80 <= rate_wpm <= 450:
        raise SettingError(f"rate_wpm is {rate_wpm}; give a speed between 80 and 450 words per minute.")
    if not 0 <= pitch <= 100:
        raise SettingError(f"pitch is {pitch}; give a number between 0 and 100.")
    request = {"say": text, "voice": voice, "rate": int(rate_wpm), "pitch": int(pitch)}
    spelt = mnemonics.with_own(text, own) if own else None
    answer, data = _ask(request if spelt is None else {**request, "say": spelt.text, "phonemes": True})
    samples = np.frombuffer(data, "<i2").astype(np.int16)
    if not len(samples):
        raise VisualSpeechError(f"the speech synthesiser gave no sound for {text!r}. Reword the sentence.")
    events = answer["events"] if spelt is None else spelt.located(answer["events"])
    return Speech(samples, answer["rate"], *_timed(text, voice, events, samples, answer["rate"]))


def letter_to_sound(word: str, voice: str = VOICE) -> list[str]:
    """Pronunciation of a word by letter-to-sound rules, in ARPAbet in lower case without stress; may be empty."""
    return list(letters_to_sounds((word,), voice)[word])


def letters_to_sounds(words: Iterable[str], voice: str = VOICE) -> dict[str, list[str]]:
    """Pronunciations of several words by letter-to-sound rules, by word; one process for all of them."""
    words = tuple(dict.fromkeys(words))
    return {word: list(phones) for word, phones in zip(words, _pronounced(words, voice), strict=True)}


@lru_cache(maxsize=4096)
def _pronounced(words: tuple[str, ...], voice: str) -> tuple[tuple[str, ...], ...]:
    spoken = [re.sub(r"[^\w' -]", " ", word.lower()).strip() for word in words]
    answer, _ = _ask({"pronounce": spoken, "voice": voice})
    return tuple(_without_double_r(_merge([(name, i) for i, name in enumerate(m)])) for m in answer["pronounced"])


def stresses(words: Iterable[str], voice: str = VOICE) -> dict[str, list[int]]:
    """Stress of the vowels of several words, by word: 0 none, 1 secondary, 2 primary; one process for all of them."""
    words = tuple(dict.fromkeys(words))
    return {word: list(marks) for word, marks in zip(words, _stressed(words, voice), strict=True)} if words else {}


@lru_cache(maxsize=4096)
def _stressed(words: tuple[str, ...], voice: str) -> tuple[tuple[int, ...], ...]:
    spoken = [re.sub(r"[^\w' -]", " ", word.lower()).strip() for word in words]
    answer, _ = _ask({"pronounce": spoken, "voice": voice, "marks": True})
    return tuple(_marks(mnemonics) for mnemonics in answer["pronounced"])


def _marks(mnemonics: list[str]) -> tuple[int, ...]:
    """Stress of each vowel; in a mnemonic of two vowels ("aI@") the first one is stressed."""
    found = []
    for name in mnemonics:
        mark = {"'": 2, ",": 1}.get(name[0], 0)
        # In ARPAbet all vowels and no consonants begin with one of these letters.
        vowels = [phone for phone in _phones_of(name.strip(espeak.STRESS_MARKS)) if phone[0] in "aeiou"]
        found += [mark, *[0] * (len(vowels) - 1)] if vowels else []
    return tuple(found)


def _without_double_r(phones: list[tuple[str, float]]) -> tuple[str, ...]:
    """Phones without an "r" after "er": inside a word, dictionaries write "er" where the voice has "er r"."""
    names = [phone for phone, _ in phones]
    return tuple(name for i, name in enumerate(names) if not (name == "r" and i and names[i - 1] == "er"))


def _ask(request: dict) -> tuple[dict, bytes]:
    process = subprocess.run(  # a list of arguments, no shell
        [sys.executable, "-P", espeak.__file__], input=json.dumps(request).encode(), capture_output=True, check=False
    )
    if process.returncode == 2:
        raise SettingError(f"speech synthesis: {process.stderr.decode('utf-8', 'replace').strip()}.")
    line, _, data = process.stdout.partition(b"\n")
    if process.returncode != 0 or not line:
        raise VisualSpeechError(
            f"the speech synthesiser ended with status {process.returncode}: "
            f"{process.stderr.decode('utf-8', 'replace').strip()[-300:]}. Check that espeakng-loader is installed."
        )
    return json.loads(line), data


def _merge(events: list[tuple[str, float]]) -> list[tuple[str, float]]:
    """Phones with onsets from mnemonics with onsets.

    Mnemonics of two phones are split; the second phone begins 60 % of the way to the next event. A repeated "r" and
    marks without duration are dropped.
    """
    merged: list[tuple[str, float]] = []
    for i, (name, onset) in enumerate(events):
        if name in _PAUSES:
            merged.append((SILENCE, onset))
            continue
        phones = _phones_of(name)
        following = events[i + 1] if i + 1 < len(events) else ("", onset)
        if len(phones) == 2 and following[0] in ("r", "r-"):
            phones = ["ih"] if name == "i@" else phones[:1]
        if name == "r-" and merged and merged[-1][0] == "er":
            continue
        for k, phone in enumerate(phones):
            merged.append((phone, onset + 0.6 * k * (following[1] - onset)))
    return merged


def _phones_of(name: str) -> list[str]:
    if name in _IGNORED or name.startswith("("):
        return []
    while name and name not in _ARPABET:
        name = name[:-1]
    return _ARPABET[name].split() if name else []


def _timed(text: str, voice: str, events: list, samples: np.ndarray, rate: int) -> tuple[tuple, tuple]:
    """Words and phones with times in seconds from the synthesiser's events."""
    heard: list[tuple[str, float]] = []
    spans: list[tuple[int, int]] = []  # word events: first character, index of the first phone event
    for event in events:
        if event[0] == "word":
            spans.append((event[2], len(heard)))
        else:
            heard.append((event[2], event[1]))
    merged = _merge(heard)
    onsets = _with_closures(merged, samples, rate)
    ends = [*onsets[1:], len(samples)]
    phones = [(phone, a, b) for (phone, _), a, b in zip(merged, onsets, ends, strict=True) if b > a]
    if phones and phones[0][1] > 0:
        phones[0] = (phones[0][0], 0, phones[0][2])
    phones = _joined_pauses(phones)
    original = [onset for _, onset in heard]
    words = _word_times(text, voice, spans, original, merged, onsets, ends)
    return tuple(tuple((label, a / rate, b / rate) for label, a, b in tier) for tier in (words, phones))


def _with_closures(merged: list[tuple[str, float]], samples: np.ndarray, rate: int) -> list[int]:
    """Onsets in samples, with the onsets of stops moved to the beginning of their closures.

    eSpeak NG reports a stop at its burst and counts the silent closure to the phone before. After a pause the closure
    is inaudible, and at most 60 ms of the pause are taken as the closure.
    """
    quiet = np.abs(samples.astype(np.int32)) < 40
    onsets: list[int] = []
    for i, (phone, onset) in enumerate(merged):
        start = int(round(onset))
        if i and phone in _STOPS:
            paused = merged[i - 1][0] == SILENCE
            earliest = max(onsets[-1] + rate // 100, start - int((0.06 if paused else 0.12) * rate))
            first = start
            while first > earliest and quiet[min(first, len(quiet)) - 1]:
                first -= 1
            start = min(start, first)
        onsets.append(max(start, onsets[-1] if onsets else 0))
    return onsets


def _joined_pauses(phones: list[tuple[str, int, int]]) -> list[tuple[str, int, int]]:
    joined: list[tuple[str, int, int]] = []
    for phone, start, end in phones:
        if joined and phone == SILENCE == joined[-1][0]:
            joined[-1] = (SILENCE, joined[-1][1], end)
        else:
            joined.append((phone, start, end))
    return joined


def _word_times(text, voice, spans, original, merged, onsets, ends) -> list[tuple[str, int, int]]:
    """Words with first and last sample; the phones of pairs that eSpeak NG joins ("of the") are divided."""
    words: list[tuple[str, int, int]] = []
    for i, (first, event) in enumerate(spans):
        last_event = spans[i + 1][1] if i + 1 < len(spans) else len(original)
        last_character = spans[i + 1][0] if i + 1 < len(spans) else len(text)
        tokens = re.findall(r"[\w'’]+", text[first:last_character])
        if not tokens or event == last_event:
            continue
        since, until = original[event], original[last_event] if last_event < len(original) else np.inf
        own = [k for k, (phone, onset) in enumerate(merged) if since <= onset < until and phone != SILENCE]
        if not own:
            continue
        later = [max(1, len(letter_to_sound(token, voice))) for token in tokens[1:]]
        cuts = [0, *(max(1, len(own) - sum(later[k:])) for k in range(len(later))), len(own)]
        for token, a, b in zip(tokens, cuts, cuts[1:], strict=False):
            if b > a:
                words.append((token.lower(), onsets[own[a]], ends[own[b - 1]]))
    return words
