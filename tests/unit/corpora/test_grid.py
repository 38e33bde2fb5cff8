"""GRID in the folders that its copies have."""

import pytest

from tests.paths import grid_root
from visualspeech.corpora import grid
from visualspeech.corpora.adapters import list_utterances
from visualspeech.errors import CorpusError

ALIGN = (
    "0 12500 sil\n12500 21000 bin\n21000 27750 blue\n27750 29000 at\n29000 32750 z\n32750 40500 sp\n40500 74500 two\n"
)
LAYOUTS = [
    ("s1/bbaz2n.mpg", "alignments/s1/bbaz2n.align"),
    ("s1/bbaz2n.mpg", "s1/align/bbaz2n.align"),
    ("s1/bbaz2n.mpg", "align/s1/bbaz2n.align"),
    ("s1/video/mpg_6000/bbaz2n.mpg", "s1/align/bbaz2n.align"),
    ("video/s1/bbaz2n.mpg", "align/s1/bbaz2n.align"),
    ("s1_processed/bbaz2n.mpg", "s1_processed/align/bbaz2n.align"),
    ("s1.mpg_vcd/bbaz2n.mpg", "align/bbaz2n.align"),
]


def put(root, *names):
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(ALIGN)


def corpus(root, **settings):
    return {"name": "grid", "adapter": "grid", "root": str(root), **settings}


@pytest.mark.parametrize(("video", "align"), LAYOUTS)
def test_videos_and_words_are_found_in_any_layout(tmp_path, video, align):
    put(tmp_path, video, align)
    (one,) = list_utterances(corpus(tmp_path, speaker="s1"))
    assert (one.id, one.speaker, one.media) == ("bbaz2n", "s1", str(tmp_path / video))
    assert one.transcript == "bin blue at zed two"


def test_the_root_may_be_the_speakers_own_folder_and_come_from_the_environment(tmp_path, monkeypatch):
    put(tmp_path, "s7/bbaz2n.mpg", "s7/align/bbaz2n.align")
    monkeypatch.setenv("GRID_ROOT", str(tmp_path / "s7"))
    (one,) = list_utterances(corpus("", speaker="s7"))
    assert one.speaker == "s7" and one.transcript.startswith("bin")


def test_without_alignments_the_file_name_is_the_sentence(tmp_path):
    put(tmp_path, "s1/bbaf2n.mpg", "s1/lwiz9p.mpg", "s1/somethingelse.mpg")
    assert {one.id: one.transcript for one in list_utterances(corpus(tmp_path))} == {
        "bbaf2n": "bin blue at f two now",
        "lwiz9p": "lay white in zed nine please",
        "somethingelse": "",
    }
    assert grid.transcript_of_code("sgazzs") == "set green at zed zero soon"


def test_several_speakers_are_kept_apart(tmp_path):
    put(tmp_path, "s1/bbaf2n.mpg", "s12/bbaf2n.mpg", "alignments/s12/bbaf2n.align")
    found = {one.id: one for one in list_utterances(corpus(tmp_path))}
    assert sorted(found) == ["s1-bbaf2n", "s12-bbaf2n"]
    assert found["s1-bbaf2n"].transcript == "bin blue at f two now"
    assert found["s12-bbaf2n"].transcript == "bin blue at zed two"
    (one,) = list_utterances(corpus(tmp_path, speaker="s12"))
    assert one.id == "bbaf2n"
    with pytest.raises(CorpusError, match="speaker 's3' .* s1, s12"):
        list_utterances(corpus(tmp_path, speaker="s3"))


def test_one_sentence_in_two_qualities_is_a_sentence(tmp_path):
    put(tmp_path, "s1/mpg_vcd/bbaf2n.mpg", "s1/mpg_6000/bbaf2n.mpg")
    with pytest.raises(CorpusError, match="one id"):
        list_utterances(corpus(tmp_path))


def test_alignments_are_read_in_seconds_and_bad_ones_named(tmp_path):
    put(tmp_path, "a.align")
    assert grid.read_alignment(tmp_path / "a.align")[1] == ("bin", 0.5, 0.84)
    (tmp_path / "b.align").write_text("0 x sil")
    with pytest.raises(CorpusError, match="b.align is no alignment"):
        grid.read_alignment(tmp_path / "b.align")


DAMAGED = {
    "text": b"0 x sil",
    "columns": b"0 12500\n",
    "binary": bytes(range(256)) * 8,
    "digits": b"0 " + b"9" * 5000 + b" bin\n",
    "huge": b"0 1 sil\n" * 200_000,
}


@pytest.mark.parametrize("damage", DAMAGED)
def test_a_damaged_alignment_is_a_problem_of_one_utterance(tmp_path, damage):
    put(tmp_path, "s1/bbaf2n.mpg", "s1/lwiz9p.mpg", "s1/bbaf2n.align")
    (tmp_path / "s1/bbaf2n.align").write_bytes(DAMAGED[damage])
    bad, good = list_utterances(corpus(tmp_path))
    assert (good.problem, good.transcript) == ("", "lay white in zed nine please")
    assert "bbaf2n.align" in bad.problem and not bad.transcript
    assert bad.remedy.startswith("Restore it from the corpus, or remove it")


def test_odd_names_are_ids_too(tmp_path):
    put(tmp_path, "s1/bba f2n.mpg", "s1/bbaf2n.mpg")
    assert [one.id for one in list_utterances(corpus(tmp_path))] == ["bba_f2n-0ac8901ac0", "bbaf2n"]


def test_real_recordings_say_what_their_names_say():
    root = grid_root()
    if root is None:
        pytest.skip("no copy of GRID: set GRID_ROOT")
    found = list_utterances(corpus(root, speaker="s1"))
    assert len(found) >= 400
    assert [one.id for one in found if grid.transcript_of_code(one.id) != one.transcript] == []
