"""Where the alignment of a corpus comes from, as planning settles it: settings, tables, checks before any job."""

import pytest

from tests.unit.corpora.labels import PHONES, WORDS, write_grid
from tests.unit.planning.configs import planned, resolved
from visualspeech.errors import SettingError
from visualspeech.planning.alignment import phone_set
from visualspeech.planning.corpora import plan_corpus

SHARES = {"train": 0.6, "validation": 0.2, "test": 0.2}


def corpus(root, texts=True, **alignment):
    """Five empty recordings with TextGrids."""
    for number in range(5):
        write_grid(root / f"aligned/u{number}.TextGrid")
        (root / f"u{number}.mp4").write_bytes(b"")
        if texts:
            (root / f"u{number}.txt").write_text("be me")
    given = {"source": "textgrid", "folder": "aligned", **alignment}
    return {"name": "mine", "adapter": "folder", "root": str(root), "alignment": given}


def settled(root, **alignment):
    run = resolved({"corpora": [corpus(root, **alignment)], "systems": ["fan2015"], "split": SHARES})
    return plan_corpus(run["corpora"]["mine"], 2, SHARES, 1, "results")


def test_a_corpus_has_its_own_over_those_of_the_run(tmp_path):
    run = resolved({
        "alignment": {"padding": 0.3, "source": "ctm"},
        "corpora": ["demo", corpus(tmp_path)],
    })  # fmt: skip
    assert run["corpora"]["mine"]["alignment"]["source"] == "textgrid"
    assert {one["alignment"]["padding"] for one in run["corpora"].values()} == {0.3}
    assert run["corpora"]["demo"]["alignment"]["source"] == "ctm"


@pytest.mark.parametrize(
    ("alignment", "reason"),
    [
        ({"sorce": "ctm"}, "unknown setting `corpora.mine.alignment.sorce`. Did you mean `source`?"),
        ({"source": "grid"}, "`corpora.mine.alignment.source: grid` must be one of recogniser, textgrid, ctm"),
        ({"source": "recogniser"}, "`corpora.mine.alignment.folder: aligned` must be empty, or `source` be textgrid"),
        ({"source": "ctm", "states": "tier"}, "`corpora.mine.alignment.states: tier` must be thirds or recognised"),
        ({"phones": "as_is", "states": "recognised"}, "`corpora.mine.alignment.states: recognised` must be thirds"),
        ({"phones": "as_is", "dictionary": "x"}, "`corpora.mine.alignment.dictionary: x` must be empty with"),
        ({"phones": "as_is", "source": "recogniser", "folder": ""}, "the recogniser knows ARPAbet alone"),
    ],
)
def test_mistakes_name_the_key(tmp_path, alignment, reason):
    with pytest.raises(SettingError) as error:
        settled(tmp_path, **alignment)
    assert reason in str(error.value)


def test_the_words_of_the_files_are_the_text(tmp_path):
    given = corpus(tmp_path, texts=False)
    run = {"corpora": [given], "systems": ["fan2015"], "split": SHARES}
    plan = planned(run)
    assert plan.pairs == (("mine", "fan2015"),)
    plan.check_alignments()
    without = {**given, "alignment": {}}
    with pytest.raises(SettingError, match="it needs transcripts"):
        planned({**run, "corpora": [without]})


def test_what_needs_arpabet_is_skipped_with_one_sentence(tmp_path):
    given = corpus(tmp_path, phones="as_is")
    plan = planned({"corpora": [given], "systems": ["fan2015", "thangthai2016"], "split": SHARES})
    assert plan.pairs == (("mine", "fan2015"),)
    (said,) = plan.skipped
    assert said.startswith(
        "thangthai2016 is skipped on mine: it needs phones of ARPAbet (the corpus has `alignment.phon"
    )
    both = planned({"corpora": [corpus(tmp_path)], "systems": ["fan2015", "thangthai2016"], "split": SHARES})
    assert both.skipped == ()


def test_files_that_cannot_be_used_are_refused_before_any_job(tmp_path):
    with pytest.raises(SettingError, match="u0.TextGrid has no tier 'Wort'.*alignment.word_tier"):
        settled(tmp_path, word_tier="Wort").alignment.check()
    with pytest.raises(SettingError, match="u0.TextGrid, tier 'phones', 0.20 s: 'B' is no phone of the phone set ipa"):
        settled(tmp_path, phones="ipa").alignment.check()
    settled(tmp_path).alignment.check()
    (tmp_path / "own.dict").write_text("be B QQ\n")
    with pytest.raises(SettingError, match="own.dict, line 1: the phone 'QQ' of 'be' is none of the phone set arpabet"):
        settled(tmp_path, dictionary="own.dict").alignment.check()
    with pytest.raises(SettingError, match="`alignment.dictionary`: none.dict does not exist"):
        settled(tmp_path, dictionary="none.dict")


def test_files_among_the_results_are_refused(tmp_path):
    given = corpus(tmp_path / "clips", folder=str(tmp_path / "results/mine/alignment/textgrid"))
    with pytest.raises(SettingError, match="`corpora.mine.alignment.folder: .*` lies among the results.*copy it"):
        resolved({"corpora": [given], "results": str(tmp_path / "results")})


@pytest.mark.parametrize("detection", ["metadata", "content"])
def test_a_file_that_changes_re_runs_its_shard_alone(tmp_path, detection):
    def digests():
        given = {**resolved({"corpora": [corpus_], "split": SHARES})["corpora"]["mine"], "change_detection": detection}
        plan = plan_corpus(given, 2, SHARES, 1, "results")
        return {
            one.id: plan.alignment.digest(plan.ids(shard)) for shard in plan.shards for one in plan.utterances[shard]
        }

    corpus_ = corpus(tmp_path)
    before = digests()
    write_grid(tmp_path / "aligned/u1.TextGrid", {"words": WORDS, "phones": (*PHONES[:3], (0.7, 0.88, "IY1"))})
    after = digests()
    changed = {name for name in before if before[name] != after[name]}
    assert "u1" in changed and changed != set(before)


def test_a_dictionary_that_changes_re_runs_what_reads_it(tmp_path):
    path = tmp_path / "own.dict"
    path.write_text("be B IY1\n")
    before = settled(tmp_path, dictionary="own.dict").alignment
    assert before.dictionary == {"path": str(path), "phones": {"name": "arpabet", "table": {}}}
    seen = before.dictionary_digest()
    path.write_text("be B EH1\n")
    assert (
        before.dictionary_digest() == seen
        and settled(tmp_path, dictionary="own.dict").alignment.dictionary_digest() != seen
    )
    assert settled(tmp_path).alignment.dictionary == {}


@pytest.mark.parametrize(
    ("name", "text"),
    [("t.tsv", "phone\tarpabet\nI:\tIY1\nts\tt s\n_p\tsil\n"), ("t.txt", "I:  IY\nts t s\n_p sil\n"),
     ("t.csv", 'I:,iy\nts,"T S"\n_p,sil\n'), ("t.yaml", "'I:': iy\nts: t s\n_p: sil\n")],
)  # fmt: skip
def test_tables_of_phones(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    found = phone_set(name, str(tmp_path))
    assert found.name == name and dict(found.table) == {"I:": "iy", "ts": "t s", "_p": "sil"}


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        (
            "sampa",
            None,
            "`alignment.phones: sampa` is not known. Known: arpabet, ipa, as_is. Or give the path of a table",
        ),
        ("none.tsv", None, "`alignment.phones`: none.tsv does not exist"),
        ("t.tsv", "a\taa\nb\n", "t.tsv, line 2: 'b' has no phones"),
        ("t.tsv", "a\taa\na\tae\n", "t.tsv, line 2: 'a' is given twice"),
        ("t.tsv", "a\tqq\n", "'qq', given for 'a', is no phone of ARPAbet"),
        ("t.tsv", "", "is empty"),
        ("t.yaml", "- a\n", "must hold `key: value` lines"),
        ("t.yaml", "a: 3\n", "must be two texts"),
    ],
)
def test_wrong_tables_are_a_sentence(tmp_path, name, text, reason):
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(SettingError) as error:
        phone_set(name, str(tmp_path))
    assert reason in str(error.value)
