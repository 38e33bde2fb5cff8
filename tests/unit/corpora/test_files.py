"""Files of a corpus: the search below a root, texts that cannot be read, and the digest by which a change is seen."""

import os

import pytest

from visualspeech.corpora import files
from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.files import find_files, recordings_digest
from visualspeech.corpora.records import Utterance
from visualspeech.errors import CorpusError

CORPUS = {"name": "mine", "adapter": "folder"}


def put(root, *names, data=b"x"):
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    return root


def names(root):
    return [str(path.relative_to(root)) for path in find_files(root, {".mp4"}).files]


def test_links_that_lead_back_list_each_file_once(tmp_path):
    root = put(tmp_path / "root", "a.mp4", "z/b.mp4", "z/deep/c.mp4", "z/notes.txt")
    (root / "z" / "again").symlink_to(root)
    (root / "a_link").symlink_to(root / "z")
    (root / "itself").symlink_to("itself")
    assert names(root) == ["a.mp4", "z/b.mp4", "z/deep/c.mp4"]


def test_a_link_to_a_folder_elsewhere_is_followed_once(tmp_path):
    root = put(tmp_path / "root", "a.mp4")
    put(tmp_path / "disk", "b.mp4")
    (root / "first").symlink_to(tmp_path / "disk")
    (root / "second").symlink_to(tmp_path / "disk")
    assert names(root) == ["a.mp4", "first/b.mp4"]


def test_a_link_to_a_file_that_is_gone_is_listed_for_the_check(tmp_path):
    root = put(tmp_path / "root", "a.mp4")
    (root / "gone.mp4").symlink_to(root / "nowhere.mp4")
    assert names(root) == ["a.mp4", "gone.mp4"]


@pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="no /proc here")
@pytest.mark.parametrize("root", ["/proc/self", "/proc"])
def test_a_root_that_the_kernel_makes_up_is_refused(root):
    with pytest.raises(CorpusError, match=rf"{root} lies on a file system of the operating system \(proc\)"):
        list_utterances({**CORPUS, "root": root})


def test_a_file_system_that_the_kernel_makes_up_is_left_out_below_a_root(tmp_path):
    root = put(tmp_path / "root", "a.mp4")
    (root / "link").symlink_to("/proc")
    assert names(root) == ["a.mp4"]


def test_the_search_of_a_whole_disk_is_given_up(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_FOLDERS", 20)
    root = put(tmp_path / "root", *(f"{number}/a.mp4" for number in range(40)))
    assert len(names(root)) == 40
    for number in range(160):
        (root / f"0/{number}").mkdir()
    with pytest.raises(CorpusError, match=f"{root} holds more than 20 folders without a recording.*Set `root:`"):
        find_files(root, {".mp4"})


def refuse(monkeypatch, *refused):
    """Make the listing of folders fail, as it does without the right to read them (which root always has)."""
    scandir = os.scandir

    def listing(folder):
        if str(folder) in map(str, refused):
            raise PermissionError(13, "Permission denied", str(folder))
        return scandir(folder)

    monkeypatch.setattr(os, "scandir", listing)


@pytest.mark.parametrize("adapter", ["folder", "grid"])
def test_a_folder_that_cannot_be_listed_is_reported_and_the_others_are_used(tmp_path, adapter, monkeypatch):
    root = put(tmp_path / "s1", "bbaf2n.mp4", "bbaf3s.mp4", "closed/bbaf4p.mp4", "lost+found/x")
    refuse(monkeypatch, root / "closed", root / "lost+found")
    found = list_utterances({"name": "mine", "adapter": adapter, "root": str(root)})
    (one,) = [one for one in found if one.problem]
    assert sorted(other.id for other in found if other is not one) == ["bbaf2n", "bbaf3s"]
    assert (one.media, one.problem) == (str(root / "closed"), "the folder cannot be read: Permission denied")
    assert "Give yourself the right" in one.remedy


def test_a_root_that_cannot_be_listed_is_a_sentence(tmp_path, monkeypatch):
    refuse(monkeypatch, tmp_path)
    with pytest.raises(CorpusError, match=f"cannot read the folder {tmp_path}: Permission denied. Give yourself"):
        list_utterances({**CORPUS, "root": str(tmp_path)})


def test_a_file_name_that_is_not_utf_8_is_a_problem_of_one_utterance(tmp_path):
    put(tmp_path, "good.mp4", os.fsdecode(b"lat\xe9.mp4"), os.fsdecode(b"lat\xe8.mp4"), "carriage\rreturn.mp4")
    found = {one.media: one for one in list_utterances({**CORPUS, "root": str(tmp_path)})}
    assert [one.id for one in found.values() if not one.problem] == ["good"]
    assert {media for media, one in found.items() if "is not UTF-8" in one.problem} == {
        f"{tmp_path}/{name}" for name in (r"lat\xe9.mp4", r"lat\xe8.mp4", r"carriage\rreturn.mp4")
    }
    for one in found.values():
        "".join([one.id, one.speaker, one.media, one.problem]).encode()


def unreadable_transcripts(root):
    put(root, "folder.mp4", "link.mp4", "pipe.mp4", "huge.mp4", "good.mp4")
    (root / "folder.txt").mkdir()
    (root / "link.txt").symlink_to(root / "nowhere")
    os.mkfifo(root / "pipe.txt")
    (root / "huge.txt").write_bytes(b"word " * 300_000)
    (root / "good.txt").write_text("hello")


def test_a_transcript_that_cannot_be_read_is_a_problem_of_one_utterance(tmp_path):
    unreadable_transcripts(tmp_path)
    found = {one.id: one for one in list_utterances({**CORPUS, "root": str(tmp_path)})}
    assert (found.pop("good").transcript, len(found)) == ("hello", 4)
    reasons = {"folder": "a folder", "link": "No such file", "pipe": "no regular file", "huge": "larger than 1,000,000"}
    for name, one in found.items():
        assert one.problem.startswith(f"the transcript {name}.txt cannot be read: ") and reasons[name] in one.problem
        assert one.remedy and not one.transcript


def recorded(*paths):
    return [Utterance(f"u{number}", "s", str(path), "text") for number, path in enumerate(paths)]


def test_every_change_of_a_recording_is_seen_by_its_size_and_time(tmp_path):
    put(tmp_path, "a.mp4", "b.mp4")
    utterances = recorded(tmp_path / "a.mp4", tmp_path / "b.mp4", tmp_path / "missing.mp4")
    path, before = tmp_path / "a.mp4", recordings_digest(utterances)
    status = path.stat()
    assert recordings_digest(reversed(utterances)) == before
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns - 1))
    assert recordings_digest(utterances) != before
    path.write_bytes(b"y")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns - 10**12))
    assert recordings_digest(utterances) != before
    path.write_bytes(b"longer")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert recordings_digest(utterances) != before
    path.unlink()
    gone = recordings_digest(utterances)
    assert gone != before
    put(tmp_path, "missing.mp4")
    assert recordings_digest(utterances) != gone
    put(tmp_path, "a.mp4")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    (tmp_path / "missing.mp4").unlink()
    assert recordings_digest(utterances) == before


def test_with_content_the_bytes_of_a_recording_decide(tmp_path):
    put(tmp_path, "a.mp4", "b.mp4")
    os.mkfifo(tmp_path / "pipe.mp4")
    utterances = recorded(tmp_path / "a.mp4", tmp_path / "b.mp4", tmp_path / "pipe.mp4", tmp_path)
    path, before = tmp_path / "a.mp4", recordings_digest(utterances, by_content=True)
    status = path.stat()
    os.utime(path, ns=(0, 0))
    assert recordings_digest(utterances, by_content=True) == before
    path.write_bytes(b"y")
    os.utime(path, ns=(status.st_atime_ns, status.st_mtime_ns))
    assert recordings_digest(utterances, by_content=True) != before
    path.unlink()
    assert recordings_digest(utterances, by_content=True) != before
