"""Phone sets of other aligners: ARPAbet with stress, IPA of MFA, tables, and labels as they are."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.phone_sets import PhoneSet, arpabet_of, checked_table
from visualspeech.speech.phones import CLASSES, PHONES

# The phones of the dictionaries english_us_mfa, english_uk_mfa and english_mfa, version 3.1.
MFA = (
    "a aj aw aː b bʲ c cʰ cʷ d dʒ dʲ d̪ e ej eː f fʲ h i iː j k kp kʰ kʷ l m mʲ m̩ n n̩ o ow oː p pʰ pʲ pʷ s t "
    "tʃ tʰ tʲ tʷ t̪ u uː v vʲ vʷ w z æ ç ð ŋ ɐ ɑ ɑː ɒ ɒː ɔ ɔj ɖ ə əw ɚ ɛ ɛː ɜ ɜː ɝ ɟ ɟʷ ɡ ɡʷ ɪ ɫ ɫ̩ ɱ ɲ ɹ "
    "ɾ ɾʲ ɾ̃ ʃ ʈ ʈʲ ʈʷ ʉ ʉː ʊ ʋ ʎ ʒ ʔ θ"
).split()


def test_every_phone_of_mfa_is_mapped_and_all_of_arpabet_is_reached():
    found = {label: PhoneSet("ipa").phones(label) for label in MFA}
    assert [label for label, phones in found.items() if phones is None] == []
    assert {phone for phones in found.values() for phone in phones} == set(PHONES) - {"sil"}


@pytest.mark.parametrize("label", MFA)
def test_lips_stay_what_they_are(label):
    """Another route than the table: the base letter of a consonant says whether and how the lips close."""
    lips = {"b": "bilabial", "p": "bilabial", "m": "bilabial", "ɱ": "bilabial", "f": "labiodental", "v": "labiodental"}
    closing = {phone for name in ("bilabial", "labiodental") for phone in CLASSES[name]}
    spoken = PhoneSet("ipa").phones(label)
    if label[0] in lips:
        assert spoken[-1] in CLASSES[lips[label[0]]]
    elif label not in ("kp", "ʋ"):
        assert not closing & set(spoken)


@pytest.mark.parametrize(
    ("label", "phones"),
    [("AH0", "ah"), ("ah", "ah"), ("AH0_I", "ah"), ("HH_B", "hh"), ("NG", "ng"), ("AXR", "er"), ("EL", "ah l"),
     ("", "sil"), ("sil", "sil"), ("SP", "sil"), ("<eps>", "sil")],
)  # fmt: skip
def test_arpabet(label, phones):
    assert PhoneSet().phones(label) == tuple(phones.split())


@pytest.mark.parametrize(
    ("label", "phones"),
    [("ˈæ", "ae"), ("t͡ʃ", "ch"), ("aɪ", "ay"), ("n̩", "ah n"), ("pʰ", "p"), ("oʊ", "ow"), ("i:", "iy"), ("kʰ_B", "k"),
     ("ç", "hh"), ("ç", "hh")],
)  # fmt: skip
def test_ipa(label, phones):
    assert PhoneSet("ipa").phones(label) == tuple(phones.split())


def test_labels_of_other_sets_are_unknown():
    assert PhoneSet().phones("ʃ") is None and PhoneSet().phones("XX") is None and PhoneSet().phones("AH9") is None
    assert PhoneSet("ipa").phones("AH0") is None and PhoneSet("ipa").phones("ʘ") is None
    assert PhoneSet("mine.tsv", {"x": "k s"}).phones("b") is None  # a table is complete


def test_a_table_comes_before_pauses():
    mine = PhoneSet("mine.tsv", checked_table({"x": "K S", "sp": "s P", "6": "ah1", "#": "sil"}, "the table"))
    assert [mine.phones(label) for label in ("x", "sp", "6", "#", "sil")] == [
        ("k", "s"), ("s", "p"), ("ah",), ("sil",), ("sil",)]  # fmt: skip


def test_labels_as_they_are():
    own = PhoneSet("as_is")
    assert own.phones("pʰ") == ("pʰ",) and own.phones("AH0") == ("AH0",) and own.phones("sp") == ("sil",)
    assert own.phones("a b") is None and own.phones("x" * 50) is None and own.phones("a\x07") is None
    assert not own.is_arpabet and PhoneSet("ipa").is_arpabet


def test_what_a_label_of_any_set_stands_for():
    assert [arpabet_of(label) for label in ("p", "pʰ", "m̩", "AH0", "sil", "?")] == ["p", "p", "m", "ah", "sil", ""]
    assert all(arpabet_of(phone) == phone for phone in PHONES)


@pytest.mark.parametrize(
    ("table", "reason"),
    [({}, "empty"), ({"x": "qq"}, "no phone of ARPAbet"), ({"x": ""}, "one or more phones"), ({"x": 3}, "two texts"),
     ({"a b": "aa"}, "no possible label"), ({"x": "aa sil"}, "one or more phones")],
)  # fmt: skip
def test_a_wrong_table_is_a_sentence(table, reason):
    with pytest.raises(SettingError, match=f"the table of phones.*{reason}"):
        checked_table(table, "the table of phones x.tsv")
