"""The preference test: fair draws, a key that fits, a count that is checked by hand."""

import pandas
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.preference import (
    answer_sheet,
    draw_pairs,
    key_table,
    preference_frame,
    preference_tables,
    tally,
)
from visualspeech.evaluation.published_results import published
from visualspeech.storage.tables import read_table, write_table

IDS = [f"u{i:02d}" for i in range(30)]
MODELS = ("FBB-128", "hmm_mge")


def test_draws_are_balanced_random_and_repeatable():
    pairs = draw_pairs(IDS, MODELS, 10, 1)
    assert pairs == draw_pairs(list(reversed(IDS)), MODELS, 10, 1) != draw_pairs(IDS, MODELS, 10, 2)
    assert [pair.number for pair in pairs] == list(range(1, 11))
    assert len({pair.utterance for pair in pairs}) == 10 and {pair.utterance for pair in pairs} <= set(IDS)
    assert sum(pair.left == "FBB-128" for pair in pairs) == 5
    assert all({pair.left, pair.right} == set(MODELS) for pair in pairs)
    orders = {tuple(pair.left for pair in draw_pairs(IDS, MODELS, 10, seed)) for seed in range(20)}
    assert len(orders) > 15


def test_odd_numbers_favour_nobody():
    left = [sum(pair.left == "FBB-128" for pair in draw_pairs(IDS, MODELS, 5, seed)) for seed in range(200)]
    assert set(left) == {2, 3} and 70 < left.count(2) < 130


def test_answers_are_counted_by_the_key():
    pairs = draw_pairs(IDS, MODELS, 4, 3)
    key = key_table(pairs)
    lines = []
    for listener in ("x", "y"):
        for pair in pairs:
            preferred = "A" if pair.left == "FBB-128" else "B"
            lines.append((listener, pair.number, "neutral" if listener == "y" and pair.number == 1 else preferred))
    answers = pandas.DataFrame(lines, columns=["listener", "pair", "answer"])
    found = tally(answers, key)
    assert dict(found.counts) == {"FBB-128": 7, "neutral": 1, "hmm_mge": 0}
    assert (found.listeners, found.pairs) == (2, 4)
    assert found.p == pytest.approx(2 / 2**7) and found.share("FBB-128") == pytest.approx(7 / 8)
    paper = published("fan2015")
    assert preference_frame(found, paper).groupby("source")["share"].sum().to_list() == pytest.approx([1, 1])
    run, printed = preference_tables(found, (("corpus", "demo"),), paper, {"hmm_mge": "MGE-trained HMM"})
    assert run.columns == ("FBB-128", "neutral", "MGE-trained HMM") and run.facts[0] == ("corpus", "demo")
    assert [cell.text for cell in run.rows[0].cells] == ["87.5%", "12.5%", "0.0%"]
    assert [cell.text for cell in printed.rows[0].cells] == ["61.5%", "15.5%", "23.0%"]
    assert len(preference_tables(found)) == len(set(preference_frame(found)["source"])) == 1


def test_the_sheet_is_empty_and_has_no_models():
    sheet = answer_sheet(draw_pairs(IDS, MODELS, 4, 3))
    assert list(sheet.columns) == ["listener", "pair", "answer"] and set(sheet["answer"]) == {""}


def test_mistakes_are_named():
    for models, count in ((("FBB-128",), 4), (("a", "a"), 4), (MODELS, 0)):
        with pytest.raises(SettingError, match="preference"):
            draw_pairs(IDS, models, count, 1)
    key = key_table(draw_pairs(IDS, MODELS, 4, 3))
    for wrong in ({"answer": "C", "pair": 1}, {"answer": "A", "pair": 9}):
        with pytest.raises(DataError, match="answers.tsv: the answer .* cannot be counted"):
            tally(pandas.DataFrame([{"listener": "x", **wrong}]), key, "answers.tsv")
    with pytest.raises(DataError, match="answers.tsv holds no answers. Fill in"):
        tally(pandas.DataFrame(columns=["listener", "pair", "answer"]), key, "answers.tsv")


@pytest.mark.parametrize("answered", [0, 3])
def test_a_sheet_that_is_blank_or_partly_blank(tmp_path, answered):
    """As it is written for the listener, and read back by the job."""
    pairs, path = draw_pairs(IDS, MODELS, 5, 3), tmp_path / "answers.tsv"
    sheet = answer_sheet(pairs)
    sheet.loc[: answered - 1, ["listener", "answer"]] = ["x", " neutral "]
    write_table(path, sheet)
    read = read_table(path, ("listener", "answer"))
    if not answered:
        with pytest.raises(DataError, match="answers.tsv holds no answers. Fill in"):
            tally(read, key_table(pairs), str(path))
        return
    found = tally(read, key_table(pairs), str(path))
    assert (found.counts["neutral"], found.listeners, found.pairs, found.blank) == (3, 1, 3, 2)
    assert dict(preference_tables(found)[0].facts)["rows without an answer, ignored"] == "2"
