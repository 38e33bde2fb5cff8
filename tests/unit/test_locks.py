"""One run at a time uses a results folder, and no job of an earlier run beside it."""

import os
import subprocess
import sys

import pytest

from visualspeech import locks
from visualspeech.errors import StorageError
from visualspeech.locks import hold, jobs_lock, share


def test_one_run_at_a_time(tmp_path):
    held = hold(tmp_path / "a")
    with pytest.raises(StorageError, match="another run is using"):
        hold(tmp_path / "a")
    hold(tmp_path / "b").close()
    held.close()
    hold(tmp_path / "a").close()


def test_a_run_waits_for_the_jobs_of_an_earlier_one(tmp_path, monkeypatch):
    hold(tmp_path).close()
    code = (
        f"from visualspeech.locks import share; import time; share([{str(jobs_lock(tmp_path))!r}]); print(flush=True)"
    )
    for patience, seconds in ((0.2, 60), (60, 0.5)):
        monkeypatch.setattr(locks, "PATIENCE", patience)
        job = subprocess.Popen([sys.executable, "-c", f"{code}; time.sleep({seconds})"], stdout=subprocess.PIPE)
        job.stdout.readline()
        if seconds > patience:
            with pytest.raises(StorageError, match=r"a job of an earlier run is still writing to .*fuser"):
                hold(tmp_path)
        else:
            hold(tmp_path).close()
        job.kill()
        job.communicate()


def test_jobs_share_the_lock_while_their_run_holds_the_folder(tmp_path):
    held = hold(tmp_path)
    for descriptor in [*share([jobs_lock(tmp_path)]), *share([jobs_lock(tmp_path)])]:
        os.close(descriptor)
    assert share([tmp_path / "nowhere"]) == []
    held.close()


def test_holding_a_folder_removes_what_killed_jobs_left(tmp_path):
    process = subprocess.Popen(["true"])
    process.wait()
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / f".partial.{process.pid}.x.h5").write_text("")
    hold(tmp_path).close()
    assert os.listdir(tmp_path / "deep") == []


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot write to the results folder"):
        hold(tmp_path / "file")


def test_a_file_system_without_locks_is_a_sentence(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(37, "No locks available")

    monkeypatch.setattr(locks.fcntl, "flock", refuse)
    with pytest.raises(StorageError, match=r"cannot lock .*No locks available"):
        hold(tmp_path)


def test_the_hold_ends_with_its_process_however_it_ends(tmp_path):
    code = (
        "import sys, time; from visualspeech.locks import hold; "
        f"lock = hold({str(tmp_path)!r}); print('held', flush=True); time.sleep(60)"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    other = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, env=environment)
    assert other.stdout.readline() == "held\n"
    with pytest.raises(StorageError, match="another run is using"):
        hold(tmp_path)
    other.kill()
    other.wait()
    hold(tmp_path).close()
