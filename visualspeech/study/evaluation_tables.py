"""What the tables of preference and rating tests share: facts, notes, wordings, and the participants left out."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from visualspeech import __version__
from visualspeech.evaluation.layout import Cell, Row, Table, interval
from visualspeech.evaluation.report import Picture
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.exclusion import Participation, Screening
from visualspeech.study.figures import SIMULATED
from visualspeech.study.participants_statistics import Interval
from visualspeech.study.records import Key, Study

#: Participants that the table for readers lists; the TSV holds all of them.
MAX_LISTED = 100


@dataclass(frozen=True)
class Part:
    """A table in all of its forms.

    Parameters
    ----------
    name : of its files
    title : of its page
    frame : its figures, for the TSV
    tables : for readers
    """

    name: str
    title: str
    frame: object
    tables: tuple[Table, ...]


@dataclass(frozen=True)
class Drawing:
    """A figure and the name of its file, without the suffix."""

    name: str
    picture: Picture


@dataclass(frozen=True)
class Context:
    """The study that is evaluated, whose answers are read, and who is counted."""

    study: Study
    key: Key
    screening: Screening
    settings: EvaluationSettings
    simulated: bool = False

    def titled(self, title: str) -> str:
        """A title that says so where the answers are simulated."""
        return f"{SIMULATED.capitalize()}: {title}" if self.simulated else title

    def marked(self, table: Table) -> Table:
        """A table whose title says so where the answers are simulated."""
        return replace(table, title=self.titled(table.title))

    def facts(self) -> tuple[tuple[str, str], ...]:
        """What the figures were computed on, as (name, text) pairs."""
        counted, all_of_them = len(self.screening.counted), len(self.screening.participations)
        whose = "SIMULATED: no person gave them" if self.simulated else "people"
        return (
            ("study", self.study.name),
            ("corpus", self.key.corpus),
            ("split", self.key.split),
            ("answers", whose),
            ("participants", f"{counted} counted, {all_of_them - counted} left out"),
            ("visualspeech", __version__),
        )

    def level(self) -> str:
        """The confidence level as text."""
        return f"{self.settings.level * 100:g} %"

    def source(self) -> str:
        """Value of the column ``answers`` of TSV files."""
        return "simulated" if self.simulated else "people"

    def title_of(self, condition: str) -> str:
        """Title of a condition."""
        return next(one.title or one.name for one in self.key.conditions if one.name == condition)


def p_text(p: float) -> str:
    """A p value as text; empty for NaN."""
    if p != p:
        return ""
    return "<\u00a00.0001" if p < 1e-4 else f"{p:.4f}"


def p_phrase(p: float) -> str:
    """A p value as a phrase, for example ``p = 0.0215``."""
    text = p_text(p)
    return f"p {text}" if text.startswith("<") else f"p = {text}" if text else "not defined"


def percent(value: float) -> str:
    """A share as text; empty for NaN."""
    return "" if value != value else f"{value:.1%}"


def percent_interval(given: Interval) -> str:
    """An interval of shares as text, in percent without the sign; empty where there is none."""
    if given.low != given.low or given.high != given.high:
        return ""
    return interval(f"{100 * given.low:.1f}", f"{100 * given.high:.1f}")


def participants_part(context: Context) -> Part:
    """The participants, and why some are left out."""
    import pandas

    screening = context.screening
    columns = ["code", "answered", "items", "attention", "unanswered", "failed", "reason"]
    frame = pandas.DataFrame(
        [[getattr(one, name) for name in columns] for one in screening.participations], columns=columns
    ).assign(answers=context.source())
    shown = screening.left_out[:MAX_LISTED]
    more = len(screening.left_out) - len(shown)
    reasons = dict.fromkeys(one.reason for one in screening.left_out)
    counts = [f"{name}: {sum(one.reason == name for one in screening.left_out)}" for name in reasons]
    table = Table(
        title="Participants left out",
        columns=("items answered", "attention items failed", "reason"),
        rows=tuple(Row(one.code, _cells(one)) for one in shown) or (Row("none", (Cell(""),) * 3),),
        facts=(*context.facts(), *((("left out", ", ".join(counts)),) if counts else ())),
        notes=(screening.rule, *((f"{more} more are listed in participants.tsv.",) if more else ())),
        corner="Participant",
    )
    return Part("participants", context.titled("participants"), frame, (context.marked(table),))


def _cells(one: Participation) -> tuple[Cell, Cell, Cell]:
    failed = f"{one.failed} of {one.attention}" if one.attention else ""
    return Cell(f"{one.answered} of {one.items}"), Cell(failed), Cell(one.reason)


def participants_note(participants: int) -> tuple[str, ...]:
    """What cannot be said of one participant."""
    if participants > 1:
        return ()
    return ("One participant alone counts: there is no interval and no test over participants.",)


def listed(names: Sequence[str]) -> str:
    """Names as an enumeration."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
