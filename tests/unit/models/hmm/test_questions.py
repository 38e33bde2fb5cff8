import numpy as np
import pytest

from visualspeech.models.hmm.questions import number_sets, phone_sets, position_names, questions
from visualspeech.models.hmm.segments import Factor
from visualspeech.speech.phones import CLASSES, PHONES


def test_every_phone_can_be_asked_for():
    sets = phone_sets(PHONES)
    for number, phone in enumerate(PHONES):
        alone = np.arange(len(PHONES)) == number
        assert any(np.array_equal(alone, members) for members in sets.values()), phone


def test_sets_are_the_classes_and_none_twice():
    sets = phone_sets(PHONES)
    for name, members in CLASSES.items():
        chosen = np.array([phone in members for phone in PHONES])
        assert sum(np.array_equal(chosen, other) for other in sets.values()) == 1, name
    assert all(0 < members.sum() < len(PHONES) for members in sets.values())


def test_answers():
    asked = questions(("sil", "aa", "b", "m"))
    contexts = np.array([[0, 1, 2], [2, 1, 0]])
    answer = dict(zip(asked.names, asked.answers(contexts).tolist(), strict=True))
    assert answer["right bilabial"] == [True, False]
    assert answer["left bilabial"] == [False, True]
    assert answer["current vowel"] == [True, True]


def test_an_inventory_of_other_phones_still_has_questions():
    assert len(questions(("sil", "x1", "x2")).names) == 9


@pytest.mark.parametrize(
    ("columns", "centre", "names"),
    [
        (1, 0, ["current"]),
        (3, 1, ["left", "current", "right"]),
        (5, 2, ["left 2", "left", "current", "right", "right 2"]),
        (4, 0, ["current", "right", "right 2", "right 3"]),
    ],
)
def test_columns_have_names(columns, centre, names):
    assert position_names(columns, centre) == names
    asked = questions(("sil", "aa", "b"), columns, centre)
    assert asked.names[0].startswith(names[0]) and len(asked.names) == 3 * columns


def test_quinphones_are_asked_about_their_outer_phones():
    asked = questions(("sil", "aa", "b", "m"), 5, 2)
    answer = dict(zip(asked.names, asked.answers(np.array([[2, 0, 1, 0, 3], [0, 2, 1, 3, 0]])).tolist(), strict=True))
    assert answer["left 2 bilabial"] == [True, False] and answer["left bilabial"] == [False, True]
    assert answer["right 2 nasal"] == [True, False] and answer["right nasal"] == [False, True]


@pytest.mark.parametrize(("values", "count"), [(1, 0), (2, 1), (3, 3), (21, 39)])
def test_numbers_are_asked_for_up_to_each_and_for_each_alone(values, count):
    sets = number_sets(values)
    assert len(sets) == count and all(0 < members.sum() < values for members in sets.values())
    splits = {min(bytes(members), bytes(~members)) for members in sets.values()}
    assert len(splits) == count
    every = {min(bytes(asked), bytes(~asked)) for k in range(values) for asked in (np.arange(values) <= k,)}
    every |= {min(bytes(asked), bytes(~asked)) for k in range(values) for asked in (np.arange(values) == k,)}
    assert every - splits <= {bytes(values)}


def test_factors_are_asked_about_in_their_own_columns():
    asked = questions(("sil", "aa", "b"), 3, 1, (Factor("words in phrase", 5), Factor("syllable in word", 2)))
    contexts = np.array([[0, 1, 2, 3, 1], [2, 1, 0, 4, 0]])
    answer = dict(zip(asked.names, asked.answers(contexts).tolist(), strict=True))
    for name in ("at most 3", "equal to 3"):
        assert answer[f"words in phrase {name}"] == [True, False]
    assert answer["words in phrase at most 2"] == [False, False]
    assert answer["syllable in word at most 0"] == [False, True] and "syllable in word equal to 1" not in answer
    assert asked.members.shape == (len(asked.names), 5) and answer["current vowel"] == [True, True]


def test_phones_of_another_set_are_in_the_classes_of_what_they_stand_for():
    sets = phone_sets(["sil", "pʰ", "b", "ɑː", "iː", "%"])
    assert sets["stop"].tolist() == [False, True, True, False, False, False]
    assert sets["open"].tolist() == [False, False, False, True, False, False] and "%" in sets
