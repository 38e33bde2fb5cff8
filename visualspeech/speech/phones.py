"""The phones of the acoustic model: ARPAbet in lower case, without stress digits, and their articulatory classes."""

SILENCE = "sil"

_MANNERS = {
    "vowel": "aa ae ah ao eh er ih iy uh uw",
    "diphthong": "aw ay ey ow oy",
    "glide": "l r w y",
    "nasal": "m n ng",
    "stop": "b d g k p t",
    "affricate": "ch jh",
    "fricative": "dh f hh s sh th v z zh",
}
_PLACES = {
    "bilabial": "b m p",
    "labiodental": "f v",
    "dental": "dh th",
    "alveolar": "d l n r s t z",
    "postalveolar": "ch jh sh zh",
    "velar": "g k ng",
    "rounded": "ao ow oy r uh uw w",
    "open": "aa ae ah aw ay eh",
}

# Class name -> phones. Each phone of speech has one manner; the other classes overlap and describe lips and jaw.
CLASSES: dict[str, frozenset[str]] = {
    **{name: frozenset(phones.split()) for name, phones in {**_MANNERS, **_PLACES}.items()},
    "pause": frozenset({SILENCE}),
}

# Every label that the phone tier of a forced alignment may hold, "sil" first, the others sorted.
PHONES: tuple[str, ...] = (SILENCE, *sorted({phone for phones in _MANNERS.values() for phone in phones.split()}))

STATES = 3  # HMM states per phone


def manner(phone: str) -> str:
    """Manner of articulation of a phone ("vowel", "stop", ...; "pause" for "sil").

    Raises
    ------
    KeyError
        The phone is not in :data:`PHONES`.
    """
    for name in (*_MANNERS, "pause"):
        if phone in CLASSES[name]:
            return name
    raise KeyError(phone)
