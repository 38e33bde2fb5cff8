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
from visualspeech.storage.tables import read_numbers, read_table, write_table


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
from visualspeech.storage.tables import read_numbers, read_table, write_table
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


def arrays_of(path):
    with ArrayReader(path) as arrays:
        return {
            one: (
                arrays.attributes(one),
                {name: (str(v.dtype), v.shape, v.tobytes()) for name, v in arrays[one].items()},
            )
            for one in arrays.ids
        }


def test_any_changed_byte_of_arrays_is_harmless_or_a_sentence(tmp_path):
    random = np.random.default_rng(3)
    path = tmp_path / "s.h5"
    with ArrayWriter(path) as out:
        values = {"large": random.integers(0, 255, (40, 1000), dtype=np.uint8), "small": random.normal(size=(5, 3))}
        out.add("a", {**values, "empty": np.zeros((0, 2)), "scalar": np.float32(3)}, 25.0, {"small": "px"}, media="xé")
    whole, sound = path.read_bytes(), arrays_of(path)
    assert sound["a"][0] == {"rate": 25.0, "media": "xé"}
    refused = 0
    for at in [*range(0, 400), *random.integers(0, len(whole), 500)]:
        changed = bytearray(whole)
        changed[at] ^= 1 << int(random.integers(8))
        path.write_bytes(changed)
        try:
            assert arrays_of(path) == sound, f"byte {at}"
        except StorageError as error:
            assert str(path) in str(error) and "run the same command again" in str(error)
            refused += 1
    assert refused > 500


def test_arrays_that_are_large_are_read_by_rows(tmp_path):
    values = np.random.default_rng(0).integers(0, 255, (75, 40_000), dtype=np.uint8)  # three chunks
    with ArrayWriter(tmp_path / "s.h5") as out:
        out.add("a", {"x": values, "row": values.reshape(1, -1)}, 25.0)
    with ArrayReader(tmp_path / "s.h5") as arrays:
        np.testing.assert_array_equal(arrays.array("a", "x"), values)
        np.testing.assert_array_equal(arrays.array("a", "x", [3, 40, 74]), values[[3, 40, 74]])
        np.testing.assert_array_equal(arrays.array("a", "row"), values.reshape(1, -1))
        assert arrays.length("a", "x") == 75


def foreign(path, change):
    import h5py

    with h5py.File(path, "w") as file:
        group = file.create_group("a")
        group.attrs["rate"] = 25.0
        change(h5py, file, group)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda h5, file, a: a.create_group("x"), "it is a group, not a dataset"),
        (lambda h5, file, a: a.__setitem__("x", h5.SoftLink("/a")), "a link"),
        (lambda h5, file, a: a.__setitem__("x", h5.ExternalLink("/etc/passwd", "/")), "a link"),
        (lambda h5, file, a: a.create_dataset("x", data=["text"]), "no array of numbers"),
        (lambda h5, file, a: a.create_dataset("x", data=h5.Empty("f")), "no array of numbers"),
        (
            lambda h5, file, a: a.create_dataset("x", (2,), "u1", external=[("/etc/passwd", 0, 2)]),
            "no array of numbers",
        ),
        (lambda h5, file, a: a.create_dataset("x", (10**12,), "f8", chunks=(9,), compression=1), "more than the file"),
        (lambda h5, file, a: None, "there is none"),
    ],
)
def test_what_is_no_array_of_this_file_is_a_sentence(tmp_path, change, reason):
    foreign(tmp_path / "s.h5", change)
    with (
        ArrayReader(tmp_path / "s.h5") as arrays,
        pytest.raises(StorageError, match=f"'x' of utterance 'a': .*{reason}"),
    ):
        arrays.array("a", "x")


def test_links_to_utterances_and_frame_rates_that_are_none(tmp_path):
    foreign(
        tmp_path / "s.h5",
        lambda h5, file, a: (a.attrs.modify("rate", np.inf), file.__setitem__("b", h5.SoftLink("/a"))),
    )
    with ArrayCollection([tmp_path / "s.h5"]) as arrays:
        with pytest.raises(StorageError, match="s.h5: utterance 'a': the frame rate is inf"):
            arrays.rate("a")
        with pytest.raises(StorageError, match="s.h5: utterance 'b': it is a link"):
            arrays["b"]
    with ArrayReader(tmp_path / "s.h5") as arrays:
        assert "a/x" not in arrays and "." not in arrays


def test_any_changed_byte_of_a_model_is_a_sentence(tmp_path):
    path, random = tmp_path / "m.safetensors", np.random.default_rng(1)
    arrays = {"w": random.normal(size=(8, 5)), "none": np.zeros((0, 2)), "s": np.float32(1)}
    write_model(path, arrays, {"a": 1.5})
    whole = path.read_bytes()
    for at in range(len(whole)):
        changed = bytearray(whole)
        changed[at] ^= 1 << int(random.integers(8))
        path.write_bytes(changed)
        try:
            back, settings = read_model(path)
        except StorageError as error:
            assert str(path) in str(error) and "run the same command again" in str(error)
            continue
        # Spaces that pad the header do not count.
        assert settings == {"a": 1.5} and all(np.array_equal(back[name], arrays[name]) for name in arrays), at


def test_settings_that_json_does_not_have_or_that_are_deep(tmp_path):
    path = tmp_path / "m.safetensors"
    write_model(path, {}, {"a": float("nan"), "b": [1e308 * 10], "c": 10**30})
    assert read_model(path)[1] == {"a": None, "b": [None], "c": None}
    from safetensors.numpy import save

    for text in ("[" * 200_000, "[]", "no", '{"settings": 3, "header": "", "arrays": ""}'):
        path.write_bytes(save({"x": np.zeros(2)}, metadata={"visualspeech": text}))
        with pytest.raises(StorageError, match="m.safetensors"):
            read_model(path)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("id\tx\na\t1\nb\n", "line 3 has 1 cells, the head of the table 2"),
        ("id\tx\na\t1\nb\t2\t3\n", "line 3 has 3 cells"),
        ("id\tx\na\t1\t2\n", "line 2 has 3 cells"),
        ("id\tx\na\t1\n\nb\t2\n", "line 3 has 0 cells"),
        ("id\tx\na\t1\nb\t2", "breaks off in line 3"),
        ('id\tx\n"a\nb"\t1\nc\tlong\n', "line 4 has 'long' in the column x, no number"),
        ("id\ty\na\t1\n", "no column x"),
        ('id\tx\n"a\t1\nb\t2\n', "no table"),
        ("", "no table"),
    ],
)
def test_damaged_tables_name_the_line(tmp_path, text, reason):
    path = tmp_path / "t.tsv"
    path.write_text(text)
    with pytest.raises(StorageError, match=f"t.tsv: .*{reason}.* Delete the file and run the same command again"):
        read_table(path, number_columns=["x"])


def test_tables_that_people_edit(tmp_path):
    path = tmp_path / "t.tsv"
    path.write_bytes(b"\xef\xbb\xbfid\tx\r\na\t1\r\n\r\nb\t2")
    assert read_table(path, number_columns=["x"], edited=True).to_dict("list") == {"id": ["a", "b"], "x": [1, 2]}
    path.write_text("id\tx\na\tone")
    with pytest.raises(StorageError, match="line 2 has 'one' in the column x, no number. Correct the file"):
        read_table(path, number_columns=["x"], edited=True)
    with pytest.raises(StorageError, match="line 2 has 'one'"):
        path.write_text("id\tx\na\tone\n")
        read_numbers(path)
