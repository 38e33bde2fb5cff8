"""Intervals of other programs become an alignment, or a sentence with file, tier, time and label."""

import pytest

from visualspeech.errors import RejectedUtterance
from visualspeech.speech.given import Given, Interval, assembled, cut
from visualspeech.speech.phone_sets import PhoneSet

WORDS = ((0.2, 0.5, "Be"), (0.5, 0.9, "me"))
PHONES = ((0.2, 0.3, "B"), (0.3, 0.5, "IY1"), (0.5, 0.7, "M"), (0.7, 0.9, "IY1"))


def given(words=WORDS, phones=PHONES, **more):
    tiers = (tuple(Interval(*one) for one in tier) for tier in (words, phones))
    return Given("a.TextGrid", *tiers, **more)


def labels(tier):
    return [(one.label, one.start, one.end, one.parent) for one in tier]


def replaced(tier, number, *fields):
    return (*tier[:number], fields, *tier[number + 1 :])


def test_pauses_are_the_gaps():
    found = assembled(given(), 1.2, PhoneSet())
    assert labels(found.alignment.words) == [("sil", 0, 0.2, -1), ("be", 0.2, 0.5, -1), ("me", 0.5, 0.9, -1),
                                             ("sil", 0.9, 1.2, -1)]  # fmt: skip
    assert labels(found.alignment.phones) == [
        ("sil", 0, 0.2, 0), ("b", 0.2, 0.3, 1), ("iy", 0.3, 0.5, 1), ("m", 0.5, 0.7, 2), ("iy", 0.7, 0.9, 2),
        ("sil", 0.9, 1.2, 3)]  # fmt: skip
    assert [one.label for one in found.alignment.states] == ["1", "2", "3"] * 6
    assert found.alignment.states[4].start == pytest.approx(0.2 + 0.1 / 3, abs=1e-5)
    assert found.warnings == ()


@pytest.mark.parametrize("pause", ["", "sil", "sp", "SIL", "<eps>"])
def test_labelled_pauses(pause):
    phones = ((0, 0.2, pause), *PHONES, (0.9, 1.2, pause))
    assert assembled(given(phones=phones), 1.2, PhoneSet()) == assembled(given(), 1.2, PhoneSet())


def test_unknown_sound_is_a_pause_with_a_warning():
    words, phones = (*WORDS, (0.9, 1.1, "<unk>")), (*PHONES, (0.9, 1.1, "spn"))
    found = assembled(given(words, phones), 1.2, PhoneSet())
    assert labels(found.alignment.phones)[-1] == ("sil", 0.9, 1.2, 3)
    assert [text for text, _ in found.warnings] == [
        "a.TextGrid: sound without phones counts as a pause: 1 interval, the first 'spn' at 0.90 s"
    ]


def test_a_pause_inside_a_word_belongs_to_it():
    found = assembled(given(phones=replaced(PHONES, 0, 0.2, 0.25, "B")), 1.2, PhoneSet()).alignment
    assert labels(found.phones)[2] == ("sil", 0.25, 0.3, 1) and len(found.words) == 4


def test_rounding_is_no_pause_and_no_overlap():
    phones = ((0.2, 0.297, "B"), (0.3, 0.502, "IY1"), (0.5, 0.7, "M"), (0.7, 0.9, "IY1"))
    found = labels(assembled(given(phones=phones), 0.902, PhoneSet()).alignment.phones)
    assert found == [("sil", 0, 0.2, 0), ("b", 0.2, 0.3, 1), ("iy", 0.3, 0.502, 1), ("m", 0.502, 0.7, 2),
                     ("iy", 0.7, 0.902, 2)]  # fmt: skip


def test_labels_of_two_phones_are_divided():
    found = assembled(given(phones=((0.2, 0.5, "m̩"), (0.5, 0.9, "iː"))), 0.9, PhoneSet("ipa")).alignment
    assert labels(found.phones)[1:3] == [("ah", 0.2, 0.35, 1), ("m", 0.35, 0.5, 1)]


def test_labels_as_they_are():
    found = assembled(given(phones=((0.2, 0.5, "pʰ"), (0.5, 0.9, "øː"))), 0.9, PhoneSet("as_is")).alignment
    assert [one.label for one in found.phones] == ["sil", "pʰ", "øː"]


@pytest.mark.parametrize(
    ("words", "phones", "seconds", "reason"),
    [
        (WORDS, replaced(PHONES, 1, 0.3, 0.5, "QQ"), 1, "a.TextGrid, tier 'phones', 0.30 s: 'QQ' is no phone"),
        (WORDS, replaced(PHONES, 1, 0.25, 0.5, "IY1"), 1, "0.25 s: 'IY1' begins before 'B' ends at 0.30 s"),
        (WORDS, replaced(PHONES, 1, 0.5, 0.3, "IY1"), 1, "0.50 s: 'IY1' ends at 0.30 s, not after its start"),
        (WORDS, replaced(PHONES, 0, -0.2, 0.3, "B"), 1, "-0.20 s: 'B' starts before 0 s"),
        (WORDS, replaced(PHONES, 0, float("nan"), 0.3, "B"), 1, "tier 'phones': a time of 'B' is no number"),
        (WORDS, replaced(PHONES, 3, 0.7, float("inf"), "IY1"), 1, "a time of 'IY1' is no number"),
        (WORDS, PHONES, 0.8, "'iy' ends at 0.90 s, after the end of the sound at 0.80 s"),
        (WORDS, PHONES, 0.7, "after the end of the sound"),
        (WORDS[:1], PHONES, 1, "tier 'phones', 0.50 s: 'M' lies in no word of the tier 'words'"),
        ((*WORDS, (0.9, 1.0, "oh")), PHONES, 1, "tier 'words', 0.90 s: 'oh' has no phones in the tier 'phones'"),
        (replaced(WORDS, 1, 0.4, 0.9, "me"), PHONES, 1, "tier 'words', 0.40 s: 'me' begins before 'Be' ends"),
        ((), (), 1, "the tier 'phones' has no phone of speech"),
        ((), ((0.2, 0.4, "sil"),), 1, "has no phone of speech"),
    ],
)
def test_bad_intervals_are_a_sentence(words, phones, seconds, reason):
    with pytest.raises(RejectedUtterance) as error:
        assembled(given(words, phones), seconds, PhoneSet())
    assert reason in error.value.reason and "a.TextGrid" in error.value.reason and error.value.remedy


def test_a_phone_may_end_a_little_after_the_sound():
    assert assembled(given(), 0.87, PhoneSet()).alignment.duration == 0.87


def test_a_file_of_another_length_is_reported():
    ((warning, _),) = assembled(given(seconds=2.0), 1.2, PhoneSet()).warnings
    assert warning == "a.TextGrid is 2.00 s long, the sound of the recording 1.20 s"


def test_states_of_a_tier():
    states = [
        (0.2, 0.21, "1"),
        (0.21, 0.25, "2"),
        (0.25, 0.3, "3"),
        (0.3, 0.4, "1"),
        (0.4, 0.45, "2"),
        (0.45, 0.52, "3"),
    ]
    own = given(states=tuple(Interval(*one) for one in states))
    found = assembled(own, 0.9, PhoneSet(), from_tier=True)
    assert [(one.start, one.end) for one in found.alignment.states[3:6]] == [(0.2, 0.21), (0.21, 0.25), (0.25, 0.3)]
    ((warning, _),) = found.warnings
    assert "does not fit 3 of its phones" in warning  # "IY1" was moved by hand; "M" and the last have no states
    assert assembled(own, 0.9, PhoneSet()).warnings == ()


def test_a_part_of_a_recording():
    found = cut(given(seconds=5.0), 0.3, 0.7)
    assert [(one.label, round(one.start, 3), round(one.end, 3)) for one in found.phones] == [
        ("IY1", 0, 0.2), ("M", 0.2, 0.4)]  # fmt: skip
    assert [one.label for one in found.words] == ["Be", "me"] and found.seconds == pytest.approx(0.4)
    assert cut(given(seconds=5.0), 0.6, 0.0).seconds == pytest.approx(4.4)
