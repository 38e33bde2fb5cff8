"""One listing for every corpus, and sentences for what cannot be listed."""

import pytest

from visualspeech.corpora.adapters import LEGAL_ID, list_utterances
from visualspeech.corpora.records import legal_id, shard_of
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
    "names", [("a.mp4", "a.mov"), ("sub/a.mp4", "sub-a.mp4"), ("A.mp4", "a.mov"), ("ä.mp4", "ö.mp4")]
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


def test_shards_are_stable_and_even():
    shards = [shard_of(f"utterance{number}", 8) for number in range(800)]
    assert shards[:4] == [shard_of(f"utterance{number}", 8) for number in range(4)]
    assert min(shards.count(shard) for shard in range(8)) > 70
