"""The split: seeded, by utterance, stable, or the corpus's own."""

from collections import Counter

import pytest

from visualspeech.corpora.records import Utterance
from visualspeech.corpora.split import split_utterances
from visualspeech.errors import CorpusError, SettingError


def corpus(count, split=lambda number: ""):
    return [Utterance(f"u{number:04d}", "s", f"{number}.mp4", "text", split(number)) for number in range(count)]


@pytest.mark.parametrize(("count", "sizes"), [(400, (320, 40, 40)), (60, (48, 6, 6)), (12, (10, 1, 1)), (3, (1, 1, 1))])
def test_sizes(count, sizes):
    counts = Counter(split_utterances(corpus(count)).values())
    assert (counts["train"], counts["validation"], counts["test"]) == sizes


@pytest.mark.parametrize("count", range(3, 30))
def test_every_part_has_an_utterance_whatever_the_fractions(count):
    for fractions in ((0.98, 0.01, 0.01), (0.02, 0.49, 0.49), (0.01, 0.01, 0.98)):
        assert set(split_utterances(corpus(count), fractions).values()) == {"train", "validation", "test"}


def test_the_seed_decides_and_the_order_does_not():
    utterances = corpus(100)
    split = split_utterances(utterances, seed=1)
    assert split == split_utterances(utterances[::-1], seed=1)
    assert split != split_utterances(utterances, seed=2)
    assert list(split) == sorted(split)


def test_a_corpus_that_grows_changes_few_assignments():
    before = split_utterances(corpus(400))
    after = split_utterances(corpus(410))
    assert sum(before[name] != after[name] for name in before) <= 6


def test_a_corpus_may_bring_its_own_split():
    own = corpus(6, lambda number: ("train", "train", "validation", "test")[number % 4])
    assert split_utterances(own, (0.8, 0.1, 0.1)) == {one.id: one.split for one in own}


def test_half_a_split_is_refused():
    with pytest.raises(CorpusError, match=r"u0003 has no split.*\(2 of 5 are without"):
        split_utterances(corpus(5, lambda number: "" if number >= 3 else ("train", "validation", "test")[number]))
    with pytest.raises(CorpusError, match="no utterance in 'validation'"):
        split_utterances(corpus(4, lambda number: "train" if number else "test"))


def test_bad_fractions_and_too_few_utterances_are_sentences():
    for fractions in ((0.8, 0.1, 0.2), (1.0, 0.0, 0.0), (1.2, -0.1, -0.1), (0.5, 0.5)):
        with pytest.raises(SettingError, match="split"):
            split_utterances(corpus(10), fractions)
    with pytest.raises(CorpusError, match="at least three"):
        split_utterances(corpus(2))


def of_speakers(**counts):
    return [
        Utterance(f"{speaker}{number:03d}", speaker, f"{speaker}{number}.mp4", "text")
        for speaker, count in counts.items()
        for number in range(count)
    ]


def test_every_speaker_is_cut_by_himself():
    both = of_speakers(anna=40, ben=20)
    split = split_utterances(both, seed=3)
    sizes = Counter((one.speaker, split[one.id]) for one in both)
    assert [sizes["anna", name] for name in ("train", "validation", "test")] == [32, 4, 4]
    assert [sizes["ben", name] for name in ("train", "validation", "test")] == [16, 2, 2]
    assert list(split) == sorted(split)
    # A speaker's own split does not depend on who else is there.
    alone = split_utterances([one for one in both if one.speaker == "ben"], seed=3)
    assert alone == {name: part for name, part in split.items() if name in alone}


def test_a_speaker_with_too_few_utterances_is_named():
    with pytest.raises(CorpusError, match="the speaker 'ben' has 2 utterances. Give at least three"):
        split_utterances(of_speakers(anna=5, ben=2))
    with pytest.raises(CorpusError, match="the corpus has 0 utterances"):
        split_utterances([])


@pytest.mark.parametrize("given", ["", "test"])
def test_utterances_with_a_problem_leave_the_split_of_the_others_as_it_is(given):
    sound = corpus(40, lambda number: given and ("train", "validation", "test")[number % 3])
    bad = [Utterance(f"bad{number}", f"closed{number}", "x.mp4", "", problem="broken") for number in range(2)]
    found = split_utterances([*bad, *sound])
    assert {name: found.pop(name) for name in ("bad0", "bad1")} == {"bad0": "train", "bad1": "train"}
    assert found == split_utterances(sound)
