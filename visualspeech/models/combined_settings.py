"""Settings of models that are made of finished ones; without torch, for planning."""

from dataclasses import dataclass
from typing import ClassVar

from visualspeech.fields import Settings, setting

MAX_MEMBERS = 100  # rows that one row is made of
MAX_DEPTH = 4  # of rows that are made of rows that are made of rows, itself included


@dataclass(frozen=True)
class EnsembleSettings(Settings):
    """An ensemble: the mean of the predictions of other rows."""

    section: ClassVar[str] = "models"

    members: tuple[str, ...] = setting(
        (),
        "Rows whose predictions are averaged, each counting once; an entry of `models` stands for all of its rows, "
        "those of all seeds included.",
        item={"description": "Entry of `models`, or row.", "max_length": 200},
        max_items=MAX_MEMBERS,
        unique=True,
    )


@dataclass(frozen=True)
class GvCompensationSettings(Settings):
    """Global-variance compensation: the predictions of another row with larger excursions."""

    section: ClassVar[str] = "models"

    strength: float = setting(
        0.5,
        "Exponent of the factor on each parameter's excursion from the mean of its utterance, which is the recorded "
        "over the predicted standard deviation: 1 restores the recorded deviation, 0 changes nothing.",
        minimum=0,
        maximum=1,
    )
