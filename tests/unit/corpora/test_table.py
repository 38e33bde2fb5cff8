"""Tables of utterances: what is written is read back, whatever is in a name."""

import os
from dataclasses import asdict, replace

import pytest

from visualspeech.corpora.records import Utterance, displayable
from visualspeech.corpora.table import read_utterances, write_accepted, write_utterances

ODD = ["a b", "br{ace}s", "x'y\"", '"quoted"', "new\nline", "tab\there", "NA", "null", "1e5", "\u2028sep",
       "back\\slash", "ünï", "你好", "#x", "-dash", " lead", os.fsdecode(b"lat\xe9"), "carriage\rreturn"]  # fmt: skip
HEAD = "id\tspeaker\tmedia\ttranscript\temotion\tstart\tend\taudio\tmotion\n"


@pytest.mark.parametrize("problem", ["", "it is broken"])
def test_odd_names_are_read_as_they_were_written(tmp_path, problem):
    written = [
        Utterance(f"u{number}", displayable(name), f"/{displayable(name)}.mp4", name if name.isascii() else "x")
        for number, name in enumerate(ODD[:-1])
    ]
    written[0] = replace(written[0], problem=problem, remedy=problem)
    write_utterances(tmp_path / "table.tsv", [asdict(one) for one in written])
    assert read_utterances(tmp_path / "table.tsv") == written
    assert read_utterances(tmp_path / "table.tsv")[0].problem == problem


def test_a_carriage_return_cannot_break_a_row(tmp_path):
    one = Utterance("u", displayable(ODD[-1]), f"/{displayable(ODD[-1])}.mp4", "x")
    write_utterances(tmp_path / "table.tsv", [asdict(one)])
    assert read_utterances(tmp_path / "table.tsv") == [one]


def test_problems_have_columns_only_where_there_are_any(tmp_path):
    good, bad = Utterance("a", "s", "a.mp4", "x"), Utterance("b", "s", "b.mp4", "", problem="broken", remedy="repair")
    write_utterances(tmp_path / "table.tsv", [asdict(good)])
    assert (tmp_path / "table.tsv").read_text().startswith(HEAD)
    write_utterances(tmp_path / "table.tsv", [asdict(good), asdict(bad)])
    assert (tmp_path / "table.tsv").read_text().startswith(HEAD[:-1] + "\tproblem\tremedy\n")
    warned = Utterance("c", "s", "c.mp4", "x", warning="no emotion", remedy="restore")
    write_utterances(tmp_path / "table.tsv", [asdict(good), asdict(warned)])
    assert (tmp_path / "table.tsv").read_text().startswith(HEAD[:-1] + "\tremedy\twarning\n")
    assert read_utterances(tmp_path / "table.tsv") == [good, warned]
    write_accepted(tmp_path / "accepted.tsv", [good], {"a": "train"})
    assert (tmp_path / "accepted.tsv").read_text().startswith(HEAD.replace("\temotion", "\tsplit\temotion"))
