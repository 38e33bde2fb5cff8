"""Settings of tables of chosen rows and measures (:mod:`visualspeech.evaluation.selections`)."""

from dataclasses import dataclass

from visualspeech.fields import Settings, setting, setting_error

_LINE = r"[^\r\n]*"
#: Rules of the name of a measure; planning knows which there are (:mod:`visualspeech.planning.own_metrics`).
NAMED = {
    "description": "A measure of docs/papers.md, or `module:function`, one of your own (docs/tables.md).",
    "min_length": 1,
    "max_length": 1000,
    "pattern": _LINE,
}


@dataclass(frozen=True)
class SelectionSettings(Settings):
    """A table of chosen rows and measures: mean and deviation over utterances, and paired differences."""

    section = "tables.selections"
    title: str = setting("", "Caption; empty: the name of the table.", max_length=200, pattern=_LINE)
    rows: tuple[str, ...] = setting(
        (),
        "Rows in the order of the table: entries of models, or rows; empty for no table.",
        item={"description": "Entry of models, or row.", "max_length": 200},
        max_items=1000,
        unique=True,
    )
    metrics: tuple[str, ...] = setting(
        ("corr_first5", "rmse_first5"),
        "Measures shown as mean and standard deviation over utterances, those of a published table first of all.",
        item=NAMED,
        min_items=1,
        max_items=100,
        unique=True,
    )
    intervals: tuple[str, ...] = setting(
        (),
        "Measures shown as figures of the corpus with their intervals, and with paired differences to `reference`.",
        item=NAMED,
        max_items=100,
        unique=True,
    )
    reference: str = setting(
        "",
        "Entry of models with one row, or row, that differences are taken to; empty for no differences.",
        max_length=200,
    )
    down: str = setting(
        "", "Setting of the models whose values are the lines of the table, with `across`.", max_length=64
    )
    across: str = setting(
        "",
        "Setting of the models whose values are the columns, for example `nodes`; empty: one line per row.",
        max_length=64,
    )
    notes: tuple[str, ...] = setting(
        (),
        "Sentences below the table, for example on what a row knows.",
        item={"description": "A sentence.", "max_length": 1000, "pattern": _LINE},
        max_items=20,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if bool(self.down) != bool(self.across):
            given, other = ("down", "across") if self.down else ("across", "down")
            raise setting_error(type(self), given, getattr(self, given), f"given together with `{other}`")
        if self.across and self.intervals:
            rule = "left out of a table with `down` and `across`"
            raise setting_error(type(self), "intervals", self.intervals, rule)
