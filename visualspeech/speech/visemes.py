"""Visemes of MPEG-4 (ISO/IEC 14496-2, Annex C): the classes of phones that look alike, as programs exchange them.

They are labels for other programs; no model of this project reads them. Dynamic visemes are something else
(:mod:`visualspeech.features.visemes`).
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from visualspeech.speech.phones import SILENCE

#: Number of a viseme is its position; the names are those of the Oculus Lipsync list, which has the same classes.
NAMES = ("sil", "PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "ih", "oh", "ou")
_PHONES = {
    "sil": SILENCE,
    "PP": "p b m",
    "FF": "f v",
    "TH": "th dh",
    "DD": "t d",
    "kk": "k g ng",
    "CH": "ch jh sh zh",
    "SS": "s z",
    "nn": "n l",
    "RR": "r er",
    "aa": "aa ah",
    "E": "eh ae hh",
    "ih": "ih iy y",
    "oh": "ao",
    "ou": "uh uw w",
}
#: Phones that move from one viseme to another; each takes half of the phone.
_MOVING = {
    "aw": ("aa", "ou"),
    "ay": ("aa", "ih"),
    "ey": ("E", "ih"),
    "ow": ("oh", "ou"),
    "oy": ("oh", "ih"),
}
#: Phone in lower-case ARPAbet -> names of its visemes in their order.
VISEMES: dict[str, tuple[str, ...]] = {
    **{phone: (name,) for name, phones in _PHONES.items() for phone in phones.split()},
    **_MOVING,
}


class TimedViseme(NamedTuple):
    """A viseme with its times in seconds."""

    label: str
    start: float
    end: float

    @property
    def number(self) -> int:
        """Number of MPEG-4, 0 to 14."""
        return NAMES.index(self.label)


def visemes_of(phones: Iterable[tuple[str, float, float]]) -> Iterator[TimedViseme]:
    """The visemes of phones (label, start, end in seconds); successive equal ones are joined.

    Phones of another phone set have none, and are left out.
    """
    last = None
    for phone, start, end in phones:
        names = VISEMES.get(phone, ())
        for part, name in enumerate(names):
            begin, stop = (start + (end - start) * (part + step) / len(names) for step in (0, 1))
            if last and last.label == name and abs(last.end - begin) < 1e-6:
                last = last._replace(end=stop)
                continue
            if last:
                yield last
            last = TimedViseme(name, begin, stop)
    if last:
        yield last
