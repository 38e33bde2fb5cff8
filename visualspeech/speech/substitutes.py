"""Phones that a model has never heard, put in the words of those it has: the one that looks most alike.

A small corpus does not speak every phone (GRID lacks "zh", "oy", "sh" ...), the voice that reads a text does. What
counts here is the look of lips and jaw and not the sound, so the substitutes follow the classes of visemes: "sh" for
"zh" and "ch", "f" for "v". A diphthong is given by its first half where it is missing whole.
"""

from collections.abc import Iterable, Sequence

from visualspeech.errors import SettingError
from visualspeech.speech.phones import CLASSES, PHONES, SILENCE, manner

# Of each phone the others by how much they look like it, the best first; after them, whatever shares most classes.
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


def substitute(phone: str, inventory: Sequence[str]) -> str:
    """The phone of an inventory that stands for a phone; itself where it is there.

    Raises
    ------
    SettingError
        The inventory holds no phone of speech in ARPAbet, or the phone is none.
    """
    if phone in inventory:
        return phone
    if phone not in PHONES:
        raise SettingError(f"{phone!r} is no phone of English in ARPAbet, as in {PHONES[1]!r} or {PHONES[-1]!r}.")
    for other in _ALIKE.get(phone, "").split():
        if other in inventory:
            return other
    known = [other for other in inventory if other in PHONES and other != SILENCE]
    if phone == SILENCE or not known:
        raise SettingError(
            f"the model's phones ({', '.join(list(inventory)[:6])} ...) are not those of the voice (ARPAbet, and "
            f"{SILENCE!r} for pauses); give a model that was trained on this project's alignment."
        )
    # The same manner first, then most classes in common; ties by the inventory's order.
    shared = [(manner(other) == manner(phone), _common(phone, other)) for other in known]
    return known[max(range(len(known)), key=lambda i: (shared[i], -i))]


def substitutes(phones: Iterable[str], inventory: Sequence[str]) -> dict[str, str]:
    """The stand-in of each of some phones that an inventory lacks (only of these): phone -> :func:`substitute`.

    Raises
    ------
    SettingError
        As :func:`substitute`; also where the inventory does not know silence.
    """
    needed = sorted({SILENCE, *phones} - set(inventory))
    return {phone: substitute(phone, inventory) for phone in needed}


def _common(one: str, other: str) -> int:
    return sum(one in members and other in members for members in CLASSES.values())
