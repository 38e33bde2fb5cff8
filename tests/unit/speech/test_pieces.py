"""A recording aligned in pieces has the times that it has, and what does not fit is told with its place."""

import re

import numpy as np
import pytest
from scipy.signal import resample_poly

from visualspeech.errors import RejectedUtterance
from visualspeech.speech import pieces
from visualspeech.speech.forced_alignment import pronounced
from visualspeech.speech.lexicon import Lexicon
from visualspeech.speech.pieces import align_pieces, recognised_pieces
from visualspeech.speech.recognition import RATE
from visualspeech.speech.spoken import speak_text

TEXT = (
    "Please bring my blue boat back before noon. His father thinks the weather is rather wild. "
    "Five foxes found very few vegetables. Joyce chose cheese and juice for lunch."
)


@pytest.fixture(scope="module")
def spoken():
    """(samples at 16 kHz, true (word, start)) of the four sentences."""
    samples, words, at = [], [], 0.0
    for one in speak_text(TEXT):
        samples.append(resample_poly(one.samples.astype(float), RATE, one.rate))
        words += [(word.label, at + word.start) for word in one.alignment.words if word.label not in ("", "sil")]
        at += len(samples[-1]) / RATE
    return np.rint(np.concatenate(samples) * 32767).clip(-32768, 32767).astype(np.int16), words


@pytest.fixture
def short(monkeypatch):
    monkeypatch.setattr(pieces, "WINDOW", 6.0)
    monkeypatch.setattr(pieces, "_FIRST", 1.5)
    monkeypatch.setattr(pieces, "_LAST", 5.0)
    monkeypatch.setattr(pieces, "_ENDED", 1.5)


def aligned(samples, text, rate=25.0):
    parts = list(align_pieces(np.array_split(samples, 50), pronounced(text, Lexicon()), rate=rate))
    starts = [0, *(end for end, _ in parts[:-1])]
    words = [
        (word.label, start / RATE + word.start)
        for start, (_, alignment) in zip(starts, parts, strict=True)
        for word in alignment.words
        if word.label != "sil"
    ]
    return parts, words


def test_pieces_follow_each_other_and_have_the_true_times(short, spoken):
    samples, true = spoken
    parts, words = aligned(samples, TEXT, rate=29.97)
    ends = [end for end, _ in parts]
    assert len(parts) > 2 and ends == sorted(ends) and ends[-1] == len(samples)
    for start, (end, alignment) in zip([0, *ends], parts, strict=False):
        assert alignment.duration == pytest.approx((end - start) / RATE, abs=1e-4)
        assert abs(end / RATE * 29.97 % 1 - 0.5) > 0.49 or end == len(samples)
    assert [label for label, _ in words] == [label for label, _ in true]
    late = np.abs([a - b for (_, a), (_, b) in zip(words, true, strict=True)])
    assert np.median(late) < 0.03 and late.max() < 0.15
    # What is short is one piece, as ever.
    assert len(aligned(samples[: round(3.2 * RATE)], "Please bring my blue boat back before noon.")[0]) == 1


def test_silence_of_any_length_is_silence(short, spoken):
    samples, true = spoken
    samples, true = samples[: round(6.5 * RATE)], [word for word in true if word[1] < 6.5]
    middle = next(start for label, start in true if label == "his")
    cut = round((middle - 0.25) * RATE)
    still = np.zeros(8 * RATE, np.int16)
    samples = np.concatenate([still, samples[:cut], still, samples[cut:], still])
    parts, words = aligned(samples, TEXT[: TEXT.index("Five")])
    assert [label for label, _ in words] == [label for label, _ in true]
    moved = [start + 8 + 8 * (start > middle - 0.1) for _, start in true]
    assert np.abs([a - b for (_, a), b in zip(words, moved, strict=True)]).max() < 0.15
    assert sum(len(alignment.phones) == 1 for _, alignment in parts) >= 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TEXT.replace("His father thinks the weather is rather wild. ", ""), r"from 0:0\d.* to 0:\d"),
        (TEXT + " " + TEXT, r"from 0:.* are not said|from 0:.* not what is said"),
        (
            "Place red in A nine now. " * 6,
            "from 0:00.0 to .*(the transcript is not what is said|speech that is not in)",
        ),
    ],
)
def test_what_does_not_fit_is_told_with_its_place(short, spoken, text, said):
    with pytest.raises(RejectedUtterance) as told:
        aligned(spoken[0], text)
    assert re.search(said, told.value.reason), told.value.reason


def test_without_words_the_phones_that_are_heard_cover_the_sound(short, spoken):
    samples, true = spoken
    parts = list(recognised_pieces(np.array_split(samples, 50), 29.97))
    ends = [end for end, _ in parts]
    assert len(parts) > 2 and ends[-1] == len(samples)
    speaks = np.zeros(len(samples), bool)
    for start, (end, phones) in zip([0, *ends], parts, strict=False):
        assert phones[0][1] == 0 and phones[-1][2] == pytest.approx((end - start) / RATE)
        assert all(a[2] == b[1] and a[2] > a[1] for a, b in zip(phones, phones[1:], strict=False))
        for label, since, until in phones:
            speaks[start + round(since * RATE) : start + round(until * RATE)] = label != "sil"
    assert not speaks[: round(0.3 * RATE)].any() and not speaks[-round(0.3 * RATE) :].any()
    first, last = round((true[0][1] + 0.1) * RATE), round((true[-1][1] + 0.3) * RATE)
    assert speaks[first:last].mean() > 0.7  # three pauses between sentences, and closures
    # Every piece ends in a pause.
    assert all(phones[-1][0] == "sil" for _, phones in parts)
    with pytest.raises(RejectedUtterance, match="no speech"):
        list(recognised_pieces([np.zeros(20 * RATE, np.int16)]))
