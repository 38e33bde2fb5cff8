"""Before any job: the code of a tracker is found and not run, and landmark files belong to one recording each."""

import sys

import pytest

from tests.unit.planning.configs import resolved
from visualspeech.corpora.records import Utterance
from visualspeech.errors import SettingError
from visualspeech.planning.landmarks import check_landmark_files, landmark_files_digest, tracker_code

TRAP = "raise RuntimeError('planning ran the code')\n"


def tracker(name):
    return {"source": "tracker", "tracker": name, "folder": ""}


def csv(folder):
    return {"source": "csv", "tracker": "dlib", "folder": str(folder)}


def utterance(media):
    return Utterance(media, "s", str(media), "")


def test_the_trackers_of_the_package_are_named_by_their_module():
    assert tracker_code(tracker("dlib"), [], []).module == "visualspeech.face.dlib_tracker"
    assert tracker_code(csv("x"), [], []).module == "visualspeech.face.landmark_csv"


def test_a_module_is_found_beside_the_settings_and_never_run(tmp_path):
    (tmp_path / "first").mkdir()
    (tmp_path / "second").mkdir()
    (tmp_path / "second" / "my_tracker.py").write_text(TRAP)
    folders = [tmp_path / "first", tmp_path / "second"]
    found = tracker_code(tracker("my_tracker:T"), folders, [])
    assert (found.module, found.folder) == ("", str(tmp_path / "second")) and "my_tracker" not in sys.modules
    (tmp_path / "second" / "my_tracker.py").write_text(TRAP + "A = 1\n")
    changed = tracker_code(tracker("my_tracker:T"), folders, [])
    assert changed.digest != found.digest
    (tmp_path / "first" / "my_tracker.py").write_text(TRAP)
    assert tracker_code(tracker("my_tracker:T"), folders, []).folder == str(tmp_path / "first")


def test_a_package_is_watched_as_a_whole(tmp_path):
    package = tmp_path / "mine_too"
    package.mkdir()
    for name in ("__init__", "tracker", "helper"):
        (package / f"{name}.py").write_text(TRAP)
    found = tracker_code(tracker("mine_too.tracker:T"), [tmp_path], [])
    (package / "helper.py").write_text(TRAP + "A = 1\n")
    assert tracker_code(tracker("mine_too.tracker:T"), [tmp_path], []).digest != found.digest
    with pytest.raises(SettingError, match="there is no module mine_too.nowhere"):
        tracker_code(tracker("mine_too.nowhere:T"), [tmp_path], [])
    with pytest.raises(SettingError, match="there is no module mine_too.helper.deep"):
        tracker_code(tracker("mine_too.helper.deep:T"), [tmp_path], [])
    assert not [name for name in sys.modules if name.startswith("mine_too")]


def test_an_installed_module_is_found_too(tmp_path):
    found = tracker_code(tracker("tests.unit.face.trackers:Corner"), [tmp_path], [])
    assert found.folder == "" and found.digest


def test_a_module_that_is_nowhere_is_told(tmp_path):
    with pytest.raises(SettingError, match=f"there is no module absent_one. It is looked for in {tmp_path}, and where"):
        tracker_code(tracker("absent_one:T"), [tmp_path], [])


def test_code_among_recordings_is_refused(tmp_path):
    (tmp_path / "corpus" / "deep").mkdir(parents=True)
    (tmp_path / "corpus" / "deep" / "theirs.py").write_text(TRAP)
    for folders in ([tmp_path / "corpus" / "deep"], [tmp_path / "link"]):
        (tmp_path / "link").unlink(missing_ok=True)
        (tmp_path / "link").symlink_to(tmp_path / "corpus" / "deep")
        with pytest.raises(SettingError, match="lies among the recordings .* whose code is never run"):
            tracker_code(tracker("theirs:T"), folders, [str(tmp_path / "corpus")])
    assert "theirs" not in sys.modules


def test_the_folder_of_the_files_is_checked(tmp_path):
    corpora = {"c": [utterance("/rec/a.mp4"), utterance("/rec/b.mp4")]}
    with pytest.raises(SettingError, match="`landmarks.folder: .*nowhere` does not exist; give the folder"):
        check_landmark_files(csv(tmp_path / "nowhere"), corpora)
    (tmp_path / "file").touch()
    with pytest.raises(SettingError, match="is a file; give the folder"):
        check_landmark_files(csv(tmp_path / "file"), corpora)
    with pytest.raises(SettingError, match="holds no file for any recording; for /rec/a.mp4 it would be a.csv"):
        check_landmark_files(csv(tmp_path), corpora)
    (tmp_path / "a.csv").touch()
    check_landmark_files(csv(tmp_path), corpora)  # what lacks one is rejected by itself
    check_landmark_files(tracker("dlib"), corpora)


def test_one_file_is_of_one_recording(tmp_path):
    (tmp_path / "a.csv").touch()
    same = {"c": [utterance("/rec/a.mp4"), utterance("/rec/a.mp4")], "d": []}  # two segments of one recording
    check_landmark_files(csv(tmp_path), same)
    two = {"c": [utterance("/rec/s1/a.mp4")], "d": [utterance("/rec/s2/a.mp4")]}
    with pytest.raises(SettingError, match="a.csv would stand for /rec/s1/a.mp4 and for /rec/s2/a.mp4"):
        check_landmark_files(csv(tmp_path), two)
    (tmp_path / "s1").mkdir()
    (tmp_path / "s1" / "a.csv").touch()
    check_landmark_files(csv(tmp_path), two)


def test_a_changed_file_changes_the_digest_of_its_shard(tmp_path):
    shard = [utterance("/rec/a.mp4"), utterance("/rec/b.mp4")]
    digests = [landmark_files_digest(csv(tmp_path), shard)]
    for text in ("1", "12"):
        (tmp_path / "a.csv").write_text(text)
        digests.append(landmark_files_digest(csv(tmp_path), shard))
    (tmp_path / "rec").mkdir()
    (tmp_path / "rec" / "a.csv").write_text("12")
    digests.append(landmark_files_digest(csv(tmp_path), shard))
    assert len(set(digests)) == 4
    (tmp_path / "c.csv").touch()
    assert landmark_files_digest(csv(tmp_path), shard) == digests[-1]
    assert landmark_files_digest(tracker("dlib"), shard) == ""


def test_files_do_not_lie_among_the_results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    given = {"source": "csv", "folder": "results/demo/openface"}
    with pytest.raises(SettingError, match="`landmarks.folder: results/demo/openface` lies among the results"):
        resolved({"landmarks": given})
    assert resolved({"landmarks": given | {"folder": "openface"}})["landmarks"]["folder"] == "openface"


def test_mistakes_of_the_section_are_told_before_any_job():
    for section, said in [
        ({"tracker": "mine"}, "`landmarks.tracker: mine` must be `dlib`, or a class of your own, module:Class"),
        ({"tracker": "a b:C"}, "landmarks.tracker"),
        ({"source": "csv"}, "`landmarks.folder: ` must be the folder of the CSV files"),
        ({"folder": "x"}, "must be left out, unless `source` is csv"),
        ({"source": "openface"}, "`landmarks.source: openface` must be one of tracker, csv"),
    ]:
        with pytest.raises(SettingError, match=said):
            resolved({"landmarks": section})
