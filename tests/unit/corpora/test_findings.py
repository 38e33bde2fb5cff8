"""Findings: their table, and when a corpus is refused."""

import pytest

from visualspeech.corpora.findings import (
    Finding,
    attempt,
    check_share,
    check_splits,
    needed,
    read_findings,
    rejected_ids,
    rejection,
    write_findings,
)
from visualspeech.corpora.records import Utterance
from visualspeech.errors import CorpusError, DataError, RejectedUtterance, SettingError, StorageError
from visualspeech.jobs import job

WARNED = Finding("b", "check", "warn", "b.mp4", 'odd "rate",\twith a tab', "")
REFUSED = rejection("c", "landmarks", "c.mp4", RejectedUtterance("no face", "Turn to the camera."))


def test_findings_read_back_rejections_first(tmp_path):
    write_findings(tmp_path / "f.tsv", [WARNED, REFUSED])
    assert read_findings(tmp_path / "f.tsv") == [REFUSED, WARNED]


def test_no_findings_are_an_empty_table(tmp_path):
    write_findings(tmp_path / "f.tsv", [])
    assert read_findings(tmp_path / "f.tsv") == []


def test_a_warning_rejects_nothing():
    assert rejected_ids([WARNED, REFUSED]) == {"c"}


def test_a_share_up_to_the_limit_is_accepted_and_one_beyond_is_not():
    check_share([WARNED, REFUSED, REFUSED], 5, 0.2)
    with pytest.raises(CorpusError, match=r"1 of 4 utterances.*\n.*c\.mp4: no face\. Turn to the camera\."):
        check_share([REFUSED], 4, 0.2)


def test_all_rejected_is_refused_whatever_the_limit():
    with pytest.raises(CorpusError, match="1 of 1"):
        check_share([REFUSED], 1, 1.0)


UTTERANCES = [Utterance(name, "s", f"{name}.mp4", "hello") for name in "abc"]


def fails_for_b(one, error):
    if one.id == "b":
        raise error
    return one.id


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ValueError("bad\nheader"), "unexpected error: ValueError: bad header"),
        (RejectedUtterance("no face", "Turn."), "no face"),
        (DataError("9 frames, 8 points"), "9 frames, 8 points"),
        (OSError(5, "Input/output error"), "unexpected error: OSError"),
        (RecursionError("too deep"), "unexpected error: RecursionError"),
    ],
)
def test_what_fails_for_one_utterance_leaves_the_others(tmp_path, capsys, error, reason):
    with job(tmp_path / "stage.log"):
        outcomes = [attempt(one, "textures", fails_for_b, one, error) for one in UTTERANCES]
    assert [one.value for one in outcomes] == ["a", None, "c"]
    (finding,) = [finding for one in outcomes for finding in one.findings]
    assert (finding.id, finding.stage, finding.level, finding.file) == ("b", "textures", "reject", "b.mp4")
    assert finding.finding.startswith(reason) and "\n" not in finding.finding and finding.remedy
    shown, logged = capsys.readouterr().err, (tmp_path / "stage.log").read_text()
    unexpected = "unexpected" in reason
    assert "Traceback" not in shown and ("Traceback" in logged) == unexpected
    assert len(shown.splitlines()) == unexpected


@pytest.mark.parametrize(
    "error",
    [StorageError("x"), SettingError("x"), CorpusError("x"), MemoryError(), KeyboardInterrupt(), OSError(28, "full")],
)
def test_what_fails_for_the_run_ends_it(error):
    with pytest.raises(type(error)):
        attempt(UTTERANCES[1], "textures", fails_for_b, UTTERANCES[1], error)


def test_what_cannot_do_without_an_utterance_names_its_file():
    with pytest.raises(CorpusError, match=r"^b.mp4: no face. Turn.$"), needed(UTTERANCES[1]):
        raise RejectedUtterance("no face", "Turn.")
    with pytest.raises(StorageError, match="^x$"), needed(UTTERANCES[1]):
        raise StorageError("x")


def test_a_split_that_was_rejected_as_a_whole_is_refused():
    parts = [Utterance(name, "s", "m", "x", split=name) for name in ("train", "validation", "test")]
    check_splits(parts)
    with pytest.raises(CorpusError, match="'test'"):
        check_splits(parts[:2])
