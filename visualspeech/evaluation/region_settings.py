"""Settings of the tables by region of the face and by emotion (:mod:`visualspeech.evaluation.region_table`)."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting

_ROWS = {"description": "Entry of models, or row.", "max_length": 200}


@dataclass(frozen=True)
class RegionTableSettings(Settings):
    """Table of models by region of the face, with parameters and cost of training (Sadoughi & Busso 2017, Table 1)."""

    section = "tables.regions"
    rows: tuple[str, ...] = setting(
        (),
        "Rows in the order of the table, beside the training mean and the floor; empty for no such table.",
        item=_ROWS,
        max_items=1000,
        unique=True,
    )


@dataclass(frozen=True)
class EmotionSettings(Settings):
    """Table and figure by region of the face and emotion (Sadoughi & Busso 2017, Fig. 5), of corpora with emotions."""

    section = "tables.emotions"
    rows: tuple[str, ...] = setting(
        (),
        "Rows that are compared; empty for no such table.",
        item=_ROWS,
        max_items=8,
        unique=True,
    )
    min_utterances: int = setting(
        51,
        "An emotion is shown if at least so many test utterances have it; the paper shows those with more than 50.",
        minimum=1,
        maximum=1_000_000,
    )
