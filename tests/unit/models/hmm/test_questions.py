import numpy as np
import pytest

from visualspeech.models.hmm.questions import phone_sets, position_names, questions
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
