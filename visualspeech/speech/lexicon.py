"""Pronunciations of words: the dictionary of the acoustic model, and letter-to-sound rules for other words."""

import re
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache
from pathlib import Path

from visualspeech.errors import StorageError
from visualspeech.speech import transcript as transcripts
from visualspeech.speech import tts
from visualspeech.speech.phones import PHONES, SILENCE

Pronunciation = tuple[str, ...]
LettersToSounds = Callable[[Iterable[str]], Mapping[str, list[str]]]


class Lexicon:
    """Pronunciations in ARPAbet, lower case, without stress digits.

    Parameters
    ----------
    dictionary : path of a dictionary in CMU format (a word or ``word(2)``, then its phones); default: PocketSphinx's
    letters_to_sounds : words -> phones of each, for words that the dictionary does not list
    own : pronunciations by word that replace the dictionary's

    Raises
    ------
    StorageError
        The dictionary cannot be read.
    """

    def __init__(
        self,
        dictionary: str | Path | None = None,
        letters_to_sounds: LettersToSounds = tts.letters_to_sounds,
        own: Mapping[str, Iterable[Pronunciation]] | None = None,
    ) -> None:
        self._listed = _read(str(dictionary or bundled_dictionary()))
        self._own = {word: tuple(map(tuple, many)) for word, many in (own or {}).items()}
        self._letters_to_sounds = letters_to_sounds

    def __contains__(self, word: str) -> bool:
        return word in self._own or word in self._listed

    def words(self, text: str) -> list[str]:
        """Words of a transcript as they are spoken, see :func:`normalise_transcript`."""
        return transcripts.normalise(text, self.__contains__)

    def unknown_words(self, text: str) -> list[str]:
        """Words of a transcript that the dictionary does not list, each once, in order of appearance."""
        return [word for word in dict.fromkeys(self.words(text)) if word not in self]

    def pronunciations(self, word: str) -> tuple[Pronunciation, ...]:
        """Listed pronunciations of a word; empty if there are none."""
        if word in self._own:
            return self._own[word]
        return tuple(tuple(line.lower().split()) for line in self._listed.get(word, "").split("\n") if line)

    def guess(self, words: Iterable[str]) -> dict[str, tuple[Pronunciation, ...]]:
        """Pronunciations of unlisted words: from the stem for possessives, else by letter-to-sound rules.

        The value is empty for words that cannot be pronounced, among them words in other than Latin letters.
        """
        words = list(dict.fromkeys(words))
        stems = {word: word[:-2] for word in words if word.endswith("'s") and word[:-2] in self}
        rest = [word for word in words if word not in stems and re.search("[a-z]", word)]
        by_rule = self._letters_to_sounds(rest) if rest else {}
        guessed = {
            word: tuple((*one, *possessive(one[-1])) for one in self.pronunciations(stems[word])) for word in stems
        }
        for word in words:
            if word in stems:
                continue
            phones = tuple(phone for phone in by_rule.get(word, ()) if phone in PHONES and phone != SILENCE)
            guessed[word] = (phones,) if phones else ()
        return guessed


@lru_cache(maxsize=1)
def _bundled() -> Lexicon:
    return Lexicon()


def normalise_transcript(text: str, lexicon: Lexicon | None = None) -> list[str]:
    """Words of a transcript as they are spoken, in lower case: numbers spelt out, punctuation dropped.

    Parameters
    ----------
    text : as written
    lexicon : decides which words are listed (hyphens, apostrophes, capitals); by default the bundled dictionary
    """
    return (lexicon or _bundled()).words(text)


def bundled_dictionary() -> Path:
    """Path of the American English dictionary inside the PocketSphinx package."""
    from pocketsphinx import get_model_path

    return Path(get_model_path(), "en-us", "cmudict-en-us.dict")


def possessive(last: str) -> Pronunciation:
    """The phones of a possessive ending after a last phone."""
    if last in ("s", "z", "sh", "zh", "ch", "jh"):
        return ("ih", "z")
    return ("s",) if last in ("f", "k", "p", "t", "th") else ("z",)


@lru_cache(maxsize=4)
def _read(path: str) -> dict[str, str]:
    """Word -> its pronunciations as in the file, one per line."""
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StorageError(f"cannot read the dictionary {path}: {error}. Install pocketsphinx again.") from error
    listed: dict[str, str] = {}
    for line in text.splitlines():
        word, _, phones = line.partition(" ")
        word = re.sub(r"\(\d+\)$", "", word)
        listed[word] = f"{listed[word]}\n{phones}" if word in listed else phones
    return listed
