"""Synthetic speech and letter-to-sound."""

import time

import numpy as np
import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.tts import letter_to_sound, letters_to_sounds, synthesise

ARPABET = set(
    "aa ae ah ao aw ay b ch d dh eh er ey f g hh ih iy jh k l m n ng ow oy p r s sh t th uh uw v w y z zh sil".split()
)


@pytest.fixture(scope="module")
def speech():
    return synthesise("A happy puppy of the pub, jumping up to catch 12 apples.")


def test_same_text_same_samples(speech):
    again = synthesise("A happy puppy of the pub, jumping up to catch 12 apples.")
    assert np.array_equal(speech.samples, again.samples)
    assert speech.phones == again.phones and speech.words == again.words


def test_a_voice_with_breath_says_the_same_in_another_second():
    """eSpeak NG takes the time in seconds for the seed of its noise."""
    first = synthesise("Buy some warm milk.", "en-us+f3")
    time.sleep(1.1)
    assert np.array_equal(first.samples, synthesise("Buy some warm milk.", "en-us+f3").samples)


def test_phones_follow_each_other_and_cover_the_sound(speech):
    starts = np.array([start for _, start, _ in speech.phones])
    ends = np.array([end for *_, end in speech.phones])
    assert starts[0] == 0 and np.array_equal(starts[1:], ends[:-1]) and (ends > starts).all()
    assert ends[-1] == pytest.approx(len(speech.samples) / speech.rate)
    assert {phone for phone, *_ in speech.phones} <= ARPABET


def test_words_have_their_phones(speech):
    assert [word for word, *_ in speech.words] == "a happy puppy of the pub jumping up to catch 12 apples".split()
    inside = [
        [phone for phone, start, end in speech.phones if first <= (start + end) / 2 < last]
        for _, first, last in speech.words
    ]
    assert inside[1:6] == ["hh ae p iy".split(), "p ah p iy".split(), ["ah", "v"], ["dh", "ah"], "p ah b".split()]


def test_a_voiceless_stop_begins_with_its_silent_closure(speech):
    """eSpeak NG reports stops at the burst; here they begin where the sound stops."""
    checked = 0
    for (before, *_), (phone, start, _) in zip(speech.phones, speech.phones[1:], strict=False):
        if phone == "p" and before != "sil":
            first = int(start * speech.rate)
            closure = np.abs(speech.samples[first + 20 : first + int(0.02 * speech.rate)])
            vowel = np.abs(speech.samples[first - int(0.03 * speech.rate) : first])
            assert closure.max() < 60 < vowel.max()
            checked += 1
    assert checked >= 3


@pytest.mark.parametrize(
    ("word", "phones"),
    [
        ("hello", "hh ah l ow"),
        ("puppy", "p ah p iy"),
        ("chair", "ch eh r"),
        ("around", "er aw n d"),
        ("zed", "z eh d"),
        ("measure", "m eh zh er"),
    ],
)
def test_letter_to_sound(word, phones):
    assert letter_to_sound(word) == phones.split()


def test_letters_to_sounds_gives_any_word_phones_of_the_set():
    words = ["xylograph", "o'neil", "naïve", "croissant", "qzx", "", "?"]
    found = letters_to_sounds(words)
    assert list(found) == words
    assert all(set(phones) <= ARPABET - {"sil"} for phones in found.values())
    assert found[""] == [] and found["?"] == [] and found["naïve"]


def test_faster_speech_is_shorter():
    slow, fast = (synthesise("seven blue boats", rate_wpm=rate) for rate in (120, 240))
    assert len(fast.samples) < 0.75 * len(slow.samples)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"text": " ... "}, "nothing to say"),
        ({"text": "yes", "voice": "no-such-voice"}, "no voice"),
        ({"text": "yes", "rate_wpm": 5}, "rate_wpm"),
        ({"text": "yes", "pitch": 500}, "pitch"),
    ],
)
def test_bad_settings_are_named(arguments, message):
    with pytest.raises(SettingError, match=message):
        synthesise(**arguments)
