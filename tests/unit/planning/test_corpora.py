"""The plan of a corpus: utterances, shards, split and speakers, without writing."""

import os

import pytest

from visualspeech.corpora.records import shard_of
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import CorpusError
from visualspeech.planning.corpora import plan_corpus

SHARES = {"train": 0.8, "validation": 0.1, "test": 0.1}


def demo(count):
    return {"name": "d", "adapter": "demo", "utterances": count, "seed": 1}


def folder(root, files, table="", **more):
    """A corpus of empty recordings; a transcript stands in a file beside each."""
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
        if text:
            path.with_suffix(".txt").write_text(text)
    return {"name": "mine", "adapter": "folder", "root": str(root), "table": table, **more}


def plan(corpus, shards=3, seed=1, results="results"):
    return plan_corpus(corpus, shards, SHARES, seed, str(results))


def test_every_utterance_is_once_in_its_shard(tmp_path):
    found = plan(demo(20), results=tmp_path)
    assert sum(map(len, found.utterances.values())) == 20
    assert all(shard_of(one.id, 3) == int(shard) for shard, members in found.utterances.items() for one in members)
    ids = sorted(one.id for members in found.utterances.values() for one in members)
    assert sorted(found.split) == ids and found.shards == sorted(found.utterances, key=int)
    assert found.recorded_here["0"] == f"{tmp_path}/d/recordings/0" and found.recordings("0") == ""
    assert [row["id"] for row in found.rows("0")] == [one.id for one in found.utterances["0"]]
    assert found.test_utterances() == 2
    everyone = [one for members in found.utterances.values() for one in members]
    assert found.split == split_utterances(everyone, (0.8, 0.1, 0.1), 1)


def test_planning_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plan(demo(20))
    assert list(tmp_path.iterdir()) == []


def test_one_more_utterance_touches_one_shard(tmp_path):
    before, after = (plan(demo(count), results=tmp_path) for count in (20, 21))
    assert sum(before.rows(shard) != after.rows(shard) for shard in before.shards) == 1


NAMES = ["br{ace}s", "{shard}", "a b", "ünï", "x'y\"", "-dash", "~tilde", "100%", "a*b?", "[x]", "new\nline",
         "tab\there", "s3:/mine/in", "back\\slash", "你好", "再见", "$(id)", os.fsdecode(b"lat\xe9")]  # fmt: skip


@pytest.mark.parametrize("detection", ["metadata", "content"])
def test_a_recording_that_changes_changes_its_shard_alone(tmp_path, detection):
    given = folder(tmp_path, {f"{name}.mp4": "hello" for name in NAMES}, change_detection=detection)
    before = plan(given)
    digests = {shard: before.recordings(shard) for shard in before.shards}
    changed = before.utterances["1"][0]
    with open(changed.media, "ab") as file:
        file.write(b"more")
    assert before.recordings("1") == digests["1"]  # one plan looks once
    after = plan(given)
    assert {shard for shard in after.shards if after.recordings(shard) != digests[shard]} == {"1"}


def test_a_listed_recording_that_is_missing_is_planned_for_the_check_to_report(tmp_path):
    for name in ("a.mp4", "b.mp4", "c.mp4"):
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "list.csv").write_text("file,transcript\na.mp4,x\nb.mp4,x\nc.mp4,x\nmissing.mp4,x\n")
    given = folder(tmp_path, {}, "list.csv")
    found = plan(given, shards=1)
    assert len(found.utterances["0"]) == 4
    missing = found.recordings("0")
    (tmp_path / "missing.mp4").write_bytes(b"")
    assert plan(given, shards=1).recordings("0") != missing


def test_no_file_is_read_or_looked_at_before_its_shard_is_asked_for(tmp_path, monkeypatch):
    given = folder(tmp_path, ANNA, change_detection="content")
    found = plan(given)
    read = []
    monkeypatch.setattr("visualspeech.corpora.files.file_digest", lambda path: read.append(path) or "")
    shard = found.shards[0]
    found.recordings(shard)
    found.recordings(shard)
    assert read == sorted(one.media for one in found.utterances[shard])


def test_utterances_with_a_problem_have_no_part_in_what_a_corpus_gives(tmp_path):
    given = folder(tmp_path, {**ANNA, os.fsdecode(b"b\xe9n/1.mp4"): "hello"})
    found = plan(given)
    assert "one_speaker" in found.gives and found.speakers == {"anna": "anna"}
    assert sum(bool(row["problem"]) for shard in found.shards for row in found.rows(shard)) == 1
    with pytest.raises(CorpusError, match="no utterance of the corpus mine can be used .1 are listed.*not UTF-8"):
        plan(folder(tmp_path / "bad", {os.fsdecode(b"b\xe9n/1.mp4"): "hello"}))


ANNA = {f"anna/{n}.mp4": "hello" for n in range(4)}
BEN = {f"ben/{n}.mp4": "hello" for n in range(3)}


def test_what_a_corpus_gives(tmp_path):
    assert plan(demo(5)).gives == {"video", "audio", "text", "faces", "one_speaker", "arpabet"}
    both = plan(folder(tmp_path, {**ANNA, **BEN}))
    assert both.gives == {"video", "audio", "text", "faces", "arpabet"}
    assert both.speakers == {"anna": "anna", "ben": "ben"}
    silent = plan(folder(tmp_path / "silent", dict.fromkeys(ANNA, "")))
    assert silent.gives == {"video", "audio", "faces", "one_speaker", "arpabet"}
    (tmp_path / "list.tsv").write_text("file\ttranscript\temotion\na.mp4\tx\thappy\nb.mp4\ty\nc.mp4\tz\n")
    assert "emotion" in plan(folder(tmp_path, {}, "list.tsv")).gives


def test_one_of_several_speakers_is_selected(tmp_path):
    given = folder(tmp_path, {**ANNA, **BEN})
    anna = plan({**given, "speaker": "anna"})
    assert list(anna.split) == [f"anna-{n}" for n in range(4)] and anna.speakers == {"anna": "anna"}
    assert "one_speaker" in anna.gives
    with pytest.raises(CorpusError, match="speaker 'Anna' .* there are anna, ben. Set `speaker` to one of them"):
        plan({**given, "speaker": "Anna"})


def test_the_split_is_stratified_by_speaker(tmp_path):
    found = plan(folder(tmp_path, {**ANNA, **BEN}))
    for speaker in ("anna", "ben"):
        assert {found.split[name] for name in found.split if name.startswith(speaker)} == {
            "train",
            "validation",
            "test",
        }
    with pytest.raises(CorpusError, match="the speaker 'carl' has 1 utterances. Give at least three"):
        plan(folder(tmp_path, {"carl/0.mp4": "hello"}))


def test_speakers_have_file_names_of_their_own(tmp_path):
    (tmp_path / "list.csv").write_text(
        "file,transcript,speaker\n" + "".join(f"{n}.mp4,x,{name}\n" for n, name in enumerate(["a b"] * 3 + ["c"] * 3))
    )
    assert plan(folder(tmp_path, {}, "list.csv")).speakers == {"a_b-c8687a08aa": "a b", "c": "c"}
    others = ["a b"] * 3 + ["a_b"] * 3 + ["你好"] * 3 + ["再见"] * 3
    (tmp_path / "list.csv").write_text(
        "file,transcript,speaker\n" + "".join(f"{n}.mp4,x,{name}\n" for n, name in enumerate(others))
    )
    found = plan(folder(tmp_path, {}, "list.csv")).speakers
    assert sorted(found.values()) == sorted(set(others)) and found["a_b"] == "a_b"
    others = ["Zo\u00eb"] * 3 + ["Zoe\u0308"] * 3
    (tmp_path / "list.csv").write_text(
        "file,transcript,speaker\n" + "".join(f"{n}.mp4,x,{name}\n" for n, name in enumerate(others))
    )
    with pytest.raises(CorpusError, match="differ only in how their letters are encoded"):
        plan(folder(tmp_path, {}, "list.csv"))
