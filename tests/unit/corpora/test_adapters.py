"""One listing for every corpus, and sentences for what cannot be listed."""

import pytest

from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.records import LEGAL_ID, MAX_ID, legal_id, shard_of
from visualspeech.errors import CorpusError, SettingError


def corpus(root, **settings):
    return {"name": "mine", "adapter": "folder", "root": str(root), **settings}


def videos(root, *names):
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
        path.with_suffix(".txt").write_text(f"says {path.stem}")


def test_utterances_are_sorted_by_id(tmp_path):
    videos(tmp_path, "b.mp4", "a.mov", "sub/c.mkv")
    assert [one.id for one in list_utterances(corpus(tmp_path))] == ["a", "b", "sub-c"]


def test_an_unknown_adapter_names_the_known(tmp_path):
    with pytest.raises(SettingError, match="adapter: gird.*demo, folder, grid"):
        list_utterances({"name": "x", "adapter": "gird"})


@pytest.mark.parametrize("adapter", ["folder", "grid"])
def test_a_missing_root_is_a_sentence(tmp_path, adapter, monkeypatch):
    monkeypatch.delenv("GRID_ROOT", raising=False)
    with pytest.raises(SettingError, match="'x' has no `root`"):
        list_utterances({"name": "x", "adapter": adapter})
    with pytest.raises(SettingError, match="does not exist.*nowhere"):
        list_utterances({"name": "x", "adapter": adapter, "root": str(tmp_path / "nowhere")})
    (tmp_path / "file").write_text("")
    with pytest.raises(SettingError, match="is a file"):
        list_utterances({"name": "x", "adapter": adapter, "root": str(tmp_path / "file")})


@pytest.mark.parametrize("adapter", ["folder", "grid"])
def test_an_empty_root_is_a_sentence(tmp_path, adapter):
    (tmp_path / "notes.doc").write_text("")
    with pytest.raises(CorpusError, match="no recordings in"):
        list_utterances({"name": "x", "adapter": adapter, "root": str(tmp_path)})


@pytest.mark.parametrize(
    "names", [("a.mp4", "a.mov"), ("sub/a.mp4", "sub-a.mp4"), ("A.mp4", "a.mov"), ("Zo\u00eb.mp4", "Zoe\u0308.mp4")]
)
def test_two_utterances_with_one_id_are_both_named(tmp_path, names):
    videos(tmp_path, *names)
    with pytest.raises(CorpusError) as error:
        list_utterances(corpus(tmp_path))
    assert all(str(tmp_path / name) in str(error.value) for name in names) and "Rename" in str(error.value)


def test_a_limit_keeps_the_same_utterances_when_the_corpus_grows_little(tmp_path):
    videos(tmp_path, *(f"{number:03d}.mp4" for number in range(40)))
    kept = {one.id for one in list_utterances(corpus(tmp_path, limit=10))}
    videos(tmp_path, "new.mp4")
    assert len(kept) == 10 and len(kept & {one.id for one in list_utterances(corpus(tmp_path, limit=10))}) >= 9
    for wrong in (-1, "ten", True):
        with pytest.raises(SettingError, match="limit"):
            list_utterances(corpus(tmp_path, limit=wrong))


@pytest.mark.parametrize("name", ["a b", "-x", ".hidden", "Zoë 1", "x/y", "日本", ""])
def test_ids_made_of_file_names_are_legal(name):
    assert LEGAL_ID.fullmatch(legal_id(name))


LEGAL = ["a", "bbaf2n", "s1-bbaf2n", "_x", "a.b-c_D", "0", "con", "x.", "a" * MAX_ID]


@pytest.mark.parametrize("name", LEGAL)
def test_a_name_that_is_a_legal_id_stays_as_it_is(name):
    assert legal_id(name) == name


def test_names_that_differ_have_ids_that_differ():
    names = ["你好", "再见", "a b", "a_b", "a*b", "-x", "_x", ".x", "", "_", "a" * 300, "a" * 301, "é", "è", "\udce9"]
    assert len({legal_id(name) for name in names}) == len(names)
    assert all(LEGAL_ID.fullmatch(legal_id(name)) and len(legal_id(name)) <= MAX_ID for name in names)
    assert legal_id("你好") == "__-670d974354"


def test_composed_and_decomposed_spellings_have_one_id():
    assert legal_id("Zo\u00eb") == legal_id("Zoe\u0308") != legal_id("Zoe")


def test_files_named_by_the_longest_id_fit_in_a_file_system():
    assert len(f".partial.{2**22}.{'a' * MAX_ID}.TextGrid".encode()) <= 255


def test_two_speakers_in_another_script(tmp_path):
    videos(tmp_path, "你好/1.mp4", "再见/1.mp4", "你好/2.mp4")
    found = list_utterances(corpus(tmp_path))
    assert sorted(one.speaker for one in found) == ["你好", "你好", "再见"]
    assert len({one.id for one in found}) == 3


def test_shards_are_stable_and_even():
    shards = [shard_of(f"utterance{number}", 8) for number in range(800)]
    assert shards[:4] == [shard_of(f"utterance{number}", 8) for number in range(4)]
    assert min(shards.count(shard) for shard in range(8)) > 70
