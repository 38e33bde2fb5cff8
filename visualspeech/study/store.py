"""The database of answers: what it says is stored is on the disk, whenever the process is killed."""

import secrets
import sqlite3
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from visualspeech.errors import StorageError
from visualspeech.study.layouts import TABLES
from visualspeech.study.order import presentations
from visualspeech.study.records import ANSWERS, SIMULATED_ANSWERS, Item, Study, check_database

#: Characters of codes: none that are mistaken for others. 12 of them are 59 bits.
ALPHABET = "23456789abcdefghjkmnpqrstuvwxyz"
LENGTH = 12
#: Seconds by which a video may seem to end early: the clocks of browsers and the encoder's padding.
TOLERANCE = 0.3


class NotStored(Exception):
    """An answer could not be written: the disk is full, or the database cannot be reached."""


class Refused(Exception):
    """An answer that does not fit what the participant has to answer now; ``status`` is that of HTTP."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status, self.message = status, message


class Step(NamedTuple):
    """Where a participant is.

    Parameters
    ----------
    participant : id
    sound : whether the sound check comes now
    item : the one to answer now; None before the sound check has passed and after the end
    mirrored : index of the stimulus to show
    position : number of steps that are done
    total : number of all steps
    """

    participant: int
    sound: bool
    item: Item | None
    mirrored: int
    position: int
    total: int


class AnswerStore:
    """Participants and answers of a study. One connection, one writer at a time; every write is synchronised.

    Parameters
    ----------
    folder : of the study
    simulated : whether to use the database of simulated participants

    Raises
    ------
    StorageError
        The database cannot be opened or made.
    DataError
        It belongs to another version of the study.
    """

    def __init__(self, folder: str | Path, study: Study, simulated: bool = False) -> None:
        self.path = Path(folder, SIMULATED_ANSWERS if simulated else ANSWERS)
        self.study, self.simulated = study, simulated
        self._lock = threading.Lock()
        self._items = {one.id: one for one in study.items}
        self._questions = {one.name: one for one in study.questions}
        try:
            self._database = sqlite3.connect(self.path, timeout=10, isolation_level=None, check_same_thread=False)
            self._database.execute("PRAGMA journal_mode=WAL")
            self._database.execute("PRAGMA synchronous=FULL")
            self._database.execute("PRAGMA foreign_keys=ON")
            self._database.execute("BEGIN IMMEDIATE")
            if not self._database.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
                for statement in filter(str.strip, TABLES.split(";")):
                    self._database.execute(statement)
                self._database.execute("INSERT INTO study VALUES (?, ?)", (study.digest, int(simulated)))
            self._database.execute("COMMIT")
            check_database(self.path, self._database, study, simulated)
        except sqlite3.Error as error:
            raise StorageError(
                f"cannot use {self.path}: {error}. Check that the folder can be written, that the disk is not full and "
                "that the file is a database of answers; then run the same command again."
            ) from error

    def close(self) -> None:
        """Bring everything into the one file and close it."""
        if self._lock.acquire(timeout=5):
            try:
                self._database.close()
            finally:
                self._lock.release()

    def start(self, ticket: str) -> str:
        """The code of a new participant; the same one where a page sends its ticket again.

        Raises
        ------
        NotStored
            The participant could not be stored.
        """
        with self._writing() as database:
            known = database.execute("SELECT code FROM participants WHERE ticket = ?", (ticket,)).fetchone()
            if known:
                return known[0]
            code, now = "".join(secrets.choice(ALPHABET) for _ in range(LENGTH)), _now()
            row = (code, ticket, int(self.simulated), now, now)
            added = database.execute(
                "INSERT INTO participants (code, ticket, simulated, started, consented) VALUES (?, ?, ?, ?, ?)", row
            )
            number = added.lastrowid
            rows = [(number, position, *shown) for position, shown in enumerate(presentations(self.study, number - 1))]
            database.executemany(
                "INSERT INTO presentations (participant, position, item, mirrored) VALUES (?, ?, ?, ?)", rows
            )
        return code

    def step(self, code: str) -> Step | None:
        """Where a participant is; None for an unknown code."""
        with self._lock:
            return self._step(self._database, code)

    def open(self, step: Step) -> None:
        """Remember when an item was first shown, from which on its video can have been played."""
        query = "UPDATE presentations SET opened = ? WHERE participant = ? AND item = ? AND opened IS NULL"
        with self._lock:
            row = (step.participant, step.item.id)
            opened = self._database.execute(
                "SELECT opened FROM presentations WHERE participant = ? AND item = ?", row
            ).fetchone()
        if opened[0] is None:
            with self._writing() as database:
                database.execute(query, (time.time(), *row))

    def pass_sound(self, code: str) -> None:
        """Store that a participant hears the sound; raises :class:`NotStored`."""
        with self._writing() as database:
            database.execute(
                "UPDATE participants SET sound_checked = ? WHERE code = ? AND sound_checked IS NULL", (_now(), code)
            )

    def answer(self, code: str, item: str, values: Mapping[str, str | int], played: bool) -> None:
        """Store the answers to one item; the same answers may be sent again.

        Parameters
        ----------
        values : question -> answer
        played : whether the browser says that the video was played to its end

        Raises
        ------
        Refused
            The code or the item is unknown (404), the item is not the one to answer now, or already has another answer
            (409), or the answers are incomplete or outside the scale (422).
        NotStored
            They could not be stored; nothing was.
        """
        with self._writing() as database:
            step = self._step(database, code)
            if step is None or item not in self._items:
                raise Refused(404, "There is no such participant or video.")
            self._check_values(values)
            earlier = dict(
                database.execute(
                    "SELECT question, value FROM answers WHERE participant = ? AND item = ?", (step.participant, item)
                )
            )
            if earlier:
                if earlier == {name: str(value) for name, value in values.items()}:
                    return
                raise Refused(409, "This video has already been answered; the first answer counts.")
            if step.item is None or step.item.id != item:
                raise Refused(409, "It is not this video's turn.")
            (opened,) = database.execute(
                "SELECT opened FROM presentations WHERE participant = ? AND item = ?", (step.participant, item)
            ).fetchone()
            waited = opened is not None and time.time() - opened >= self._items[item].seconds - TOLERANCE
            # Simulated participants do not watch.
            if not played or not (waited or self.simulated):
                raise Refused(422, "Please play the video to its end first.")
            at = _now()
            database.executemany(
                "INSERT INTO answers VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                [
                    (step.participant, item, name, str(value), step.position, step.mirrored, 1, at)
                    for name, value in values.items()
                ],
            )
            if step.position + 1 == step.total:
                database.execute("UPDATE participants SET finished = ? WHERE id = ?", (at, step.participant))

    def _check_values(self, values: Mapping[str, str | int]) -> None:
        if set(values) != set(self._questions):
            raise Refused(422, "Please answer every question.")
        wrong = [name for name, question in self._questions.items() if not question.allows(values[name])]
        if wrong:
            raise Refused(422, f"The answer to the question {wrong[0]!r} is outside its scale.")

    def _step(self, database: sqlite3.Connection, code: str) -> Step | None:
        found = database.execute("SELECT id, sound_checked FROM participants WHERE code = ?", (code,)).fetchone()
        if found is None:
            return None
        number, heard = found
        total, done = database.execute(
            "SELECT (SELECT count(*) FROM presentations WHERE participant = ?1), "
            "(SELECT count(DISTINCT item) FROM answers WHERE participant = ?1)",
            (number,),
        ).fetchone()
        if self.study.sound_check and not heard:
            return Step(number, True, None, 0, done, total)
        row = database.execute(
            "SELECT item, mirrored FROM presentations WHERE participant = ? AND position = ?", (number, done)
        ).fetchone()
        item, mirrored = (self._items[row[0]], row[1]) if row else (None, 0)
        return Step(number, False, item, mirrored, done, total)

    @contextmanager
    def _writing(self) -> Iterator[sqlite3.Connection]:
        """A transaction that is on the disk when the block ends."""
        with self._lock:
            try:
                self._database.execute("BEGIN IMMEDIATE")
                yield self._database
                self._database.execute("COMMIT")
            except sqlite3.Error as error:
                self._roll_back()
                raise NotStored(str(error)) from error
            except BaseException:
                self._roll_back()
                raise

    def _roll_back(self) -> None:
        if self._database.in_transaction:
            try:
                self._database.execute("ROLLBACK")
            except sqlite3.Error:  # nothing was committed; the next transaction finds the database as it was
                pass


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
