"""Files are whole or absent, repeat byte for byte, and say in a sentence what is wrong with them."""

import os
import subprocess
import sys

import numpy as np
import pandas
import pytest

from visualspeech.errors import StorageError
from visualspeech.storage.arrays import ArrayCollection, ArrayReader, ArrayWriter
from visualspeech.storage.files import check_writable, copy_file, read_text, replacing, write_text
from visualspeech.storage.models import read_model, write_model
from visualspeech.storage.tables import read_table, write_table


def write_arrays(path):
    with ArrayWriter(path, stage="test") as out:
        out.add("b.2", {"x": np.arange(6, dtype=np.float32).reshape(3, 2)}, rate=25.0, units={"x": "px"}, width=360)
        out.add("a-1", {"x": np.zeros((0, 2), np.float32), "y": np.array([True, False])}, rate=100.0)


def test_arrays_come_back_with_rate_units_and_types(tmp_path):
    write_arrays(tmp_path / "s.h5")
    with ArrayReader(tmp_path / "s.h5") as arrays:
        assert arrays.ids == ["a-1", "b.2"] and "b.2" in arrays and "c" not in arrays
        assert arrays["b.2"]["x"].dtype == np.float32 and arrays["a-1"]["y"].dtype == bool
        np.testing.assert_array_equal(arrays["b.2"]["x"], [[0, 1], [2, 3], [4, 5]])
        np.testing.assert_array_equal(arrays.array("b.2", "x", slice(1, 2)), [[2, 3]])
        assert arrays.length("a-1", "x") == 0
        assert arrays.rate("b.2") == 25.0 and arrays.attributes("b.2")["width"] == 360
        with pytest.raises(StorageError, match="no utterance 'c'"):
            arrays["c"]


def test_same_arrays_same_bytes(tmp_path):
    write_arrays(tmp_path / "1.h5")
    write_arrays(tmp_path / "2.h5")
    assert (tmp_path / "1.h5").read_bytes() == (tmp_path / "2.h5").read_bytes()


def test_several_shards_read_as_one(tmp_path):
    for name in ("a", "b"):
        with ArrayWriter(tmp_path / f"{name}.h5") as out:
            out.add(name, {"x": np.ones(2)}, rate=1.0)
    with ArrayCollection([tmp_path / "b.h5", tmp_path / "a.h5"]) as arrays:
        assert arrays.ids == ["a", "b"]
        np.testing.assert_array_equal(arrays["b"]["x"], [1, 1])
        with pytest.raises(StorageError, match="'c'"):
            arrays.rate("c")


def test_a_failed_block_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "s.h5"
    write_arrays(path)
    before = path.read_bytes()
    with pytest.raises(RuntimeError, match="stop"), ArrayWriter(path) as out:
        out.add("half", {"x": np.zeros(3)}, rate=1.0)
        raise RuntimeError("stop")
    assert path.read_bytes() == before
    assert [one.name for one in tmp_path.iterdir()] == ["s.h5"]


def test_what_a_killed_job_left_is_replaced(tmp_path):
    killed = subprocess.Popen(["true"])
    killed.wait()
    (tmp_path / f".partial.{killed.pid}.t.txt").write_text("half")
    others = {f".partial.{killed.pid}.other.t.txt", f".partial.{os.getppid()}.t.txt"}  # another file, a living process
    for name in others:
        (tmp_path / name).write_text("half")
    write_text(tmp_path / "t.txt", "whole")
    assert {one.name for one in tmp_path.iterdir()} == {"t.txt", *others}


def test_two_processes_do_not_write_into_one_file(tmp_path):
    """Each has a name of its own, and the last one to finish gives the content."""
    code = "import sys; from visualspeech.storage.files import replacing\nwith replacing(sys.argv[1]) as path:"
    code += "\n    path.write_text(sys.argv[2]); print(flush=True); input()"
    path = tmp_path / "t.txt"
    first, second = (
        subprocess.Popen(
            [sys.executable, "-c", code, path, word], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for word in ("first", "second")
    )
    for process in (first, second):
        process.stdout.readline()
    for process, word in ((second, "second"), (first, "first")):
        process.communicate("\n", timeout=20)
        assert process.returncode == 0 and path.read_text() == word
    assert os.listdir(tmp_path) == ["t.txt"]


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    for content in ("old", "new"):
        with replacing(tmp_path / "folder") as folder:
            folder.mkdir()
            (folder / content).write_text(content)
    assert [one.name for one in (tmp_path / "folder").iterdir()] == ["new"]


def test_a_file_is_copied(tmp_path):
    (tmp_path / "a").write_bytes(b"\x00\xff")
    copy_file(tmp_path / "a", tmp_path / "folder" / "b")
    assert (tmp_path / "folder" / "b").read_bytes() == b"\x00\xff"
    with pytest.raises(StorageError, match="cannot read .*nowhere: there is no such file"):
        copy_file(tmp_path / "nowhere", tmp_path / "b")


def test_tables_keep_words_that_look_like_something_else(tmp_path):
    table = pandas.DataFrame(
        {"id": ["001", "1e5", "NA"], "word": ["null", "nan", ""], "x": [0.1, np.nan, 1 / 3], "n": [1, 2, 3]}
    )
    write_table(tmp_path / "t.tsv", table)
    back = read_table(tmp_path / "t.tsv", ("id", "word"))
    pandas.testing.assert_frame_equal(back, table, check_dtype=False)
    assert back["n"].dtype == np.int64


def test_tables_keep_tabs_and_quotes(tmp_path):
    table = pandas.DataFrame({"id": ['"quoted" and\ttabbed']})
    write_table(tmp_path / "t.tsv", table)
    assert read_table(tmp_path / "t.tsv")["id"][0] == '"quoted" and\ttabbed'


def test_models_come_back_with_their_settings(tmp_path):
    tensors = {"w": np.arange(6.0).reshape(2, 3).T, "s": np.float32(3)}
    write_model(tmp_path / "m.safetensors", tensors, {"a": [1, 2], "b": "x"})
    back, settings = read_model(tmp_path / "m.safetensors")
    assert settings == {"a": [1, 2], "b": "x"}
    np.testing.assert_array_equal(back["w"], tensors["w"])
    assert back["s"].shape == ()


@pytest.mark.parametrize("read", [read_model, ArrayReader, read_table, read_text])
def test_a_missing_or_broken_file_is_a_sentence(tmp_path, read):
    with pytest.raises(StorageError, match="missing"):
        read(tmp_path / "missing")
    (tmp_path / "broken").write_bytes(b"\x80\x81 not \xff this \x00 format" * 10)
    with pytest.raises(StorageError, match="broken"):
        read(tmp_path / "broken")


def test_a_folder_that_cannot_be_written_is_a_sentence(tmp_path):
    (tmp_path / "file").write_text("")
    for write in (lambda path: write_text(path, "x"), write_arrays):
        with pytest.raises(StorageError, match="cannot write .*file/x"):
            write(tmp_path / "file" / "x")


def test_an_error_of_another_file_is_not_blamed_on_the_written_one(tmp_path):
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "out"):
        (tmp_path / "input").read_text()


FULL = """
import resource, signal, sys
import numpy as np
from visualspeech.storage.arrays import ArrayCollection, ArrayReader, ArrayWriter
from visualspeech.storage.files import check_writable, copy_file, read_text, replacing, write_text
from visualspeech.storage.models import read_model, write_model
from visualspeech.storage.tables import read_table, write_table
from visualspeech.media import encoding, reading
from visualspeech.errors import StorageError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
folder = sys.argv[1]
noise = np.random.default_rng(0).integers(0, 255, (12, 240, 320, 3)).astype(np.uint8)
def arrays(path):
    with ArrayWriter(path) as out:
        out.add("a", {"x": np.zeros(200_000)}, rate=1.0)
        out.add("b", {"x": np.zeros(200_000)}, rate=1.0)
def sound(path):
    import soundfile
    with replacing(path) as temporary:
        soundfile.write(temporary, np.zeros(200_000), 16_000)
def sounds(path):
    import soundfile
    with replacing(path) as folder:
        folder.mkdir()
        soundfile.write(folder / "1.wav", np.zeros(200_000), 16_000)
jobs = {
    "t.txt": lambda path: write_text(path, "x" * 300_000),
    "m.safetensors": lambda path: write_model(path, {"x": np.zeros(100_000)}, {}),
    "a.h5": arrays,
    "s.wav": sound,
    "sounds": sounds,
    "v.mp4": lambda path: encoding.write_video(path, iter(noise), 25.0, np.zeros(20_000)),
}
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
for name, job in jobs.items():
    try:
        job(f"{folder}/{name}")
    except StorageError as error:
        print(name, error)
"""


def test_a_full_disk_is_a_sentence_whatever_is_written(tmp_path):
    """The limit on file sizes stands for the full disk; in a process of its own, since it cannot be lifted again."""
    ran = subprocess.run([sys.executable, "-c", FULL, str(tmp_path)], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    for name in ("t.txt", "m.safetensors", "a.h5", "s.wav", "sounds", "v.mp4"):
        assert f"{name} cannot write" in ran.stdout, (name, ran.stdout, ran.stderr)
    assert list(tmp_path.iterdir()) == []


def test_an_error_that_is_not_of_the_disk_stays_what_it_is(tmp_path):
    for made in (lambda path: path.write_text(""), lambda path: path.mkdir(), lambda path: None):
        with pytest.raises(ZeroDivisionError), replacing(tmp_path / "x") as temporary:
            made(temporary)
            raise ZeroDivisionError
    assert not list(tmp_path.iterdir())


def test_whether_a_file_can_be_written_is_known_before(tmp_path):
    check_writable(tmp_path / "not" / "yet" / "there.mp4")
    assert not list(tmp_path.iterdir())
    (tmp_path / "file").write_text("")
    with pytest.raises(StorageError, match="cannot write .*out.mp4: Not a directory"):
        check_writable(tmp_path / "file" / "out.mp4")
