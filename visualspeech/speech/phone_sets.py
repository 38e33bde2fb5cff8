"""Phone sets of other aligners and dictionaries, mapped onto ARPAbet as this project writes it.

A mapping gives each label of an alignment or a dictionary as phones of this project: a preset
(ARPAbet with or without stress, IPA), or a table of one's own. With ``as_is`` labels stay what they are.
"""

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

from visualspeech.errors import SettingError
from visualspeech.speech.phones import PHONES, SILENCE

PRESETS = ("arpabet", "ipa", "as_is")
MAX_LABEL = 40  # characters of a label
#: Labels of pauses, compared in lower case: of MFA, Kaldi, Praat, HTK, MAUS and CMU Sphinx.
PAUSES = frozenset(
    ("", SILENCE, "sp", "pau", "silence", "pause", "h#", "#", "_", "<p:>", "<eps>", "<sil>", "<s>", "</s>", "ap")
)
#: Labels of sound that the aligner gave no phones to: unknown words, noise, laughter.
UNKNOWN_SOUND = frozenset(("spn", "nsn", "noise", "lau", "<unk>", "+spn+", "+noise+"))

# Allophones and the symbols of larger versions of ARPAbet.
_ARPABET = {"ax": "ah", "ax-h": "ah", "axr": "er", "ix": "ih", "ux": "uw", "dx": "t", "nx": "n", "el": "ah l",
            "em": "ah m", "en": "ah n", "eng": "ng", "hv": "hh", "h": "hh", "q": "t"}  # fmt: skip

# The English phone set of MFA 2 and 3 (english_us_mfa, english_uk_mfa ...), and what other transcribers write.
# Vowels are those of the American dictionary: "ɐ" is the vowel of "cut", "ɒ" that of "thought".
_IPA = {
    "aa": "ɑ ɑː aː",
    "ae": "æ a",
    "ah": "ɐ ʌ ə ɘ",
    "ao": "ɒ ɒː ɔ ɔː",
    "aw": "aw aʊ",
    "ay": "aj aɪ",
    "eh": "ɛ ɛː e",
    "er": "ɚ ɝ ɜ ɜː",
    "ey": "ej eɪ eː",
    "ih": "ɪ ɨ",
    "iy": "i iː",
    "ow": "ow əw oʊ əʊ o oː",
    "oy": "ɔj ɔɪ",
    "uh": "ʊ",
    "uw": "u uː ʉ ʉː",
    "aa r": "ɑɹ",
    "eh ah": "eə ɛə",
    "ih ah": "ɪə",
    "uh ah": "ʊə",
    "ah l": "l̩ ɫ̩ əl",
    "ah m": "m̩ əm",
    "ah n": "n̩ ən",
    "b": "b",
    "ch": "tʃ ʧ",
    "d": "d ɖ",
    "dh": "ð d̪",
    "f": "f",
    "g": "ɡ g ɟ",
    "hh": "h ç ɦ",
    "jh": "dʒ ʤ",
    "k": "k c x",
    "k p": "kp",
    "l": "l ɫ ʎ",
    "m": "m ɱ",
    "n": "n ɲ ɾ̃",
    "ng": "ŋ",
    "p": "p",
    "r": "ɹ r ɻ",
    "s": "s",
    "sh": "ʃ",
    "t": "t ʈ ɾ ʔ",
    "th": "θ t̪",
    "v": "v ʋ",
    "w": "w ʍ",
    "y": "j",
    "z": "z",
    "zh": "ʒ",
}
_OF_IPA = {unicodedata.normalize("NFD", one): phones for phones, many in _IPA.items() for one in many.split()}
# Modifiers that leave a phone what it is: palatalised, aspirated, labialised, long, tie bars, stress and tone.
_MODIFIERS = re.compile("[ʰʲʷˠˤˑːˈˌ˞ⁿˡ˥˦˧˨˩̪̥̬̃̚͜͡]")
_POSITION = re.compile("_[BIES]$")  # of a phone in its word, as Kaldi marks it: AH0_I
_STRESS = re.compile("[ˈˌ͜͡]")


@dataclass(frozen=True)
class PhoneSet:
    """How the labels of an alignment or a dictionary are read.

    Parameters
    ----------
    name : preset, or what the table is called in messages
    table : label -> phones of ARPAbet, separated by spaces, or "sil"; empty for a preset
    """

    name: str = "arpabet"
    table: Mapping[str, str] = field(default_factory=dict)

    @property
    def is_arpabet(self) -> bool:
        """Whether its phones are those of :data:`visualspeech.speech.phones.PHONES`."""
        return self.name != "as_is"

    def phones(self, label: str) -> tuple[str, ...] | None:
        """The phones that a label stands for; a pause is ("sil",), None for a label that the set does not have.

        Parameters
        ----------
        label : without white space around it; sound without phones (:data:`UNKNOWN_SOUND`) is the caller's
        """
        if label in self.table:
            return tuple(self.table[label].split())
        if label.lower() in PAUSES:
            return (SILENCE,)
        if self.name == "as_is":
            return (label,) if is_label(label) else None
        if self.table:
            return None
        found = _arpabet(label) if self.name == "arpabet" else _ipa(label)
        return tuple(found.split()) if found else None


def is_label(label: str) -> bool:
    """Whether a text can be a phone that is taken as it is."""
    return 0 < len(label) <= MAX_LABEL and label.isprintable() and not re.search(r"\s", label)


@lru_cache(maxsize=1024)
def arpabet_of(label: str) -> str:
    """The phone of ARPAbet that a label of any known phone set stands for first; empty where none is known."""
    if label in PHONES:
        return label
    found = _arpabet(label) or _ipa(label)
    return found.split()[-1] if found else ""


def _arpabet(label: str) -> str:
    name = re.sub(r"(?<=[a-z])[0-3]$", "", _POSITION.sub("", label).lower())
    return name if name in PHONES and name != SILENCE else _ARPABET.get(name, "")


def _ipa(label: str) -> str:
    name = _STRESS.sub("", unicodedata.normalize("NFD", _POSITION.sub("", label).replace(":", "ː")))
    return _OF_IPA.get(name) or _OF_IPA.get(_MODIFIERS.sub("", name), "")


def checked_table(table: Mapping[str, str], where: str) -> dict[str, str]:
    """A table of labels with the phones of each, without stress digits.

    Raises
    ------
    SettingError
        A label or a phone is not possible; ``where`` names the table.
    """
    found = {}
    for label, phones in table.items():
        if not isinstance(label, str) or not isinstance(phones, str):
            raise SettingError(f"{where}: {label!r}: {phones!r} must be two texts; put them in quotes.")
        if not is_label(label):
            raise SettingError(f"{where}: {label[:MAX_LABEL]!r} is no possible label of a phone.")
        names = phones.split()
        known = [_arpabet(one) or (SILENCE if one.lower() == SILENCE else "") for one in names]
        for one, name in zip(names, known, strict=True):
            if not name:
                raise SettingError(
                    f"{where}: {one[:MAX_LABEL]!r}, given for {label!r}, is no phone of ARPAbet. Known: "
                    f"{', '.join(PHONES)}."
                )
        if not names or (SILENCE in known and len(known) > 1):
            raise SettingError(f"{where}: {label!r} must have one or more phones of ARPAbet, or {SILENCE}.")
        found[label] = " ".join(known)
    if not found:
        raise SettingError(f"{where} is empty; give a line for each phone: its label, then ARPAbet.")
    return found
