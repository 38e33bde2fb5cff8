"""Splitting of a text into sentences, which are spoken and rendered one by one."""

import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import BinaryIO

from visualspeech.errors import SettingError
from visualspeech.jobs import log

LONGEST = 280  # characters; longer sentences are cut at a comma, else at a space
MAX_TEXT = 1_000_000  # characters of a text, some twenty hours of speech
MAX_WORD = 1000  # letters and digits of a word
_ABBREVIATIONS = frozenset("mr mrs ms dr prof st jr sr vs etc e.g i.e no fig eq approx".split())


def split_sentences(text: str, longest: int = LONGEST) -> list[str]:
    """Sentences of a text in order; those without a pronounceable word are left out, with a warning in the log.

    A sentence ends at ``.``, ``!``, ``?`` or ``:`` before white space (not after an abbreviation or an initial), and at
    an empty line.

    Raises
    ------
    SettingError
        No word of the text can be pronounced.
    """
    check_pronounceable(text)
    found: list[str] = []
    for paragraph in re.split(r"\n\s*\n", text):
        begin = 0
        words = " ".join(paragraph.split())
        for mark in re.finditer(r"[.!?:…]+[\"')\]”’]*\s+", words):
            last = words[begin : mark.start()].rsplit(" ", 1)[-1].lower().lstrip("(\"'“‘")
            if words[mark.start()] == "." and (last in _ABBREVIATIONS or re.fullmatch(r"[a-z]", last)):
                continue
            found.append(words[begin : mark.end()].strip())
            begin = mark.end()
        found.append(words[begin:].strip())
    spoken: list[str] = []
    for piece in (piece for one in found for piece in _pieces(one, longest)):
        if pronounceable(piece):
            spoken.append(piece)
        # A line without letters, such as a row of asterisks, needs no warning.
        elif any(character.isalnum() for character in piece):
            log.warning("left out because it has no word in Latin letters: %s", piece[:60])
    return spoken


def listed_sentences(given: Sequence[str], path: str = "") -> dict[str, str]:
    """Texts to be said, one per video, by number from "001": the lines of a text file, or else the texts given.

    Raises
    ------
    SettingError
        The file cannot be read or is empty, or a text holds no word to pronounce.
    """
    source, texts = "speak.sentences", list(given)
    if path:
        source = path
        try:
            lines = read_text(path).splitlines()
        except SettingError as error:
            raise SettingError(f"cannot read the sentences of {path}: {error}") from error
        texts = [line.strip() for line in lines if line.strip()]
        if not texts:
            raise SettingError(f"{path} holds no sentence; write one text per line.")
    for number, text in enumerate(texts, start=1):
        check_pronounceable(text, f", text {number} of {source}")
    return {f"{number:03d}": text for number, text in enumerate(texts, start=1)}


def read_text(path: str | Path) -> str:
    """The text of a UTF-8 file; it may be a pipe.

    Raises
    ------
    SettingError
        It cannot be read, is too long or not UTF-8; the message does not name it.
    """
    try:
        with open(path, "rb") as file:
            return decoded(file)
    except (OSError, ValueError) as error:
        raise SettingError(f"{getattr(error, 'strerror', None) or 'this is no possible path'}.") from error


def decoded(file: BinaryIO) -> str:
    """The UTF-8 text of an open file; raises :class:`SettingError` if it is too long or not UTF-8."""
    data = file.read(4 * MAX_TEXT + 1)
    if len(data) > 4 * MAX_TEXT:
        raise SettingError(f"it has more than {4 * MAX_TEXT:,} bytes.")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise SettingError(f"it is not UTF-8 text (byte {error.start}).") from error


def pronounceable(text: str) -> bool:
    """Whether a text has a Latin letter or a digit, which the English voice can pronounce."""
    return any(character.isascii() and character.isalnum() for character in unicodedata.normalize("NFKD", text))


def check_pronounceable(text: str, source: str = "") -> None:
    """Check that a text is text, and has a word that can be pronounced.

    Parameters
    ----------
    source : where the text is from, for the message

    Raises
    ------
    SettingError
        It has none, or it is too long, has too long a word, or characters that are no text.
    """
    if len(text) > MAX_TEXT:
        raise SettingError(f"the text{source} has {len(text):,} characters; give at most {MAX_TEXT:,} at a time.")
    if any("\ud800" <= character <= "\udfff" for character in text):
        raise SettingError(f"the text{source} is not UTF-8; give it in a UTF-8 terminal, or as a UTF-8 file.")
    control = next((one for one in text if unicodedata.category(one) == "Cc" and not one.isspace()), None)
    if control is not None:
        raise SettingError(f"the text{source} holds the control character U+{ord(control):04X}; remove it.")
    long = re.search(rf"[^\W_]{{{MAX_WORD + 1},}}", text, re.ASCII)
    if long:
        raise SettingError(
            f"the word {long[0][:30]} ...{source} has {len(long[0]):,} letters; give words of at most {MAX_WORD}."
        )
    if not pronounceable(text):
        shown = text.strip()[:60]
        raise SettingError(
            f"there is no word to pronounce in {shown!r}{source}; give a sentence in English words or numbers."
        )


def _pieces(sentence: str, longest: int) -> list[str]:
    pieces = []
    while len(sentence) > longest:
        cut = max(sentence.rfind(mark, longest // 2, longest) for mark in (", ", "; ", " - "))
        if cut < 0:
            cut = sentence.rfind(" ", 1, longest)
        if cut < 0:
            cut = longest - 1
        pieces.append(sentence[: cut + 1].strip())
        sentence = sentence[cut + 1 :].strip()
    return [*pieces, sentence]
