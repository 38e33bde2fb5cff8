"""The commands, as a user gives them: messages, the first line of output, SIGKILL, and rehearsals."""

import os
import random
import re
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

from tests.paths import REPOSITORY
from tests.unit.study import studies
from tests.unit.study.visitors import Client
from visualspeech.cli import main
from visualspeech.study.layouts import RATING
from visualspeech.study.records import read_answers, read_key, read_participants, read_study
from visualspeech.study.simulation import Behaviour, simulate

COMMAND = [sys.executable, "-m", "visualspeech", "study"]


@pytest.fixture
def folder(tmp_path):
    return studies.make(tmp_path / "study", seconds=0.2)


def said(capsys, *arguments):
    """Exit status and what is said on standard error."""
    try:
        status = main(["study", *map(str, arguments)])
    except SystemExit as left:
        status = left.code
    return status, capsys.readouterr().err


def started(folder, *options):
    """A server process and its address."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(REPOSITORY), os.environ.get("PYTHONPATH", "")])}
    process = subprocess.Popen(
        [*COMMAND, "serve", folder, "--port", "0", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=environment,
    )  # fmt: skip
    first = process.stdout.readline()
    address = re.match(r"Open (http://127\.0\.0\.1:\d+/) in a browser", first)
    assert address, first + process.stderr.read()
    return process, address[1]


def test_what_cannot_be_served_is_said_in_one_sentence(folder, tmp_path, capsys):
    status, message = said(capsys, "serve", tmp_path / "none")
    assert status == 1 and "holds no study: there is no study.json" in message and message.count("\n") == 1
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        status, message = said(capsys, "serve", folder, "--port", port)
    assert status == 2 and f"--port {port} is in use" in message and message.count("\n") == 1
    for option, value, expected in (
        ("--port", 70000, "--port 70000: give a number"),
        ("--host", "no such host", "no such address"),
        ("--host", "192.0.2.1", "cannot listen at 192.0.2.1"),
    ):
        status, message = said(capsys, "serve", folder, option, value)
        assert status == 2 and expected in message and message.count("\n") == 1
    stimulus = folder / "media" / read_study(folder).items[0].stimuli[0]
    stimulus.unlink()
    status, message = said(capsys, "serve", folder)
    assert status == 1 and str(stimulus) in message and message.count("\n") == 1


def test_a_folder_that_cannot_be_used_is_named(folder, capsys):
    (folder / "answers.sqlite").write_bytes(b"something else" * 100)
    status, message = said(capsys, "serve", folder, "--port", 0)
    assert status == 1 and "answers.sqlite" in message and "Traceback" not in message
    assert (folder / "answers.sqlite").read_bytes().startswith(b"something else")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--participants", "0"], "--participants 0: give 1 to 10000"),
        (["--preference", "a"], "--preference a: give CONDITION=NUMBER"),
        (["--preference", "a=x"], "give CONDITION=NUMBER"),
        (["--preference", "c=1"], "'c' is not in the study small; it has a, b, none"),
        (["--preference", "a=0.5"], "the shares add to 0.5"),
        (["--rating", "a=5"], "--rating: the study small has no such question"),
        (["--careless", "15", "--quitting", "15"], "together are more than --participants"),
    ],
)
def test_a_wrong_simulation_is_refused(folder, capsys, options, message):
    status, text = said(capsys, "simulate", folder, *options)
    assert status == 2 and message in text and text.count("\n") == 1
    assert not (folder / "answers.simulated.sqlite").exists()


def test_a_simulation_recovers_what_is_stated(folder, capsys):
    shares = ("a=61.5", "none=15.5", "b=23")
    options = [part for share in shares for part in ("--preference", share)]
    assert (
        said(capsys, "simulate", folder, "--participants", 60, "--seed", 5, *options, "--careless", 3, "--quitting", 2)[
            0
        ]
        == 0
    )
    study, key = read_study(folder), read_key(folder)
    people = read_participants(folder, simulated=True)
    assert len(people) == 60 and all(one.simulated for one in people) and read_answers(folder) == ()
    assert sum(not one.finished for one in people) == 2
    answers = read_answers(folder, simulated=True)
    assert len({(one.participant, one.item, one.question) for one in answers}) == len(answers)
    failed = [one for one in answers if one.item == "t0" and one.value != key.expected["t0"]["preference"]]
    assert len(failed) == 3
    given = [key.preferred(study, one) for one in answers if one.item.startswith("i")]
    assert len(given) > 170
    for name, share in (("a", 0.615), ("none", 0.155), ("b", 0.23)):
        assert given.count(name) / len(given) == pytest.approx(share, abs=0.12)
    # Mirrored pairs are as many as others, and the sides tell nothing.
    sides = [one.mirrored for one in answers if one.item.startswith("i")]
    assert abs(sum(sides) / len(sides) - 0.5) < 0.05
    assert said(capsys, "simulate", folder, "--participants", 1, "--replace")[0] == 0
    assert len(read_participants(folder, simulated=True)) == 1


def test_simulated_ratings_have_the_stated_means(tmp_path):
    folder = studies.make(tmp_path / "study", RATING, sentences=4, seconds=0.2)
    simulate(folder, 20, Behaviour(means={"a": 7.0, "b": 3.0}))
    study, key = read_study(folder), read_key(folder)
    ratings = {"a": [], "b": []}
    for one in read_answers(folder, simulated=True):
        if one.item.startswith("i"):
            ratings[key.shown(study, one).conditions[0]].append(one.value)
    means = {name: sum(values) / len(values) for name, values in ratings.items()}
    # With the same seed, the same answers, whoever of the participants comes first.
    simulate(folder, 20, Behaviour(means={"a": 7.0, "b": 3.0}), at_once=3, replace=True)
    again = {"a": [], "b": []}
    for one in read_answers(folder, simulated=True):
        if one.item.startswith("i"):
            again[key.shown(study, one).conditions[0]].append(one.value)
    assert {name: sorted(values) for name, values in again.items()} == {
        name: sorted(values) for name, values in ratings.items()
    }
    assert means == pytest.approx({"a": 7.0, "b": 3.0}, abs=0.5) and len(ratings["a"]) == 240


def test_the_first_line_names_the_address_and_a_signal_ends_the_server(folder):
    process, address = started(folder)
    client = Client(address)
    code = client.begin()
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=20) == 130
    assert process.stderr.read() == f"visualspeech: stopped; the answers are in {folder / 'answers.sqlite'}.\n"
    # All is in the one file, which can be copied.
    assert [path.name for path in folder.glob("answers*")] == ["answers.sqlite"]
    assert [one.code for one in read_participants(folder)] == [code]


def test_a_rehearsal_by_hand_is_marked(folder):
    process, address = started(folder, "--rehearse")
    try:
        assert "Rehearsal" in process.stdout.readline()
        Client(address).begin()
    finally:
        process.terminate()
        process.wait(timeout=20)
    assert read_participants(folder) == () and read_participants(folder, simulated=True)[0].simulated


@pytest.mark.parametrize("seed", range(3))
def test_what_was_told_to_be_stored_survives_sigkill(folder, seed):
    """Several participants answer while the server is killed; every confirmed answer is there."""
    process, address = started(folder, "--rehearse")
    confirmed, begun = set(), threading.Event()

    def participate():
        client = Client(address)
        try:
            while True:
                code = client.begin()
                while (page := client.page(code)).kind == "item":
                    if client.answer(code, page.item, {"preference": "left"})[0] == 200:
                        confirmed.add((code, page.item))
                        begun.set()
        except Exception:  # the server is gone
            return

    threads = [threading.Thread(target=participate) for _ in range(4)]
    for thread in threads:
        thread.start()
    assert begun.wait(30)
    time.sleep(random.Random(seed).uniform(0.05, 0.8))
    process.kill()
    process.wait()
    for thread in threads:
        thread.join(timeout=30)
    codes = {one.id: one.code for one in read_participants(folder, simulated=True)}
    stored = [(codes[one.participant], one.item) for one in read_answers(folder, simulated=True)]
    assert confirmed and confirmed <= set(stored) and len(set(stored)) == len(stored)
    # The next server continues with them.
    process, address = started(folder, "--rehearse")
    code = next(iter(confirmed))[0]
    assert Client(address).page(code).done == sum(own == code for own, _ in stored)
    process.kill()
    process.wait()


def test_without_the_extra_its_installation_is_named(folder, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "starlette", None)
    status, message = said(capsys, "serve", folder)
    assert status == 2 and "pip install" in message and ".[study]" in message
