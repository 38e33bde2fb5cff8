"""Simulated participants, who answer through the web interface with stated preferences.

A rehearsal shows that a study runs and that its evaluation recovers what is known to be true. Its answers are marked as
simulated and kept in a database of their own.
"""

import http.client
import json
import math
import random
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlencode, urlsplit

import numpy as np

from visualspeech.errors import SettingError, StorageError
from visualspeech.study.layouts import LEFT, NONE, PREFERENCE, RIGHT
from visualspeech.study.records import SIMULATED_ANSWERS, Key, Question, Study, read_key
from visualspeech.study.server import Server, checked_study

#: Ratings of one video by one participant vary together: the larger, the less (a beta distribution's a + b).
AGREEMENT = 6.0
TRIES = 5


@dataclass(frozen=True)
class Behaviour:
    """How simulated participants answer.

    Parameters
    ----------
    shares : of the answers of a preference study, by condition and ``none``; empty: equal ones
    means : mean rating by condition; empty: spread evenly over the inner half of the scale
    careless, quitting : how many participants fail all attention items, and how many stop half-way
    """

    shares: Mapping[str, float] = field(default_factory=dict)
    means: Mapping[str, float] = field(default_factory=dict)
    careless: int = 0
    quitting: int = 0


class Simulated(NamedTuple):
    """What a simulation made: number of stored answers, the database, and the seconds that each page took."""

    answers: int
    path: Path
    seconds: tuple[float, ...]


def stated(given: Sequence[str], option: str) -> dict[str, float]:
    """Numbers by condition, of texts ``CONDITION=NUMBER``; raises :class:`SettingError`."""
    numbers = {}
    for one in given:
        name, _, text = one.rpartition("=")
        try:
            numbers[name] = float(text.removesuffix("%"))
        except ValueError:
            name = ""
        if not name or not math.isfinite(numbers[name]) or numbers[name] < 0:
            raise SettingError(f"{option} {one[:80]}: give CONDITION=NUMBER, for example FBB-128=0.6.")
    return numbers


def checked_behaviour(behaviour: Behaviour, study: Study, key: Key) -> Behaviour:
    """A behaviour that fits a study, with shares that add to 1 and all means.

    Raises
    ------
    SettingError
        It names a condition that the study does not have, or its numbers are impossible.
    """
    names = [one.name for one in key.conditions]
    preference = study.kind == PREFERENCE
    if (behaviour.means if preference else behaviour.shares) or (behaviour.careless and not key.expected):
        option = ("--rating" if preference else "--preference") if not behaviour.careless else "--careless"
        lacks = "attention items" if behaviour.careless and not key.expected else "such question"
        raise SettingError(f"{option}: the study {study.name} has no {lacks}; leave it out.")
    known = [*names, *([NONE] if preference and not study.forced else [])]
    for name in (*behaviour.shares, *behaviour.means):
        if name not in known:
            raise SettingError(f"{name[:80]!r} is not in the study {study.name}; it has {', '.join(known)}.")
    if preference:
        shares = {name: behaviour.shares.get(name, 0.0) for name in known} if behaviour.shares else {}
        total = sum(shares.values())
        if shares and not (math.isclose(total, 1, abs_tol=1e-6) or math.isclose(total, 100, abs_tol=1e-4)):
            raise SettingError(f"--preference: the shares add to {total:g}; they must add to 1 or to 100 %.")
        shares = {name: share / total for name, share in shares.items()} or dict.fromkeys(known, 1 / len(known))
        return Behaviour(shares, {}, behaviour.careless, behaviour.quitting)
    low = max(one.minimum for one in study.questions)
    high = min(one.maximum for one in study.questions)
    inner = np.linspace(0.75 * low + 0.25 * high, 0.25 * low + 0.75 * high, len(names))
    means = dict(zip(names, inner[::-1].tolist(), strict=True)) | dict(behaviour.means)
    if wrong := [name for name, mean in means.items() if not low <= mean <= high]:
        raise SettingError(f"--rating {wrong[0]}={means[wrong[0]]:g}: a mean lies between {low} and {high}.")
    return Behaviour({}, means, behaviour.careless, behaviour.quitting)


def simulate(
    folder: str | Path,
    participants: int,
    behaviour: Behaviour,
    seed: int = 1,
    at_once: int = 10,
    replace: bool = False,
) -> Simulated:
    """Serve a study at a free port of this computer and let simulated participants answer.

    Parameters
    ----------
    at_once : number of participants at the same time
    replace : whether answers of earlier simulations are deleted

    Raises
    ------
    SettingError, StorageError, DataError
        The study or the behaviour is wrong, or the answers could not be stored.
    """
    study, key = checked_study(folder), read_key(folder)
    behaviour = checked_behaviour(behaviour, study, key)
    path = Path(folder, SIMULATED_ANSWERS)
    if replace:
        for suffix in ("", "-wal", "-shm"):
            Path(f"{path}{suffix}").unlink(missing_ok=True)
    server = Server(folder, port=0, simulated=True)
    stop = server.in_background()
    try:
        return simulate_at(server.address, study, key, participants, behaviour, seed, at_once, path)
    finally:
        stop()


def simulate_at(
    address: str,
    study: Study,
    key: Key,
    participants: int,
    behaviour: Behaviour,
    seed: int,
    at_once: int,
    path: Path,
    pause: float = 0.0,
) -> Simulated:
    """As :func:`simulate`, at a server of simulated answers that runs; about ``pause`` seconds lie before an answer."""

    def visit(number: int) -> "Visitor":
        # The careless come first, then those who quit, in the order in which they start.
        careless = number < behaviour.careless
        quits = not careless and number < behaviour.careless + behaviour.quitting
        visitor = Visitor(address, study.sound_check.answer if study.sound_check else "", pause)

        def answers(page: Page) -> dict:
            # Not one generator for all items: which order a participant gets depends on who comes first.
            generator = np.random.default_rng([seed, number, *page.item.encode()])
            return choose(page, study, key, behaviour, generator, careless)

        visitor.participate(answers, quits)
        return visitor

    with ThreadPoolExecutor(at_once) as pool:
        visitors = list(pool.map(visit, range(participants)))
    seconds = tuple(one for visitor in visitors for one in visitor.seconds)
    return Simulated(sum(visitor.answers for visitor in visitors), path, seconds)


def choose(page: "Page", study: Study, key: Key, behaviour: Behaviour, generator, careless: bool) -> dict:
    """The answers of one simulated participant to the item of a page: question -> value."""
    if page.item in key.expected and not careless:
        return dict(key.expected[page.item])
    if page.item in key.expected:
        expected = key.expected[page.item]
        return {one.name: _other(one, expected[one.name], generator) for one in study.questions}
    conditions = key.stimuli[page.stimulus].conditions
    if study.kind == PREFERENCE:
        names = list(behaviour.shares)
        chosen = names[generator.choice(len(names), p=[behaviour.shares[name] for name in names])]
        value = NONE if chosen == NONE else (LEFT if conditions[0] == chosen else RIGHT)
        return {one.name: value for one in study.questions}
    (condition,) = conditions
    low, high = study.questions[0].minimum, study.questions[0].maximum
    share = (behaviour.means[condition] - low) / (high - low)
    if 0 < share < 1:
        share = generator.beta(AGREEMENT * share, AGREEMENT * (1 - share))
    return {
        one.name: int(one.minimum + generator.binomial(one.maximum - one.minimum, share)) for one in study.questions
    }


def _other(question: Question, expected, generator):
    """An answer that is not the expected one."""
    every = question.choices or range(question.minimum, question.maximum + 1)
    others = [one for one in every if one != expected]
    return others[generator.integers(len(others))]


class Page(HTMLParser):
    """What a simulated participant reads in a page: its kind, item, stimulus, progress, and the first page's ticket."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.kind = self.item = self.stimulus = self.ticket = self.code = ""
        self.done = self.total = 0
        self.feed(text)

    def handle_starttag(self, tag: str, attrs) -> None:
        given = dict(attrs)
        if tag == "body":
            self.kind, self.item = given.get("data-page", ""), given.get("data-item", "")
            self.code = given.get("data-code", "")
        elif tag == "progress" and "id" not in given:  # not that of the video
            self.done, self.total = int(given["value"]), int(given["max"])
        elif tag == "video":
            self.stimulus = given["src"].rpartition("/")[2]
        elif tag == "input" and given.get("name") == "ticket":
            self.ticket = given["value"]


class Visitor:
    """A simulated participant: a connection, the seconds that its pages took, and the number of stored answers.

    Parameters
    ----------
    address : of the server
    word : of the sound check; empty where the study has none
    pause : average number of seconds before each answer
    """

    def __init__(self, address: str, word: str = "", pause: float = 0.0) -> None:
        parts = urlsplit(address)
        self._connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=60)
        self.seconds: list[float] = []
        self.answers, self.code, self.word, self.pause = 0, "", word, pause

    def participate(self, answer, quits: bool = False) -> None:
        """Take part from the first page to the last; ``quits``: stop half-way. ``answer`` maps a page to its answers.

        Raises
        ------
        StorageError
            The server did not store an answer, or cannot be reached.
        """
        ticket = Page(self.get("/")).ticket
        page = Page(self.post_form("/participants", {"consent": "yes", "ticket": ticket}))
        self.code = page.code
        while page.kind != "done" and not (quits and 2 * page.done >= page.total):
            path = f"/p/{self.code}"
            if page.kind == "sound":
                page = Page(self.post_form(f"{path}/sound", {"word": self.word}))
                continue
            time.sleep(self.pause * random.uniform(0.5, 1.5))
            values = answer(page)
            reply = self.post_json(f"{path}/answers", {"item": page.item, "played": True, "answers": values})
            self.answers += len(values) if reply["stored"] else 0
            page = Page(self.get(path))

    def get(self, path: str) -> str:
        """The text of a page."""
        return self._request("GET", path)[1]

    def post_form(self, path: str, values: Mapping[str, str]) -> str:
        """The text of the page that a form leads to."""
        kind = {"Content-Type": "application/x-www-form-urlencoded"}
        return self._request("POST", path, urlencode(values).encode(), kind)[1]

    def post_json(self, path: str, values: Mapping) -> dict:
        """What the server says to answers."""
        kind = {"Content-Type": "application/json"}
        return json.loads(self._request("POST", path, json.dumps(values).encode(), kind)[1])

    def _request(self, method: str, path: str, body: bytes | None = None, headers=None) -> tuple[int, str]:
        for attempt in range(TRIES):
            begun = time.perf_counter()
            try:
                self._connection.request(method, path, body, headers or {})
                reply = self._connection.getresponse()
                text, place = reply.read().decode(), reply.getheader("Location")
            except (OSError, http.client.HTTPException) as error:
                self._connection.close()
                if attempt + 1 == TRIES:
                    raise StorageError(f"the server does not answer: {error}.") from error
                time.sleep(0.2 * 2**attempt)
                continue
            self.seconds.append(time.perf_counter() - begun)
            if reply.status == 303:
                return self._request("GET", place)
            if reply.status >= 400:
                raise StorageError(f"the server answered {reply.status} to {method} {path}: {_plain(text)}")
            return reply.status, text
        raise AssertionError


def _plain(text: str) -> str:
    return " ".join(text.split())[-300:]
