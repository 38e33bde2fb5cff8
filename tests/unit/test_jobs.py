"""A job's log is whole, and its errors speak to people."""

import logging
import os

import pytest

from visualspeech import jobs
from visualspeech.errors import CorpusError


@pytest.fixture(autouse=True)
def quiet():
    """Give the logger back as it was."""
    handlers, level, propagate = list(jobs.log.handlers), jobs.log.level, jobs.log.propagate
    yield
    for handler in jobs.log.handlers:
        if handler not in handlers:
            handler.close()
    jobs.log.handlers[:], jobs.log.propagate = handlers, propagate
    jobs.log.setLevel(level)


def test_messages_go_to_the_terminal_and_to_the_log(tmp_path, capsys):
    with jobs.job(tmp_path / "logs" / "align.log"):
        jobs.log.info("hello")
    assert "hello" in (tmp_path / "logs" / "align.log").read_text()
    assert "align: hello" in capsys.readouterr().err


def test_an_error_for_a_person_has_no_traceback(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended, jobs.job(tmp_path / "x.log"):
        raise CorpusError("no recordings in /nowhere. Set `root:`.")
    shown = capsys.readouterr().err
    assert ended.value.code == 1
    assert "no recordings in /nowhere" in shown and "Traceback" not in shown
    assert "Traceback" not in (tmp_path / "x.log").read_text()


def test_a_defect_names_the_log_that_holds_its_traceback(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended, jobs.job(tmp_path / "x.log"):
        raise ZeroDivisionError("by zero")
    shown = capsys.readouterr().err
    assert ended.value.code == 1
    assert "x.log" in shown and "Traceback" not in shown
    assert "Traceback" in (tmp_path / "x.log").read_text()


def test_memory_that_runs_out_has_a_remedy(tmp_path, capsys):
    with pytest.raises(SystemExit), jobs.job(tmp_path / "x.log"):
        raise MemoryError
    assert "--cores" in capsys.readouterr().err


def test_progress_yields_all_and_says_how_far(caplog, monkeypatch):
    clock = iter(range(0, 1000, 2))
    monkeypatch.setattr(jobs.time, "monotonic", lambda: float(next(clock)))
    jobs.log.propagate = True
    with caplog.at_level(logging.INFO, "visualspeech"):
        assert list(jobs.progress("abcd", 4, "utterances", every=3.0)) == list("abcd")
    assert "2/4 utterances" in caplog.text and "4/4 utterances" in caplog.text and "0 s left" in caplog.text
    assert "1/4" not in caplog.text


def test_progress_of_nothing_is_silent(caplog):
    assert list(jobs.progress([], 0, "frames")) == []
    assert not caplog.records


def test_jobs_inherit_one_thread_and_the_library(monkeypatch):
    from visualspeech.jobs import THREAD_VARIABLES, settle_environment

    for name in (*THREAD_VARIABLES, "PYTHONPATH"):
        monkeypatch.setenv(name, "/elsewhere" if name == "PYTHONPATH" else "8")
    settle_environment("/library")
    settle_environment("/library")
    assert {os.environ[name] for name in THREAD_VARIABLES} == {"1"}
    assert os.environ["PYTHONPATH"] == os.pathsep.join(["/library", "/elsewhere"])
