"""Which participants of a viewing test are counted: those who finished and passed the attention items."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from visualspeech.errors import DataError
from visualspeech.study.evaluation_settings import EvaluationSettings
from visualspeech.study.layouts import ATTENTION, ITEM
from visualspeech.study.records import Answer, Key, Participant, Study


@dataclass(frozen=True)
class Participation:
    """How far a participant came.

    Parameters
    ----------
    code : of the participant
    answered, items : number of items of which every question was answered, and of all; without practice and attention
        items
    attention : number of attention items
    unanswered : number of attention items that were not answered
    failed : number of attention items with another answer than they ask for
    reason : why the participant is left out; empty if he or she is counted
    """

    code: str
    answered: int
    items: int
    attention: int
    unanswered: int
    failed: int
    reason: str


@dataclass(frozen=True)
class Screening:
    """The participants of a study, in the order in which they started.

    Parameters
    ----------
    rule : who is counted, a sentence
    participations : one per participant
    answers : of the counted participants to items that count
    """

    rule: str
    participations: tuple[Participation, ...]
    answers: tuple[tuple[str, Answer], ...]

    @property
    def counted(self) -> tuple[Participation, ...]:
        return tuple(one for one in self.participations if not one.reason)

    @property
    def left_out(self) -> tuple[Participation, ...]:
        return tuple(one for one in self.participations if one.reason)


def screen(
    study: Study,
    key: Key,
    participants: Sequence[Participant],
    answers: Sequence[Answer],
    settings: EvaluationSettings | None = None,
    path: str = "the answers",
) -> Screening:
    """Decide who is counted.

    Parameters
    ----------
    participants, answers : as read from a database
    path : of the database, for messages

    Returns
    -------
    Screening
        its ``answers`` are pairs of a participant's code and an answer to an item of the role ``item``

    Raises
    ------
    DataError
        An answer is of nobody, to an unknown item or question, outside the scale, or there twice.
    """
    settings = settings or EvaluationSettings()
    codes = {one.id: one.code for one in participants}
    of_person = _by_person(study, codes, answers, path)
    found = tuple(_participation(study, key, one.code, of_person[one.code], settings) for one in participants)
    counted = {one.code for one in found if not one.reason}
    scored = {one.id for one in study.of_role(ITEM)}
    kept = ((codes[one.participant], one) for one in answers if one.item in scored)
    return Screening(
        rule=_rule(study, settings),
        participations=found,
        answers=tuple((code, one) for code, one in kept if code in counted),
    )


def _by_person(study: Study, codes, answers: Sequence[Answer], path: str) -> dict[str, dict[tuple[str, str], Answer]]:
    """Code of a participant -> (item, question) -> answer; every answer is checked."""
    items, questions = {one.id: one for one in study.items}, {one.name: one for one in study.questions}
    found: dict[str, dict[tuple[str, str], Answer]] = defaultdict(dict)
    for one in answers:
        if one.participant not in codes:
            wrong = f"an answer of a participant {one.participant!r} who is not in its list"
        elif one.item not in items or one.question not in questions:
            what, name = ("item", one.item) if one.item not in items else ("question", one.question)
            wrong = f"an answer to the {what} {name!r}, which is not in the study"
        elif one.mirrored not in range(len(items[one.item].stimuli)):
            wrong = f"an answer to a video of the item {one.item!r} that is not in the study"
        elif not questions[one.question].allows(one.value):
            wrong = f"the answer {one.value!r} to the question {one.question!r}, which does not allow it"
        elif (one.item, one.question) in found[codes[one.participant]]:
            wrong = f"two answers of {codes[one.participant]} to the question {one.question!r} of the item {one.item!r}"
        else:
            found[codes[one.participant]][one.item, one.question] = one
            continue
        raise DataError(
            f"{path} holds {wrong}. Files of two studies were mixed, or the file was edited: restore it from a copy, "
            "or move it away."
        )
    return found


def _participation(study: Study, key: Key, code: str, given, settings: EvaluationSettings) -> Participation:
    items, attention = study.of_role(ITEM), study.of_role(ATTENTION)
    answered = sum(all((one.id, question.name) in given for question in study.questions) for one in items)
    unanswered = failed = 0
    for one in attention:
        wanted = key.expected.get(one.id, {})
        values = {name: given[one.id, name].value for name in wanted if (one.id, name) in given}
        unanswered += len(values) < len(wanted)
        failed += any(value != wanted[name] for name, value in values.items())
    if not answered:
        reason = "answered no item"
    elif answered < len(items) or unanswered:
        reason = "stopped early"
    elif failed > settings.max_failed_attention:
        reason = "failed attention items"
    else:
        reason = ""
    return Participation(code, answered, len(items), len(attention), unanswered, failed, reason)


def _rule(study: Study, settings: EvaluationSettings) -> str:
    """Who is counted, in words."""
    attention, most = len(study.of_role(ATTENTION)), settings.max_failed_attention
    if not attention or most >= attention:
        return "Participants who answered every item are counted."
    passed = "all attention items" if not most else f"all attention items but {most} at most"
    return f"Participants who answered every item, and {passed} as asked, are counted."
