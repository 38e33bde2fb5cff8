"""The files of alignments, and the frames of silence."""

import time
from dataclasses import replace

import pytest

from tests.unit.speech.alignments import even_alignment
from visualspeech.errors import StorageError
from visualspeech.speech.alignment import alignments_of, read_alignments, silent_frames, to_table
from visualspeech.storage.tables import write_table

ALIGNMENT = even_alignment([("sil", ["sil"]), ("null", ["n", "ah", "l"]), ("a", ["ah"]), ("sil", ["sil"])], 0.07)
NAMED = {
    "z1": ALIGNMENT,
    "007": even_alignment([("sil", ["sil"])], 1.0),
    "b": even_alignment([("1", ["w", "ah", "n"])]),
}


def written(tmp_path, change=lambda table: table, named=NAMED):
    write_table(tmp_path / "alignment.tsv", change(to_table(named)))
    return tmp_path / "alignment.tsv"


def test_files_read_back_the_same_in_their_order(tmp_path):
    found = read_alignments(written(tmp_path))
    assert found == NAMED and list(found) == list(NAMED)
    assert isinstance(found["b"].words[0].start, float) and isinstance(found["b"].phones[0].parent, int)
    assert read_alignments(written(tmp_path, named={})) == {}


def test_some_utterances(tmp_path):
    found = read_alignments(written(tmp_path), {"b", "007", "unknown"})
    assert found == {name: NAMED[name] for name in ("007", "b")}
    assert read_alignments(written(tmp_path), []) == {}


def test_the_order_of_rows_does_not_matter(tmp_path):
    assert read_alignments(written(tmp_path, lambda table: table.sample(frac=1, random_state=1))) == NAMED


def changed(tier, column, value, row=1):
    def change(table):
        at = table[(table["id"] == "z1") & (table["tier"] == tier)].index[row]
        table = table.astype({column: object})
        table.loc[at, column] = value
        return table

    return change


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (changed("word", "tier", "syllable"), r"line 3 \(utterance z1, tier syllable\): the tier must be one of word"),
        (changed("phone", "start", "early"), "line 7 has 'early' in the column start, no number"),
        (changed("phone", "end", ""), "must be numbers"),
        (changed("phone", "end", "inf"), "must be numbers"),
        (changed("phone", "parent", 0.5), "whole numbers"),
        (changed("phone", "end", 0.01), "ends before it starts"),
        (changed("state", "label", "4"), "a number from 1 to 3"),
        (changed("phone", "index", 7), "must number the segments"),
        (changed("phone", "index", 0), "must number the segments"),
        (changed("word", "parent", 0), "no segment of the tier above"),
        (changed("phone", "parent", -1), "no segment of the tier above"),
        (changed("state", "parent", 6), "no segment of the tier above"),
        (changed("state", "start", 0.03), "does not start where"),
        (lambda table: table.drop(columns="parent"), "no column parent"),
        (
            lambda table: table[(table["id"] != "007") | (table["tier"] != "state")],
            "utterance 007 has no .* tier state",
        ),
    ],
)
def test_rows_that_do_not_fit_are_named(tmp_path, change, reason):
    path = written(tmp_path, change)
    with pytest.raises(StorageError, match=reason) as error:
        read_alignments(path)
    assert str(path) in str(error.value) and "run the same command again" in str(error.value)


def test_rows_are_checked_before_utterances_are_chosen(tmp_path):
    """A row whose id is damaged belongs to no utterance that is asked for."""
    lines = written(tmp_path).read_text().splitlines(keepends=True)
    path = tmp_path / "damaged.tsv"
    for at in range(1, len(lines)):
        path.write_text("".join(["x" + line if number == at else line for number, line in enumerate(lines)]))
        with pytest.raises(StorageError, match="damaged.tsv: "):
            read_alignments(path, {"z1", "b"})


def test_a_file_that_breaks_off_anywhere_is_noticed(tmp_path):
    text = written(tmp_path).read_text()
    path = tmp_path / "cut.tsv"
    whole = {text.index(f"{name}\tword\t0") for name in ("007", "b")} | {text.index("\n") + 1, len(text)}
    for end in range(1, len(text)):
        path.write_text(text[:end])
        if end in whole:  # between two utterances: the one that is missing is noticed where it is asked for
            with pytest.raises(StorageError, match="cut.tsv: .*utterance b is missing"):
                read_alignments(path)["b"]
            with pytest.raises(StorageError, match="cut.tsv: .*utterance b is missing"):
                alignments_of([path], ["b"])
        else:
            with pytest.raises(StorageError, match="cut.tsv: "):
                read_alignments(path)
    assert alignments_of([tmp_path / "alignment.tsv"], ["b"]) == {"b": NAMED["b"]}


def test_missing_files_and_other_files(tmp_path):
    with pytest.raises(StorageError, match="nothing.tsv"):
        read_alignments(tmp_path / "nothing.tsv")
    (tmp_path / "other.tsv").write_text("phone\nsil\n")
    with pytest.raises(StorageError, match="other.tsv: it has no column id"):
        read_alignments(tmp_path / "other.tsv")


def test_a_thousand_utterances_are_read_at_once(tmp_path):
    long = even_alignment([(f"w{number}", ["b", "aa", "t"]) for number in range(8)])
    path = written(tmp_path, named={f"u{number}": long for number in range(1000)})
    start = time.process_time()
    assert len(read_alignments(path)) == 1000
    assert time.process_time() - start < 10


def test_silent_frames_are_those_of_the_pauses():
    assert silent_frames(ALIGNMENT, 5, 10.0).tolist() == [True, False, False, False, True]
    # Frames beyond the end belong to the last phone.
    assert silent_frames(ALIGNMENT, 8, 10.0).tolist() == [True, *[False] * 3, *[True] * 4]
    assert not silent_frames(replace(ALIGNMENT, phones=ALIGNMENT.phones[1:3]), 4, 10.0).any()
