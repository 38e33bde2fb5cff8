"""The preference test: fair draws, a key that fits, a count that is checked by hand."""

import pandas
import pytest

from visualspeech.errors import DataError, SettingError
from visualspeech.evaluation.preference import (
    answer_sheet,
    draw_pairs,
    key_table,
    preference_frame,
    preference_sheets,
    tally,
)

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
    frame = preference_frame(found, {"deep BLSTM": 0.6, "neutral": 0.1, "HMM": 0.3})
    assert frame.groupby("source")["share"].sum().to_list() == pytest.approx([1, 1])
    ours, theirs = preference_sheets(found, {"deep BLSTM": 0.6, "neutral": 0.1, "HMM": 0.3}, "a paper")
    assert [cell.text for cell in ours.rows[0][1]] == ["87.5%", "12.5%", "0.0%"]
    assert theirs.facts == (("source", "a paper"),)


def test_the_sheet_is_empty_and_has_no_models():
    sheet = answer_sheet(draw_pairs(IDS, MODELS, 4, 3))
    assert list(sheet.columns) == ["listener", "pair", "answer"] and set(sheet["answer"]) == {""}


def test_mistakes_are_named():
    for models, count in ((("FBB-128",), 4), (("a", "a"), 4), (MODELS, 0)):
        with pytest.raises(SettingError, match="preference"):
            draw_pairs(IDS, models, count, 1)
    key = key_table(draw_pairs(IDS, MODELS, 4, 3))
    for wrong in ({"answer": "C", "pair": 1}, {"answer": "A", "pair": 9}, {"answer": "", "pair": 1}):
        with pytest.raises(DataError, match="cannot be counted"):
            tally(pandas.DataFrame([{"listener": "x", **wrong}]), key)
    with pytest.raises(DataError, match="no answer"):
        tally(pandas.DataFrame(columns=["listener", "pair", "answer"]), key)
