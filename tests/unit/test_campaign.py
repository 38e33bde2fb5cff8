"""A short seeded campaign of every kind: each attempt is used, or refused with a sentence; nothing is lost."""

import importlib
import socket

import pytest

#: Attempts of each kind; the long campaign is ``python -m tests.campaign``.
CASES = {"media": 60, "names": 100, "tables": 80, "states": 100, "commands": 25, "settings": 60, "speakers": 60}


@pytest.fixture
def no_network(monkeypatch):
    """Any connection that Python code opens fails the test."""

    def connect(*arguments):
        raise AssertionError(f"a connection was opened: {arguments[1:]}")

    monkeypatch.setattr(socket.socket, "connect", connect)


@pytest.mark.parametrize("kind", CASES)
def test_attempts_to_break_it_are_answered(kind, tmp_path, no_network):
    results = importlib.import_module(f"tests.campaign.{kind}").run(tmp_path, 7, CASES[kind])
    assert len(results) >= 0.9 * CASES[kind]  # two equal names are one file
    assert [f"{one.case}: {one.wrong}" for one in results if one.wrong] == []
    # Both answers occur, so that the campaign would notice if all were refused, or nothing.
    assert {one.refused for one in results} == {True, False}
