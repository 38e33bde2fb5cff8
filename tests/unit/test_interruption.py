"""A signal, or the death of its run, ends a process at once, in one line and without unfinished files."""

import os
import signal
import subprocess
import sys
import time

import pytest

from visualspeech.interruption import SIGNALS, stoppable

WRITES = """
import os, signal, sys, time
for number in (signal.SIGHUP, signal.SIGINT, signal.SIGTERM):
    signal.signal(number, signal.SIG_DFL)  # the tests may run where they are ignored
from visualspeech.jobs import job
from visualspeech.storage.files import replacing
path = sys.argv[1]
{before}
with job(path + ".log"), replacing(path) as folder:
    folder.mkdir()
    (folder / "half").write_text("")
    open(path + ".ready", "w").close()
    {work}
"""
BUSY = "while True: (folder / str(time.monotonic())).write_text('')"  # fails as soon as its folder is removed


def started(path, work=BUSY, before="", prefix=(), **env):
    return subprocess.Popen(
        [*prefix, sys.executable, "-c", WRITES.format(work=work, before=before), str(path)],
        stderr=subprocess.PIPE, text=True, env={**os.environ, **env},
    )  # fmt: skip


def wait_for(path):
    end = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < end
        time.sleep(0.01)


@pytest.mark.parametrize("work", [BUSY, "time.sleep(60)"])
@pytest.mark.parametrize("number", SIGNALS)
def test_a_signal_ends_a_job_in_one_line(tmp_path, number, work):
    process = started(tmp_path / "out", work)
    wait_for(tmp_path / "out.ready")
    process.send_signal(number)
    process.send_signal(number)
    _, shown = process.communicate(timeout=20)
    assert process.returncode == 128 + number
    assert len(shown.splitlines()) == 1 and "run the same command again to resume" in shown
    assert signal.Signals(number).name in (tmp_path / "out.log").read_text()
    assert sorted(os.listdir(tmp_path)) == ["out.log", "out.ready"]


def test_a_signal_while_the_script_imports_waits_until_it_can_be_answered(tmp_path):
    from visualspeech.jobs import shell_prefix

    block = shell_prefix().partition("exec ")[2].split()
    if not block:
        pytest.skip("env cannot block signals here")
    before = "open(path + '.importing', 'w').close(); time.sleep(0.5)"
    process = started(tmp_path / "out", before=before, prefix=block)
    wait_for(tmp_path / "out.importing")
    process.send_signal(signal.SIGINT)
    _, shown = process.communicate(timeout=20)
    assert process.returncode == 130 and "Traceback" not in shown and "resume" in shown


def test_an_ignored_signal_stays_ignored(tmp_path):
    before = "signal.signal(signal.SIGHUP, signal.SIG_IGN)"
    process = started(tmp_path / "out", work="time.sleep(0.5)", before=before)
    wait_for(tmp_path / "out.ready")
    process.send_signal(signal.SIGHUP)
    process.communicate(timeout=20)
    assert process.returncode == 0 and (tmp_path / "out" / "half").exists()


def test_a_job_ends_with_its_run(tmp_path):
    run = subprocess.Popen(["sleep", "60"])
    process = started(tmp_path / "out", VISUALSPEECH_RUN=str(run.pid))
    wait_for(tmp_path / "out.ready")
    assert process.poll() is None
    run.kill()  # nobody has waited for it yet
    _, shown = process.communicate(timeout=5)
    run.wait()
    assert process.returncode != 0 and "its run has ended" in shown and "Traceback" not in shown
    assert sorted(os.listdir(tmp_path)) == ["out.log", "out.ready"]


def test_a_job_whose_run_has_ended_does_not_begin(tmp_path):
    run = subprocess.Popen(["true"])
    run.wait()
    process = started(tmp_path / "out", VISUALSPEECH_RUN=str(run.pid))
    process.communicate(timeout=20)
    assert process.returncode != 0 and os.listdir(tmp_path) == []


def test_handlers_are_restored():
    before = [signal.getsignal(number) for number in SIGNALS]
    with stoppable(print):
        inside = [signal.getsignal(number) for number in SIGNALS]
        assert all(new != old or old == signal.SIG_IGN for new, old in zip(inside, before, strict=True))
    assert [signal.getsignal(number) for number in SIGNALS] == before
