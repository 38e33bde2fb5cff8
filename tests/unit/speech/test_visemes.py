import pytest

from visualspeech.speech.phones import PHONES
from visualspeech.speech.visemes import NAMES, VISEMES, TimedViseme, visemes_of


def test_every_phone_has_visemes_and_every_viseme_phones():
    assert set(VISEMES) == set(PHONES)
    assert {name for names in VISEMES.values() for name in names} == set(NAMES) and len(NAMES) == 15


@pytest.mark.parametrize(
    ("phones", "number"),
    [("p b m", 1), ("f v", 2), ("th dh", 3), ("t d", 4), ("k g", 5), ("ch jh sh", 6), ("s z", 7), ("n l", 8), ("r", 9),
     ("aa", 10), ("eh", 11), ("ih", 12), ("ao", 13), ("uh", 14), ("sil", 0)],
)  # fmt: skip
def test_the_numbers_are_those_of_mpeg4(phones, number):
    """ISO/IEC 14496-2, Annex C: the examples of the table, each sound in ARPAbet."""
    for phone in phones.split():
        assert [one.number for one in visemes_of([(phone, 0.0, 1.0)])] == [number]


def test_diphthongs_are_two_and_equal_neighbours_one():
    found = list(visemes_of([("sil", 0, 1), ("p", 1, 1.5), ("b", 1.5, 2), ("ay", 2, 3), ("iy", 3, 3.5)]))
    assert found == [
        TimedViseme("sil", 0, 1), TimedViseme("PP", 1, 2), TimedViseme("aa", 2, 2.5), TimedViseme("ih", 2.5, 3.5),
    ]  # fmt: skip


def test_phones_of_another_set_have_none():
    assert list(visemes_of([("ʃ", 0, 1), ("p", 1, 2), ("spn", 2, 3), ("p", 3, 4)])) == [
        TimedViseme("PP", 1, 2), TimedViseme("PP", 3, 4),
    ]  # fmt: skip
    assert list(visemes_of([])) == []
