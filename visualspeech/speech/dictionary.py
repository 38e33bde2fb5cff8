"""Pronunciation dictionaries of one's own, in the formats of the Montreal Forced Aligner and of CMU.

A line is a word, in MFA's format up to four probabilities, and the phones of its pronunciation, separated by spaces or
tabs. A word with several pronunciations has several lines; CMU numbers them (``word(2)``). Lines that begin with
``;;;`` and what follows `` # `` are comments.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from visualspeech.errors import SettingError, plain_reason
from visualspeech.speech.lexicon import Lexicon, possessive
from visualspeech.speech.phone_sets import UNKNOWN_SOUND, PhoneSet
from visualspeech.speech.phones import SILENCE
from visualspeech.storage.foreign import decoded, read_bytes

Pronunciation = tuple[str, ...]
MAX_BYTES = 50_000_000  # some two million words
MAX_PHONES = 200  # of a word
MAX_VARIANTS = 50  # of a word
_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_MAX_NUMBERS = 4  # MFA: of the pronunciation, and three of pauses


@dataclass(frozen=True)
class Dictionary:
    """Words with their pronunciations.

    Parameters
    ----------
    entries : word in lower case -> its pronunciations in the order of the file: ARPAbet in lower case, vowels with
        their stress digit where it is known
    """

    entries: Mapping[str, tuple[Pronunciation, ...]]

    def pronunciations(self) -> dict[str, tuple[Pronunciation, ...]]:
        """As :class:`visualspeech.speech.lexicon.Lexicon` takes them, without stress digits; each once."""
        return {
            word: tuple(dict.fromkeys(tuple(phone.rstrip("012") for phone in phones) for phones in many))
            for word, many in self.entries.items()
        }

    def spoken(self, word: str) -> Pronunciation:
        """How a voice pronounces a word, with stress digits: its first pronunciation, possessives by their stem; empty
        for a word that is not listed."""
        key = _key(word)
        if key not in self.entries and key.endswith("'s") and key[:-2] in self.entries:
            phones = self.entries[key[:-2]][0]
            return (*phones, *possessive(phones[-1].rstrip("012")))
        return self.entries.get(key, ((),))[0]

    def text(self) -> str:
        """The content of a file in CMU's format, which :func:`parse_dictionary` reads back."""
        return "".join(
            f"{word}\t{' '.join(phones).upper()}\n" for word, many in self.entries.items() for phones in many
        )


def read_dictionary(path: str | Path, phones: PhoneSet | None = None, most: int = MAX_BYTES) -> Dictionary:
    """The dictionary of a file: UTF-8, UTF-16 with a byte-order mark, or Windows-1252.

    Raises
    ------
    SettingError
        It cannot be read or is too large, or as :func:`parse_dictionary`; the message names the file and the line.
    """
    try:
        return parse_dictionary(decoded(read_bytes(path, most)), phones)
    except OSError as error:
        raise SettingError(f"the pronunciation dictionary {path} cannot be read: {plain_reason(error)}.") from error
    except SettingError as error:
        raise SettingError(f"the pronunciation dictionary {path}, {error}") from None


def lexicon_with(path: str | Path = "", phones: PhoneSet | Mapping | None = None) -> Lexicon:
    """The built-in dictionary, with the words of a file before it; ``phones`` may be plain data of the phone set.

    Raises
    ------
    SettingError
        As :func:`read_dictionary`.
    """
    phones = PhoneSet(**phones) if isinstance(phones, Mapping) else phones
    return Lexicon(own=read_dictionary(path, phones).pronunciations() if path else None)


def parse_dictionary(text: str, phones: PhoneSet | None = None) -> Dictionary:
    """The dictionary of a text.

    Words without phones of speech, such as MFA's ``<eps>`` and ``<unk>``, are left out.

    Parameters
    ----------
    phones : phone set of its pronunciations; default: ARPAbet with or without stress

    Raises
    ------
    SettingError
        A line has no phones, or a phone that the set does not have; or there is no word.
    """
    phones = phones or PhoneSet()
    entries: dict[str, list[Pronunciation]] = {}
    known: dict[str, Pronunciation | None] = {}
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith((";;;", "##")):
            continue
        fields = re.split(r"\s#(?:\s|$)", line)[0].split()
        if not fields:
            continue
        word, labels = _without_numbers(fields)
        if not labels:
            raise SettingError(f"line {number}: {word[:40]!r} has no phones. Write a word and its phones in each line.")
        if len(labels) > MAX_PHONES or len(word) > MAX_PHONES:
            raise SettingError(
                f"line {number}: a word has at most {MAX_PHONES} letters and phones; is it a dictionary?"
            )
        for label in labels:
            if label not in known:
                known[label] = _stressed(label, phones)
            if known[label] is None:
                raise SettingError(
                    f"line {number}: the phone {label[:40]!r} of {word[:40]!r} is none of the phone set {phones.name}. "
                    "Correct it, or set `alignment.phones` to the set of the dictionary (arpabet, ipa, or a table)."
                )
        spoken = tuple(phone for label in labels for phone in known[label] if phone != SILENCE)
        many = entries.setdefault(_key(word), [])
        if spoken and spoken not in many and len(many) < MAX_VARIANTS:
            many.append(spoken)
    found = {word: tuple(many) for word, many in entries.items() if many}
    if not found:
        raise SettingError("line 1: there is no word. Write a word and its phones in each line.")
    return Dictionary(found)


def _without_numbers(fields: list[str]) -> tuple[str, list[str]]:
    """Word and labels of the fields of a line."""
    first = 1
    while first < len(fields) and first <= _MAX_NUMBERS and _NUMBER.fullmatch(fields[first]):
        first += 1
    return re.sub(r"(?<=.)\(\d+\)$", "", fields[0]), fields[first:]


def _key(word: str) -> str:
    """A word as transcripts are normalised: lower case, without accents, typewriter apostrophes."""
    plain = unicodedata.normalize("NFKD", word.lower().replace("’", "'"))
    return "".join(one for one in plain if not unicodedata.combining(one))


def _stressed(label: str, phones: PhoneSet) -> Pronunciation | None:
    """The phones of a label, the first one with the stress digit of the label; None where it is unknown."""
    if label.lower() in UNKNOWN_SOUND:
        return (SILENCE,)
    found = phones.phones(label)
    digit = label[-1] if label[-1] in "012" and label[:-1].isalpha() and phones.name == "arpabet" else ""
    return found if found is None or not digit else (found[0] + digit, *found[1:])
