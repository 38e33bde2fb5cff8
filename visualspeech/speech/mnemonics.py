"""Words of a dictionary of one's own as eSpeak NG reads them: mnemonics of its voices in double square brackets."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass

# Mnemonics of eSpeak NG's English voices for ARPAbet; without stress "ah" and "er" are the reduced vowels.
_OF_PHONE = {
    **{"aa": "A:", "ae": "a", "ah": "V", "ao": "O:", "aw": "aU", "ay": "aI", "eh": "E", "er": "3:", "ey": "eI"},
    **{"ih": "I", "iy": "i:", "ow": "oU", "oy": "OI", "uh": "U", "uw": "u:", "ah0": "@", "er0": "3"},
    **{"b": "b", "ch": "tS", "d": "d", "dh": "D", "f": "f", "g": "g", "hh": "h", "jh": "dZ", "k": "k", "l": "l"},
    **{"m": "m", "n": "n", "ng": "N", "p": "p", "r": "r", "s": "s", "sh": "S", "t": "t", "th": "T", "v": "v"},
    **{"w": "w", "y": "j", "z": "z", "zh": "Z"},
}
_STRESS = {"1": "'", "2": ","}
_WORD = re.compile(r"[^\W_]+(?:['’][^\W_]+)*")


@dataclass(frozen=True)
class Spelt:
    """A text with some words as mnemonics.

    Parameters
    ----------
    text : for eSpeak NG
    pieces : of each such word the first and last (exclusive) character in ``text``, and in the original
    """

    text: str
    pieces: tuple[tuple[int, int, int, int], ...]

    def located(self, events: Sequence[Sequence]) -> list[list]:
        """The events of eSpeak NG with the positions of words in the original text."""
        return [[*one[:2], self._original(one[2]), *one[3:]] if one[0] == "word" else list(one) for one in events]

    def _original(self, position: int) -> int:
        shift = 0
        for first, last, begin, end in self.pieces:
            if position < first:
                break
            if position < last:
                return begin
            shift = last - end
        return position - shift


def with_own(text: str, own: Callable[[str], Sequence[str]]) -> Spelt | None:
    """A text whose words are pronounced by a dictionary where that has them; None where it has none of them.

    Parameters
    ----------
    own : function of a word in lower case: its phones, ARPAbet with or without stress digits; empty for other words
    """
    text = text.replace("[[", "  ")
    parts, pieces, done, length = [], [], 0, 0
    for found in _WORD.finditer(text):
        phones = own(found[0].lower().replace("’", "'"))
        if not phones:
            continue
        before, spelt = text[done : found.start()], f"[[{mnemonics(phones)}]]"
        length += len(before)
        pieces.append((length, length + len(spelt), *found.span()))
        parts += [before, spelt]
        length, done = length + len(spelt), found.end()
    return Spelt("".join([*parts, text[done:]]), tuple(pieces)) if pieces else None


def mnemonics(phones: Sequence[str]) -> str:
    """The mnemonics of a word; where no stress is given, its first vowel has it.

    Parameters
    ----------
    phones : ARPAbet in lower case, vowels with or without a stress digit
    """
    vowels = [number for number, phone in enumerate(phones) if phone[0] in "aeiou"]
    marked = any(phone[-1] in _STRESS for phone in phones)
    spelt = []
    for number, phone in enumerate(phones):
        plain = phone.rstrip("012")
        stress = phone[len(plain) :] if marked or not vowels else "1" if number == vowels[0] else ""
        spelt.append(_STRESS.get(stress, "") + _OF_PHONE.get(f"{plain}{stress}", _OF_PHONE[plain]))
    return "|".join(spelt)  # "tS" is one mnemonic, "t|S" are two
