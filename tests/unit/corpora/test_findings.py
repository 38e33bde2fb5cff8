"""Findings: their table, and when a corpus is refused."""

import pytest

from visualspeech.corpora.findings import (
    Finding,
    check_share,
    read_findings,
    rejected_ids,
    rejection,
    write_findings,
)
from visualspeech.errors import CorpusError, RejectedUtterance

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
