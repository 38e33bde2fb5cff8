"""What a study folder holds: the study that is shown, the key, and the answers of its participants.

======================== ===========================================================================================
``study.json``           what participants see: title, questions, items by meaningless ids
``media/``               the stimuli, ``<random id>.mp4``, and the sound of the sound check
``key.json``             which stimulus is of which utterance and condition; the server never opens it
``answers.sqlite``       answers of people
``answers.simulated.sqlite``  answers of simulated participants and of rehearsals, never mixed with those of people
======================== ===========================================================================================

An item of a preference study has two stimuli, each one side-by-side video: the same pair of heads in both orders. An
item of a rating study has one. An answer holds what was on the screen (``left``, ``none``, ``right`` or a number) and
which stimulus of the item was shown; :meth:`Key.preferred` looks up the condition.
"""

import json
import sqlite3
from collections.abc import Mapping
from contextlib import closing
from dataclasses import asdict, dataclass, field
from pathlib import Path

from visualspeech.errors import DamagedFile, DataError, StorageError
from visualspeech.provenance import digest
from visualspeech.storage.files import read_text, write_text
from visualspeech.storage.layouts import check_plain, parse_plain
from visualspeech.study.layouts import (
    ITEM,
    KEY_SCHEMA,
    LEFT,
    NONE,
    PREFERENCE,
    STUDY_SCHEMA,
    VERSION,
)

STUDY, KEY, MEDIA = "study.json", "key.json", "media"
ANSWERS, SIMULATED_ANSWERS = "answers.sqlite", "answers.simulated.sqlite"
REMEDY = "Make the study again (`snakemake --cores 2 study`), or copy the whole folder again."


@dataclass(frozen=True)
class Question:
    """One question about an item: one of ``choices``, or a whole number from ``minimum`` to ``maximum``.

    Parameters
    ----------
    name : by which answers refer to it, for example ``overall``
    text : what participants read
    choices : ``left``, ``none`` (unless the choice is forced), ``right``; empty for a rating
    minimum, maximum : of a rating
    lowest, highest : what the ends of the scale mean
    """

    name: str
    text: str
    choices: tuple[str, ...] = ()
    minimum: int = 0
    maximum: int = 0
    lowest: str = ""
    highest: str = ""

    def allows(self, value) -> bool:
        """Whether a value is an answer to this question."""
        if self.choices:
            return isinstance(value, str) and value in self.choices
        return isinstance(value, int) and not isinstance(value, bool) and self.minimum <= value <= self.maximum


@dataclass(frozen=True)
class Item:
    """One step of a participation.

    Parameters
    ----------
    id : random
    role : ``practice``, ``item`` or ``attention``
    stimuli : names of files in ``media``; two of a preference item, the same pair in both orders
    seconds : duration of each of them
    """

    id: str
    role: str
    stimuli: tuple[str, ...]
    seconds: float


@dataclass(frozen=True)
class SoundCheck:
    """A spoken word that participants must recognise before the first video.

    Parameters
    ----------
    stimulus : name of a file in ``media``
    choices : words to choose from
    answer : the one that is spoken
    """

    stimulus: str
    choices: tuple[str, ...]
    answer: str


@dataclass(frozen=True)
class Study:
    """What participants see of a study.

    Parameters
    ----------
    name : of the study, for example ``fan2015``
    kind : ``preference`` or ``rating``
    title, introduction, consent : texts of the first page; paragraphs are divided by blank lines
    questions : asked about every item
    items : in no order that tells anything
    sound_check : None where there is none
    digest : of all of this; databases of answers keep it
    """

    name: str
    kind: str
    title: str
    introduction: str
    consent: str
    questions: tuple[Question, ...]
    items: tuple[Item, ...]
    sound_check: SoundCheck | None = None
    digest: str = ""

    @property
    def forced(self) -> bool:
        """Whether a preference study has no answer `no difference`."""
        return self.kind == PREFERENCE and NONE not in self.questions[0].choices

    def of_role(self, role: str) -> tuple[Item, ...]:
        """The items of one role."""
        return tuple(one for one in self.items if one.role == role)

    def item(self, name: str) -> Item:
        """The item of an id; raises KeyError."""
        return {one.id: one for one in self.items}[name]


@dataclass(frozen=True)
class Condition:
    """What is compared: a model of a system, or what was recorded (``model`` is then empty)."""

    name: str
    title: str
    system: str
    model: str


@dataclass(frozen=True)
class Stimulus:
    """One file: an utterance, and its condition, or those on the left and on the right."""

    item: str
    utterance: str
    conditions: tuple[str, ...]


@dataclass(frozen=True)
class Key:
    """What the stimuli of a study are.

    Parameters
    ----------
    study : digest of the study that it belongs to
    corpus : name of the corpus
    split : hash of the split of the corpus (:func:`visualspeech.provenance.split_hash`)
    seed : of the choice of utterances and of all ids
    published : name of the published figures to show beside the results; may be empty
    conditions : in the order of the settings
    stimuli : by the name of the file, without its folder
    expected : attention item -> question -> the answer that it asks for, as on the screen
    """

    study: str
    corpus: str
    split: str
    seed: int
    published: str
    conditions: tuple[Condition, ...]
    stimuli: Mapping[str, Stimulus]
    expected: Mapping[str, Mapping[str, str | int]] = field(default_factory=dict)

    def shown(self, study: Study, answer: "Answer") -> Stimulus:
        """What an answer is about; raises KeyError where the item is not of this study."""
        return self.stimuli[study.item(answer.item).stimuli[answer.mirrored]]

    def preferred(self, study: Study, answer: "Answer") -> str:
        """Name of the condition that an answer of a preference study prefers; ``none`` for no difference."""
        if answer.value == NONE:
            return NONE
        left, right = self.shown(study, answer).conditions
        return left if answer.value == LEFT else right


@dataclass(frozen=True)
class Participant:
    """A participant; times are UTC in ISO 8601, empty where a step was not reached."""

    id: int
    code: str
    simulated: bool
    started: str
    consented: str
    sound_checked: str
    finished: str


@dataclass(frozen=True)
class Answer:
    """One answer.

    Parameters
    ----------
    participant : ``id`` of the participant
    item, question : what was asked
    value : ``left``, ``none`` or ``right`` as on the screen, or a whole number
    position : of the item among all that the participant saw, from 0; the practice item is the first
    mirrored : index of the stimulus of the item that was shown
    played_to_end : whether the video was played to its end before
    stored_at : UTC in ISO 8601
    """

    participant: int
    item: str
    question: str
    value: str | int
    position: int
    mirrored: int
    played_to_end: bool
    stored_at: str


def write_study(folder: str | Path, study: Study) -> Study:
    """Write ``study.json``; returns the study with its digest."""
    plain = {name: value for name, value in asdict(study).items() if name != "digest"}
    plain = json.loads(json.dumps({"version": VERSION, **plain}))
    write_text(Path(folder, STUDY), json.dumps(plain, indent=1, ensure_ascii=False) + "\n")
    return read_study(folder)


def read_study(folder: str | Path) -> Study:
    """The study in a folder.

    Raises
    ------
    StorageError
        The folder holds no study, or its description is damaged.
    """
    path = Path(folder, STUDY)
    if not path.is_file():
        raise StorageError(
            f"{folder} holds no study: there is no {STUDY}. Give the folder of a study, for example "
            "results/demo/studies/fan2015; `snakemake --cores 2 study` makes it."
        )
    plain = _plain(path, STUDY_SCHEMA)
    sound = plain["sound_check"]
    study = Study(
        name=plain["name"],
        kind=plain["kind"],
        title=plain["title"],
        introduction=plain["introduction"],
        consent=plain["consent"],
        questions=tuple(Question(**{**one, "choices": tuple(one["choices"])}) for one in plain["questions"]),
        items=tuple(Item(**{**one, "stimuli": tuple(one["stimuli"])}) for one in plain["items"]),
        sound_check=sound and SoundCheck(**{**sound, "choices": tuple(sound["choices"])}),
        digest=digest(plain),
    )
    if len({one.id for one in study.items}) < len(study.items) or not study.of_role(ITEM):
        raise DamagedFile(path, "two items have one id, or there is none", REMEDY)
    return study


def write_key(folder: str | Path, key: Key) -> None:
    """Write ``key.json``."""
    write_text(Path(folder, KEY), json.dumps({"version": VERSION, **asdict(key)}, indent=1, ensure_ascii=False) + "\n")


def read_key(folder: str | Path) -> Key:
    """The key of a study.

    Raises
    ------
    StorageError
        It is missing, damaged, or of another study.
    """
    path, study = Path(folder, KEY), read_study(folder)
    plain = _plain(path, KEY_SCHEMA)
    if plain["study"] != study.digest:
        raise DataError(f"{path} is not the key of {Path(folder, STUDY)}: they were made at different times. {REMEDY}")
    named = {file for one in study.items for file in one.stimuli}
    stimuli = {
        name: Stimulus(**{**one, "conditions": tuple(one["conditions"])}) for name, one in plain["stimuli"].items()
    }
    if missing := sorted(named - set(stimuli)):
        raise DamagedFile(path, f"it does not say what {missing[0]} is", REMEDY)
    conditions = tuple(Condition(**one) for one in plain["conditions"])
    rest = {name: plain[name] for name in ("study", "corpus", "split", "seed", "published", "expected")}
    return Key(**rest, conditions=conditions, stimuli=stimuli)


def _plain(path: Path, schema: Mapping):
    try:
        plain = parse_plain(read_text(path))
    except (ValueError, RecursionError) as error:
        raise DamagedFile(path, "it is no JSON", REMEDY) from error
    try:
        check_plain(path, plain, schema)
    except DamagedFile as error:
        raise DamagedFile(path, error.reason, REMEDY) from error
    return plain


def is_answered(folder: str | Path) -> bool:
    """Whether people have taken part in the study of a folder; also where their answers cannot be read."""
    path = Path(folder, ANSWERS)
    if not path.is_file():
        return False
    try:
        with closing(_opened(path)) as database:
            return bool(database.execute("SELECT count(*) FROM participants").fetchone()[0])
    except sqlite3.Error:
        return True


def read_participants(folder: str | Path, simulated: bool = False) -> tuple[Participant, ...]:
    """All participants, in the order in which they started; none where nobody did. Raises as :func:`read_answers`."""
    columns = "id, code, simulated, started, consented, coalesce(sound_checked, ''), coalesce(finished, '')"
    rows = _rows(folder, simulated, f"SELECT {columns} FROM participants ORDER BY id")
    return tuple(Participant(number, code, bool(made), *times) for number, code, made, *times in rows)


def read_answers(folder: str | Path, simulated: bool = False) -> tuple[Answer, ...]:
    """All answers, by participant and position; none where nobody has answered. A running server does not disturb.

    Parameters
    ----------
    simulated : whether to read those of simulated participants, which lie in a database of their own

    Raises
    ------
    StorageError
        The database cannot be read.
    DataError
        It belongs to another version of the study.
    """
    numeric = {one.name for one in read_study(folder).questions if not one.choices}
    columns = "participant, item, question, value, position, mirrored, played_to_end, stored_at"
    rows = _rows(folder, simulated, f"SELECT {columns} FROM answers ORDER BY participant, position, question")
    return tuple(
        Answer(number, item, question, int(value) if question in numeric else value, position, mirrored, bool(end), at)
        for number, item, question, value, position, mirrored, end, at in rows
    )


def _rows(folder: str | Path, simulated: bool, query: str) -> list[tuple]:
    path = Path(folder, SIMULATED_ANSWERS if simulated else ANSWERS)
    study = read_study(folder)
    if not path.is_file():
        return []
    try:
        with closing(_opened(path)) as database:
            check_database(path, database, study, simulated)
            return database.execute(query).fetchall()
    except (sqlite3.Error, ValueError) as error:
        raise StorageError(f"cannot read {path}: {error}. Restore it from a copy, or move it away.") from error


def _opened(path: Path) -> sqlite3.Connection:
    """A database opened for reading, without a trace; also one in a folder that cannot be written."""
    address = path.absolute().as_uri()
    if not Path(f"{path}-wal").exists():  # no server has it open, and nothing is outside the one file
        return sqlite3.connect(f"{address}?mode=ro&immutable=1", uri=True)
    try:
        database = sqlite3.connect(f"{address}?mode=ro", uri=True)
        database.execute("SELECT count(*) FROM sqlite_master")
    except sqlite3.OperationalError:
        database = sqlite3.connect(f"{address}?mode=ro&immutable=1", uri=True)
    return database


def check_database(path: Path, database: sqlite3.Connection, study: Study, simulated: bool) -> None:
    """Check that a database holds answers to this very study, of people or simulated ones.

    Raises
    ------
    DataError
        It does not.
    """
    found = database.execute("SELECT digest, simulated FROM study").fetchall()
    if found != [(study.digest, int(simulated))]:
        whose = "simulated participants" if simulated else "people"
        raise DataError(
            f"{path} does not hold answers of {whose} to this study: the study was made again since, or files of two "
            "studies were mixed. Put the folder back together, or move the file away."
        )
