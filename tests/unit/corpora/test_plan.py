"""The plan of a corpus: tables that change only where their content does, and the hold on the results folder."""

import os
import subprocess
import sys
import time

import pytest
from visualspeech.corpora.plan import hold, plan_corpus

from visualspeech.corpora.records import shard_of
from visualspeech.corpora.table import read_split, read_utterances
from visualspeech.errors import StorageError

SHARES = {"train": 0.8, "validation": 0.1, "test": 0.1}


def demo(count):
    return {"name": "d", "adapter": "demo", "utterances": count, "seed": 1}


def stamps(folder):
    return {path.name: path.stat().st_mtime_ns for path in (folder / "d" / "corpus").rglob("*.tsv")}


def test_plan_lists_every_utterance_once_in_its_shard(tmp_path):
    plan = plan_corpus(demo(20), 3, SHARES, 1, str(tmp_path))
    read = {shard: read_utterances(tmp_path / "d" / "corpus" / "utterances" / f"{shard}.tsv") for shard in plan.shards}
    assert sum(map(len, read.values())) == 20
    assert all(shard_of(one.id, 3) == int(shard) for shard, members in read.items() for one in members)
    split = read_split(tmp_path / "d" / "corpus" / "split.tsv")
    assert sorted(split) == sorted(one.id for members in read.values() for one in members)
    assert plan.media["0"] == [f"{tmp_path}/d/recordings/0"]


def test_planning_again_touches_nothing(tmp_path):
    plan_corpus(demo(20), 3, SHARES, 1, str(tmp_path))
    before = stamps(tmp_path)
    time.sleep(0.01)
    plan_corpus(demo(20), 3, SHARES, 1, str(tmp_path))
    assert stamps(tmp_path) == before


def test_one_more_utterance_touches_one_shard(tmp_path):
    plan_corpus(demo(20), 3, SHARES, 1, str(tmp_path))
    before = stamps(tmp_path)
    time.sleep(0.01)
    plan_corpus(demo(21), 3, SHARES, 1, str(tmp_path))
    changed = {name for name, stamp in stamps(tmp_path).items() if stamp != before[name]}
    assert len(changed - {"split.tsv"}) == 1


def test_the_hold_ends_with_its_process_however_it_ends(tmp_path):
    code = (
        "import sys, time; from visualspeech.corpora.plan import hold; "
        f"lock = hold({str(tmp_path)!r}); print('held', flush=True); time.sleep(60)"
    )
    other = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert other.stdout.readline() == "held\n"
    with pytest.raises(StorageError, match="another run is using"):
        hold(tmp_path)
    other.kill()
    other.wait()
    hold(tmp_path).close()


def test_a_file_in_the_place_of_the_results_is_a_sentence(tmp_path):
    (tmp_path / "results").write_text("")
    with pytest.raises(StorageError, match="cannot write to the results folder"):
        hold(tmp_path / "results")
    assert os.path.isfile(tmp_path / "results")
