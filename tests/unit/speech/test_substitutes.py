import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.phones import PHONES, SILENCE
from visualspeech.speech.substitutes import substitute, substitutes


def test_phones_that_are_known_stay():
    assert substitutes(PHONES, PHONES) == {}
    assert all(substitute(phone, PHONES) == phone for phone in PHONES)


@pytest.mark.parametrize("phone", PHONES[1:])
def test_every_phone_has_a_stand_in_of_its_own_look(phone):
    others = [other for other in PHONES if other != phone]
    found = substitute(phone, others)
    assert found != phone and found != SILENCE
    lips = {"b": "pm", "p": "bm", "m": "bp", "f": "v", "v": "f"}
    if phone in lips:
        assert found in lips[phone]


def test_a_small_inventory_still_serves():
    assert substitutes(["b", "iy", "zh"], ["sil", "p", "aa"]) == {"b": "p", "iy": "aa", "zh": "p"}


def test_other_phone_sets_are_refused():
    with pytest.raises(SettingError, match="not those of the voice"):
        substitutes(["b"], ["SIL", "B", "IY"])
    with pytest.raises(SettingError, match="not those of the voice"):
        substitutes(["b"], ["b", "aa"])  # knows no silence
    with pytest.raises(SettingError, match="no phone of English"):
        substitute("xx", PHONES)
