"""Jobs on other machines end with their run; the profile asks first what the cluster has."""

import json
import os
import signal
import subprocess
import sys
import threading

import pytest

from visualspeech import cluster
from visualspeech.errors import StorageError
from visualspeech.jobs import LOCKS
from visualspeech.locks import hold, is_held, jobs_lock


@pytest.fixture
def ended():
    """Stands for the end of the process: an event that holds the status."""
    event = threading.Event()

    def end(status):
        event.status = status
        event.set()

    event.end = end
    return event


def follow(folders, run, ended, monkeypatch):
    monkeypatch.setenv(LOCKS, json.dumps([str(jobs_lock(folder)) for folder in folders]))
    monkeypatch.setenv(cluster.NAME, run)
    cluster.follow_run(ended.end, every=0.05)


def test_a_run_is_held_by_its_name_until_it_ends(tmp_path):
    assert not is_held(tmp_path, "a")
    held = hold(tmp_path, "a")
    assert is_held(tmp_path, "a") and not is_held(tmp_path, "b")
    held.close()
    assert not is_held(tmp_path, "a")
    with hold(tmp_path, "b"):
        assert is_held(tmp_path, "b") and not is_held(tmp_path, "a")


def test_a_refused_run_does_not_take_the_name(tmp_path):
    with hold(tmp_path, "first"):
        with pytest.raises(StorageError, match="another run"):
            hold(tmp_path, "second")
        assert is_held(tmp_path, "first")


def test_a_file_system_that_does_not_answer_ends_no_job(tmp_path, monkeypatch):
    hold(tmp_path, "a").close()

    def fail(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("visualspeech.locks.fcntl.flock", fail)
    assert is_held(tmp_path, "a")


def test_a_job_goes_on_while_its_run_holds_all_folders_and_ends_after_one(tmp_path, ended, monkeypatch, capfd):
    first, second = hold(tmp_path / "a", "run"), hold(tmp_path / "b", "run")
    follow([tmp_path / "a", tmp_path / "b"], "run", ended, monkeypatch)
    assert not ended.wait(0.3)
    second.close()
    assert ended.wait(5) and ended.status == 128 + signal.SIGTERM
    said = capfd.readouterr().err
    assert "the run of this job has ended" in said and len(said.splitlines()) == 1
    first.close()


def test_a_job_of_an_ended_run_ends_before_it_touches_anything(tmp_path, ended, monkeypatch):
    hold(tmp_path, "old").close()
    with hold(tmp_path, "new"):
        follow([tmp_path], "old", ended, monkeypatch)
        assert ended.is_set()


def test_a_new_run_waits_for_jobs_that_have_not_noticed(tmp_path):
    """A process that follows a run shares its lock before it looks: the next run waits for its end."""
    held = hold(tmp_path, "old")
    code = (
        "import time; from visualspeech.cluster import follow_run\n"
        "follow_run(every=2); print(flush=True); time.sleep(60)"
    )
    environment = {
        **os.environ, cluster.NAME: "old", LOCKS: json.dumps([str(jobs_lock(tmp_path))]),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }  # fmt: skip
    job = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment
    )
    job.stdout.readline()
    held.close()
    with hold(tmp_path, "new"):
        assert job.wait(1) == 128 + signal.SIGTERM
    job.communicate()


def test_without_a_run_there_is_nothing_to_follow(ended, monkeypatch):
    monkeypatch.delenv(cluster.NAME, raising=False)
    cluster.follow_run(ended.end)
    assert not ended.is_set()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_signal_cancels_once(number):
    before = {one: signal.getsignal(one) for one in (signal.SIGTERM, signal.SIGHUP)}
    try:
        signal.signal(signal.SIGHUP, signal.SIG_DFL)
        cluster.settle_signals()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
        signal.raise_signal(signal.SIGTERM)  # while jobs are cancelled
        signal.signal(signal.SIGHUP, signal.SIG_IGN)  # nohup
        cluster.settle_signals()
        signal.raise_signal(signal.SIGHUP)
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)


def test_a_missing_plugin_is_one_sentence(monkeypatch):
    monkeypatch.setattr(cluster, "PLUGIN", "no_such_plugin")
    with pytest.raises(SystemExit, match=r"install it with: pip install .*\[cluster\]"):
        cluster.check_plugin()


@pytest.mark.parametrize(("status", "keeps"), [(0, True), (1, False), (None, False)])
def test_accounts_are_found_out(tmp_path, monkeypatch, status, keeps):
    if status is not None:
        (tmp_path / "sacct").write_text(f"#!/bin/sh\nexit {status}\n")
        (tmp_path / "sacct").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cluster.keeps_accounts() is keeps
