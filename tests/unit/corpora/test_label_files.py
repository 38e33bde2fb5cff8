"""Which file holds the alignment of an utterance, and what a corpus of such files lacks."""

import pytest

from tests.unit.corpora.labels import PHONES, WORDS, write_grid
from tests.unit.corpora.test_ctm import lines
from visualspeech.corpora import label_files
from visualspeech.corpora.label_files import LabelFiles, LabelReader, find_label_files, probe
from visualspeech.corpora.records import Utterance
from visualspeech.corpora.textgrids import read_textgrid
from visualspeech.errors import CorpusError, RejectedUtterance, SettingError
from visualspeech.speech.alignment_settings import AlignmentSettings


def utterance(root, name, id="", **more):
    return Utterance(id or name.replace("/", "-"), more.pop("speaker", "anna"), f"{root}/{name}.mp4", "", **more)


def found(tmp_path, names, *utterances, folder="aligned", **settings):
    for name in names:
        write_grid(tmp_path / folder / f"{name}.TextGrid")
    own = AlignmentSettings(source="textgrid", folder=folder, **settings)
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, utterances)
    return {name: one.problem or one.names[0].removeprefix(f"{tmp_path}/") for name, one in files.utterances.items()}


def test_the_folders_of_the_recordings(tmp_path):
    """As MFA writes them: one folder per speaker below the folder, as below the root."""
    both = utterance(tmp_path, "anna/one"), utterance(tmp_path, "ben/one", speaker="ben")
    assert found(tmp_path, ["anna/one", "ben/one"], *both) == {
        "anna-one": "aligned/anna/one.TextGrid", "ben-one": "aligned/ben/one.TextGrid"}  # fmt: skip


def test_another_folder_and_the_id(tmp_path):
    three = utterance(tmp_path, "x/one"), utterance(tmp_path, "two"), utterance(tmp_path, "three", "S03")
    assert found(tmp_path, ["one", "deep/down/two", "S03"], *three) == {
        "x-one": "aligned/one.TextGrid",
        "two": "aligned/deep/down/two.TextGrid",
        "S03": "aligned/S03.TextGrid",
    }


def test_several_of_a_name(tmp_path):
    both = utterance(tmp_path, "one", speaker="ben"), utterance(tmp_path, "two")
    assert found(tmp_path, ["anna/one", "ben/one", "x/two", "y/two"], *both) == {
        "one": "aligned/ben/one.TextGrid",
        "two": "several files are named as the recording: x/two.TextGrid and y/two.TextGrid"}  # fmt: skip


def test_one_that_is_missing_is_a_problem_of_its_utterance(tmp_path):
    both = utterance(tmp_path, "one"), utterance(tmp_path, "two")
    assert found(tmp_path, ["one"], *both)["two"] == "there is no two.TextGrid"
    own = AlignmentSettings(source="textgrid", folder="aligned")
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, both)
    with pytest.raises(RejectedUtterance, match="there is no two.TextGrid") as error:
        LabelReader(files, own).read(both[1])
    assert str(tmp_path / "aligned") in error.value.remedy
    assert LabelFiles.of(files.plain()) == files
    assert files.paths(["one", "two"]) == [str(tmp_path / "aligned/one.TextGrid")]


def test_beside_the_recordings(tmp_path):
    write_grid(tmp_path / "x/one.TextGrid")
    own = AlignmentSettings(source="textgrid")
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, [utterance(tmp_path, "x/one")])
    assert files.utterances["x-one"].names == (str(tmp_path / "x/one.TextGrid"),)


def test_parts_of_a_recording(tmp_path):
    """Named as the recording, a file is that of all of it; named by the id, that of the part."""
    part = dict(start=0.5, end=1.0)
    both = utterance(tmp_path, "long", "long-0001", **part), utterance(tmp_path, "long", "long-0002", **part)
    write_grid(tmp_path / "aligned/long.TextGrid")
    write_grid(tmp_path / "aligned/long-0002.TextGrid")
    own = AlignmentSettings(source="textgrid", folder="aligned")
    reader = LabelReader(find_label_files({"name": "mine", "root": str(tmp_path)}, own, both), own)
    first, second = ([one for one in reader.read(each).words if one.label] for each in both)
    assert [(one.label, one.start) for one in first] == [("me", 0.0)]
    assert [(one.label, one.start) for one in second] == [("be", 0.2), ("me", 0.5)]


def test_a_file_of_many_parts_is_read_once(tmp_path, monkeypatch):
    parts = [utterance(tmp_path, "long", f"long-000{k}", start=0.1 * k, end=1.0) for k in range(1, 4)]
    write_grid(tmp_path / "aligned/long.TextGrid")
    own = AlignmentSettings(source="textgrid", folder="aligned")
    reader, read = LabelReader(find_label_files({"name": "mine", "root": str(tmp_path)}, own, parts), own), []
    monkeypatch.setattr(label_files, "read_textgrid", lambda *given: read.append(given) or read_textgrid(*given))
    assert [round(reader.read(one).seconds, 3) for one in parts] == [0.9, 0.8, 0.7] and len(read) == 1


@pytest.mark.parametrize(
    ("settings", "make", "reason"),
    [
        ({"folder": "none"}, None, "none does not exist, neither in the root of the corpus nor in the working folder"),
        ({"folder": "a.txt"}, None, "is a file"),
        ({"folder": "empty"}, None, "there is no TextGrid file in"),
        ({"folder": "other"}, None, "none of the 1 TextGrid files.*is named as a recording.*there is no one.TextGrid"),
    ],
)
def test_wrong_folders_are_a_setting_error(tmp_path, settings, make, reason):
    (tmp_path / "empty").mkdir()
    (tmp_path / "a.txt").write_text("")
    write_grid(tmp_path / "other/xyz.TextGrid")
    own = AlignmentSettings(source="textgrid", **settings)
    with pytest.raises(SettingError, match=f"`alignment.folder` of the corpus mine.*{reason}"):
        find_label_files({"name": "mine", "root": str(tmp_path)}, own, [utterance(tmp_path, "one")])
    with pytest.raises(SettingError, match="is empty and the corpus has no `root`"):
        find_label_files({"name": "mine", "root": ""}, AlignmentSettings(source="textgrid"), [utterance("", "one")])


@pytest.mark.parametrize("folder", ["ctm", "ctm/phones.ctm"])
def test_ctm_files_of_all_utterances(tmp_path, folder):
    (tmp_path / "ctm").mkdir()
    both = utterance(tmp_path, "x/one"), utterance(tmp_path, "x/two")
    for name, tier in (("words", WORDS), ("phones", PHONES)):
        (tmp_path / f"ctm/{name}.ctm").write_text(lines(tier, "one") + lines(tier, "x-two"))
    own = AlignmentSettings(source="ctm", folder=folder)
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, both)
    reader = LabelReader(LabelFiles.of(files.plain()), own)
    assert [len(reader.read(one).phones) for one in both] == [4, 4]
    assert files.paths(["x-one"]) == [str(tmp_path / "ctm/words.ctm"), str(tmp_path / "ctm/phones.ctm")]


def test_ctm_files_without_words(tmp_path):
    (tmp_path / "phones.ctm").write_text(lines(PHONES))
    with pytest.raises(SettingError, match="there is no CTM file of words in .*its name must contain 'word'"):
        own = AlignmentSettings(source="ctm", folder="phones.ctm")
        find_label_files({"name": "mine", "root": str(tmp_path)}, own, [utterance(tmp_path, "one")])


def test_files_of_which_none_can_be_used_are_refused_before_the_run(tmp_path):
    all_ = [utterance(tmp_path, f"u{number}") for number in range(4)]
    for one in all_:
        write_grid(tmp_path / f"aligned/{one.id}.TextGrid", {"Wort": WORDS, "Laut": PHONES})
    own = AlignmentSettings(source="textgrid", folder="aligned")
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, all_)
    with pytest.raises(
        SettingError,
        match="none of 3 alignments in .* that were tried can be used. That of u0: u0.TextGrid has no tier 'words'",
    ):
        probe(files, own, all_, lambda given: None, 3)
    write_grid(tmp_path / "aligned/u2.TextGrid")
    probe(files, own, all_, lambda given: None, 3)


def test_ctm_files_are_read_before_the_run(tmp_path):
    both = utterance(tmp_path, "one"), utterance(tmp_path, "two")
    (tmp_path / "words.ctm").write_text(lines(WORDS, "other"))
    (tmp_path / "phones.ctm").write_text(lines(PHONES, "one"))
    own = AlignmentSettings(source="ctm", folder=".")
    files = find_label_files({"name": "mine", "root": str(tmp_path)}, own, both)
    with pytest.raises(SettingError, match="That of one: the CTM files of words have no utterance 'one'"):
        probe(files, own, both, lambda given: None, 3)
    (tmp_path / "words.ctm").write_text(lines(WORDS, "one") + "one 1 0.2\n")
    with pytest.raises(CorpusError, match="words.ctm, line 3 has 3 fields"):
        probe(files, own, both, lambda given: None, 3)
