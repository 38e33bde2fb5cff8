"""What a dead process left is removed; what a living one writes is not."""

import os
import subprocess
import sys
import time

import pytest

from visualspeech.unfinished import is_alive, partial_of, sweep, target_of, unfinished, writer_of


@pytest.fixture
def dead():
    """Id of a process that has ended."""
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    return process.pid


def test_the_name_keeps_suffix_and_folder_and_holds_the_process(tmp_path):
    made = partial_of(tmp_path / "a.b.mp4")
    assert made == tmp_path / f".partial.{os.getpid()}.a.b.mp4"
    assert writer_of(made.name) == os.getpid()
    assert target_of(made / "x.txt") == tmp_path / "a.b.mp4" / "x.txt"


@pytest.mark.parametrize("name", [".partial.a.h5", ".partial.", ".partial.99999999999999999999.x", ".partial.²3.x"])
def test_a_name_without_a_process_belongs_to_nobody(name):
    assert writer_of(name) == 0 and not is_alive(0)


def test_the_longest_name_can_be_written(tmp_path):
    path = tmp_path / ("ä" * 120 + ".mp4")
    made = partial_of(path)
    made.write_text("")
    assert made.suffix == ".mp4" and writer_of(made.name) == os.getpid()


def test_processes_are_alive_until_they_end(dead):
    assert is_alive(os.getpid()) and not is_alive(dead)
    child = subprocess.Popen([sys.executable, "-c", ""])
    while is_alive(child.pid):  # it ends, though nobody has waited for it
        time.sleep(0.01)
    child.wait()


def test_a_sweep_removes_the_files_and_folders_of_dead_processes_alone(tmp_path, dead):
    (tmp_path / "deep" / f".partial.{dead}.videos").mkdir(parents=True)
    (tmp_path / "deep" / f".partial.{dead}.videos" / "1.mp4").write_text("")
    for name in (f".partial.{dead}.a.h5", ".partial.old.h5", f".partial.{os.getpid()}.b.h5", "c.h5"):
        (tmp_path / "deep" / name).write_text("")
    sweep(tmp_path)
    assert sorted(os.listdir(tmp_path / "deep")) == [f".partial.{os.getpid()}.b.h5", "c.h5"]


def test_a_process_that_began_after_the_file_is_not_its_writer(tmp_path, monkeypatch):
    """Ids are given out again: here to this process, which begins ten minutes after the file."""
    path = tmp_path / f".partial.{os.getpid()}.a.h5"
    path.write_text("")
    now = time.time()
    monkeypatch.setattr("visualspeech.unfinished.time.time", lambda: now + 86_400 * 365)
    sweep(tmp_path)
    assert not path.exists()


def test_a_block_removes_its_file_however_it_ends(tmp_path):
    path = tmp_path / "x"
    with pytest.raises(ValueError), unfinished(path):
        path.write_text("")
        raise ValueError
    assert not path.exists()
