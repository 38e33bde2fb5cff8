import numpy as np

from visualspeech.models.hmm.questions import phone_sets, questions
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
    triphones = np.array([[0, 1, 2], [2, 1, 0]])
    answer = dict(zip(asked.names, asked.answers(triphones).tolist(), strict=True))
    assert answer["right bilabial"] == [True, False]
    assert answer["left bilabial"] == [False, True]
    assert answer["current vowel"] == [True, True]


def test_an_inventory_of_other_phones_still_has_questions():
    assert len(questions(("sil", "x1", "x2")).names) == 9
