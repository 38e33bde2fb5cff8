"""Substitutes for phones that a model was not trained on: the known phone that looks most similar.

A small corpus does not contain every phone (GRID lacks "zh", "oy", "sh" ...), but a text read by the synthetic voice
may. Lips and jaw matter here, not the sound, so substitutes follow viseme classes: "sh" for "zh" and "ch", "f" for "v".
A missing diphthong is replaced by its first half. Phones of another phone set (``alignment.phones: as_is``) are
compared by the phone of ARPAbet that they stand for, or where there is none by their spelling: "aː" is like "a".
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import SequenceMatcher

from visualspeech.errors import SettingError
from visualspeech.speech.alignment import Alignment
from visualspeech.speech.phone_sets import arpabet_of
from visualspeech.speech.phones import CLASSES, PHONES, SILENCE, manner

# Substitutes of each phone, the most similar first; if none is known, the phone with most classes in common is taken.
_ALIKE = {
    "b": "p m",
    "p": "b m",
    "m": "b p",
    "f": "v",
    "v": "f",
    "th": "dh l t d",
    "dh": "th l d t",
    "t": "d s n",
    "d": "t n s",
    "n": "d t l",
    "s": "z t",
    "z": "s d",
    "l": "n d",
    "sh": "ch jh zh s",
    "zh": "jh sh ch z",
    "ch": "sh jh zh t",
    "jh": "ch zh sh d",
    "k": "g ng hh",
    "g": "k ng hh",
    "ng": "n g k",
    "hh": "k g ah",
    "w": "uw r uh",
    "r": "w er uh",
    "y": "iy ih",
    "er": "r uh ah",
    "aa": "ao ah ay aw",
    "ao": "aa ow oy",
    "ae": "eh ay aa",
    "ah": "ih eh aa uh",
    "eh": "ae ey ah",
    "ey": "eh ih iy",
    "ih": "iy eh ah",
    "iy": "ih y ey",
    "uh": "uw ow ah",
    "uw": "uh w ow",
    "ow": "ao uw uh",
    "oy": "ao ow",
    "aw": "aa ae ow",
    "ay": "aa ae ah",
}


_VOCALIC = {"vowel", "diphthong"}


def substitute(phone: str, inventory: Sequence[str]) -> str:
    """The phone of an inventory that replaces a phone; the phone itself if the inventory has it.

    Raises
    ------
    SettingError
        The inventory has no phones of speech that can be compared with this one.
    """
    if phone in inventory:
        return phone
    spoken = [other for other in inventory if other != SILENCE]
    wanted, known = arpabet_of(phone), {}  # phone of ARPAbet -> the first of the inventory that stands for it
    for other in spoken:
        known.setdefault(arpabet_of(other), other)
    known.pop("", None)
    if not wanted and spoken and not set(spoken) <= set(PHONES):
        return _alike_in_spelling(phone, spoken)
    if not wanted:
        raise SettingError(
            f"{phone!r} is no phone of English in ARPAbet. Give one in lower case such as {PHONES[1]!r} or "
            f"{PHONES[-1]!r}."
        )
    if phone == SILENCE or not _is_speech(known):
        raise SettingError(
            f"the model's phones ({', '.join(list(inventory)[:6])} ...) are not those of the voice (ARPAbet, and "
            f"{SILENCE!r} for pauses), and do not stand for them; give a model whose alignment has phones of ARPAbet "
            "or IPA."
        )
    for other in (wanted, *_ALIKE.get(wanted, "").split()):
        if other in known:
            return known[other]
    # Phones of the same manner come first, then those with most classes in common, then the order of the inventory.
    names = list(known)
    shared = [(manner(other) == manner(wanted), _common(wanted, other)) for other in names]
    return known[names[max(range(len(names)), key=lambda i: (shared[i], -i))]]


def _is_speech(known: Iterable[str]) -> bool:
    """Whether phones of ARPAbet are a phone set that English can be shown with: it has vowels and consonants."""
    manners = {manner(phone) for phone in known}
    return bool(manners & _VOCALIC) and bool(manners - _VOCALIC)


def _alike_in_spelling(phone: str, inventory: Sequence[str]) -> str:
    def likeness(other: str) -> tuple[bool, float]:
        return phone[0] == other[0], SequenceMatcher(None, phone, other, autojunk=False).ratio()

    return max(inventory, key=likeness)


def substitutes(phones: Iterable[str], inventory: Sequence[str]) -> dict[str, str]:
    """Substitutes of those of the given phones that an inventory lacks: phone -> :func:`substitute`.

    Raises
    ------
    SettingError
        As :func:`substitute`, or the inventory has no silence.
    """
    needed = sorted({SILENCE, *phones} - set(inventory))
    return {phone: substitute(phone, inventory) for phone in needed}


def in_phones(alignment: Alignment, phones: Sequence[str]) -> tuple[Alignment, dict[str, str]]:
    """An alignment with only phones of an inventory, and the substitute of each phone that the inventory lacks.

    Nothing is replaced where the inventory is empty.

    Raises
    ------
    SettingError
        As :func:`substitutes`.
    """
    replaced = substitutes((one.label for one in alignment.phones), phones) if phones else {}
    if not replaced:
        return alignment, {}
    renamed = tuple(replace(one, label=replaced.get(one.label, one.label)) for one in alignment.phones)
    return replace(alignment, phones=renamed), replaced


def _common(one: str, other: str) -> int:
    return sum(one in members and other in members for members in CLASSES.values())
