"""The speakers of the demo corpora and their emotions, as data; nobody of them is a real person.

``demo`` is the speaker of the corpus of that name. ``alex`` has the same face and voice, ``robin`` another face, with
other proportions and colours, and another voice. An emotion moves brows, corners of the mouth and cheeks, and changes
pitch, rate and level of the voice. How much is chosen by hand for a corpus that shows what an emotion does to tables;
it is no model of emotion.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

Colour = tuple[float, float, float]


class Bump(NamedTuple):
    """A smooth, symmetric displacement: two Gaussians, at ``x`` to either side of the middle of the face.

    Parameters
    ----------
    x, y : centres, canonical pixels from the middle and from the top of the image
    width, height : distances at which the displacement falls to 1/e
    outward, down : displacement in canonical pixels
    """

    x: float
    y: float
    width: float
    height: float
    outward: float
    down: float


@dataclass(frozen=True)
class Look:
    """Colours of a portrait, RGB or factors of RGB."""

    hair: Colour = (1.12, 0.97, 0.88)
    hair_light: float = 18.0
    skin: Colour = (0.90, 0.83, 0.74)
    body: Colour = (190, 146, 110)
    upper_lip: Colour = (142, 76, 72)
    lower_lip: Colour = (164, 92, 86)
    brow: Colour = (46, 34, 28)
    brow_width: float = 3.3
    iris: Colour = (72, 104, 92)
    backdrop: Colour = (142, 152, 158)
    wool: Colour = (52, 72, 88)


@dataclass(frozen=True)
class Character:
    """A speaker.

    Parameters
    ----------
    look : colours
    proportions : displacements of the canonical face
    voice : of eSpeak NG
    pitch : added to the pitch of the settings, 0 to 100
    rate : factor of the speaking rate
    """

    look: Look = Look()
    proportions: tuple[Bump, ...] = ()
    voice: str = "en-us"
    pitch: int = 0
    rate: float = 1.0


@dataclass(frozen=True)
class Emotion:
    """What an emotion does to face and voice.

    Parameters
    ----------
    face : amount of each movement of :data:`MOVEMENTS`, -1 to 1
    pitch : added to the pitch of the voice
    rate, level : factors of the speaking rate and of the level of the sound
    articulation : factor of the opening of the mouth
    """

    face: dict[str, float] = field(default_factory=dict)
    pitch: int = 0
    rate: float = 1.0
    level: float = 1.0
    articulation: float = 1.0


#: What an amount of 1 of each movement does: brows up; their inner ends up and apart; corners of the mouth up and out;
#: cheeks up.
MOVEMENTS = {
    "brows": (Bump(38, 126, 34, 15, 0.0, -5.5),),
    "inner_brows": (Bump(17, 129, 15, 16, 1.6, -6.0),),
    "corners": (Bump(30, 231, 16, 14, 3.2, -5.0),),
    "cheeks": (Bump(50, 202, 22, 20, 1.0, -3.6),),
}

EMOTIONS = {
    "neutral": Emotion(),
    "happiness": Emotion(
        {"brows": 0.55, "corners": 1.0, "cheeks": 1.0}, pitch=18, rate=1.08, level=0.95, articulation=1.1
    ),
    "anger": Emotion(
        {"brows": -0.7, "inner_brows": -1.0, "corners": -0.3}, pitch=7, rate=1.15, level=1.15, articulation=1.15
    ),
    "sadness": Emotion(
        {"brows": -0.15, "inner_brows": 1.0, "corners": -0.9, "cheeks": -0.3},
        pitch=-14,
        rate=0.85,
        level=0.5,
        articulation=0.8,
    ),
}

CHARACTERS = {
    "demo": Character(),
    "alex": Character(),
    "robin": Character(
        look=Look(
            hair=(1.9, 1.42, 0.98),
            hair_light=34.0,
            skin=(0.76, 0.64, 0.54),
            body=(150, 106, 78),
            upper_lip=(120, 58, 58),
            lower_lip=(140, 70, 66),
            brow=(74, 52, 34),
            brow_width=4.6,
            iris=(96, 70, 44),
            backdrop=(150, 140, 122),
            wool=(120, 52, 48),
        ),
        proportions=(
            Bump(60, 245, 40, 34, 6.0, 4.0),  # a wider and longer jaw
            Bump(0, 276, 34, 22, 0.0, 4.0),  # a longer chin
            Bump(46, 152, 22, 16, -3.5, 0.0),  # eyes closer together
            Bump(40, 127, 34, 14, 0.0, 4.0),  # lower brows
            Bump(0, 198, 26, 18, 0.0, 3.5),  # a longer nose
            Bump(18, 200, 10, 10, 2.5, 0.0),  # a broader nose
            Bump(27, 232, 18, 16, 2.5, 2.0),  # a wider mouth
        ),
        voice="en-us+f3",
        pitch=18,
        rate=1.06,
    ),
}
