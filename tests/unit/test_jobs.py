"""A job's log is whole, and its errors speak to people."""

import logging
import os
import signal
import subprocess
import sys
import threading

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


def test_a_quiet_job_shows_warnings_and_errors_and_logs_everything(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv(jobs.QUIET, "1")
    with pytest.raises(SystemExit), jobs.job(tmp_path / "x.log"):
        jobs.log.info("hello")
        jobs.log.warning("odd")
        raise CorpusError("no recordings")
    shown = capsys.readouterr().err
    assert "hello" not in shown and "odd" in shown and "no recordings" in shown
    assert "hello" in (tmp_path / "x.log").read_text()
    jobs.settle_quiet(False)
    with jobs.job(tmp_path / "x.log"):
        jobs.log.info("hello")
    assert "hello" in capsys.readouterr().err


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


FULL = """
import os, resource, signal, sys
from visualspeech.jobs import job, log
from visualspeech.errors import StorageError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
with job(sys.argv[1]):
    log.info("begun")
    {error}
"""


@pytest.mark.parametrize(
    ("error", "said"),
    [
        ("raise StorageError('cannot write x: the disk is full.')", "cannot write x: the disk is full."),
        ("raise OSError(28, 'No space left on device', 'y')", "cannot write y: No space left on device. Free space"),
        ("raise ZeroDivisionError('a defect')", "unexpected error: ZeroDivisionError('a defect')"),
    ],
)
@pytest.mark.parametrize("log", ["logs/x.log", "file/x.log", "/dev/full"])
def test_a_log_that_cannot_be_written_hides_no_message(tmp_path, error, said, log):
    """A full disk (the limit on file sizes stands for it), a folder that cannot be made, a device that is full."""
    (tmp_path / "file").write_text("")
    ran = subprocess.run(
        [sys.executable, "-c", FULL.format(error=error), str(tmp_path / log)], capture_output=True, text=True
    )
    assert ran.returncode == 1
    assert said in ran.stderr and "Traceback" not in ran.stderr and "begun" in ran.stderr
    assert len(ran.stderr.splitlines()) == (3 if log == "file/x.log" else 2)


def test_ctrl_c_while_planning_is_one_line():
    code = "from visualspeech.jobs import settle_messages; settle_messages(); raise {}"
    for error, lines in (("KeyboardInterrupt", 1), ("ValueError", 4)):
        ran = subprocess.run([sys.executable, "-c", code.format(error)], capture_output=True, text=True)
        assert ran.returncode and len(ran.stderr.splitlines()) <= lines
        assert ("run the same command again" in ran.stderr) == (error == "KeyboardInterrupt")
        assert ("Traceback" in ran.stderr) == (error == "ValueError")


def test_sigterm_does_not_wait_for_a_lock_of_the_code_that_it_interrupts():
    lock, answered = threading.Lock(), threading.Event()

    def handler(*_):
        with lock:
            answered.set()

    before = signal.signal(signal.SIGTERM, handler)
    try:
        jobs.settle_sigterm()
        with lock:
            signal.raise_signal(signal.SIGTERM)  # without the thread, the handler would wait here for ever
        assert answered.wait(10)
    finally:
        signal.signal(signal.SIGTERM, before)


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
