"""Forced alignment of synthetic speech, whose true times are known, and its refusals."""

import numpy as np
import pytest
from scipy.signal import resample_poly

from visualspeech.errors import DataError, RejectedUtterance, SettingError
from visualspeech.media.reading import read_audio
from visualspeech.speech.alignment import read_alignments, to_table
from visualspeech.speech.forced_alignment import Aligner, AlignmentSettings, align
from visualspeech.speech.tts import synthesise
from visualspeech.storage.tables import write_table

SENTENCES = (
    "Please bring my blue boat back before noon.",
    "His father thinks the weather is rather wild.",
    "Five foxes found very few vegetables.",
    "Joyce chose cheese and juice for lunch.",
)
RATE = 16000


def at_16k(speech):
    samples = resample_poly(speech.samples.astype(float), RATE, speech.rate)
    return np.clip(np.round(samples), -32768, 32767).astype(np.int16)


@pytest.fixture(scope="module")
def spoken():
    return {text: synthesise(text) for text in SENTENCES}


@pytest.fixture(scope="module")
def sounds(spoken):
    return {text: at_16k(speech) for text, speech in spoken.items()}


@pytest.fixture(scope="module")
def alignments(sounds):
    aligner = Aligner()
    return {text: aligner.align(samples, text) for text, samples in sounds.items()}


def test_times_against_the_synthesiser_s_own(spoken, alignments):
    words, phones = [], []
    for text, alignment in alignments.items():
        found = [word for word in alignment.words if word.label != "sil"]
        assert [word.label for word in found] == [word for word, *_ in spoken[text].words]
        words += [(a.start - b[1], a.end - b[2]) for a, b in zip(found, spoken[text].words, strict=True)]
        found = [phone for phone in alignment.phones if phone.label != "sil"]
        true = [phone for phone in spoken[text].phones if phone[0] != "sil"]
        if [phone.label for phone in found] == [phone[0] for phone in true]:
            phones += [a.start - b[1] for a, b in zip(found, true, strict=True)]
    assert np.median(np.abs(words)) < 0.015
    assert len(phones) > 20
    assert np.median(np.abs(phones)) < 0.015
    assert abs(np.median(phones)) < 0.006  # without the middle of the frames it is 8 ms early


def test_tiers_are_whole_and_nested(sounds, alignments):
    for text, alignment in alignments.items():
        for tier in ("word", "phone", "state"):
            segments = alignment.tier(tier)
            assert segments[0].start == 0
            assert segments[-1].end == pytest.approx(len(sounds[text]) / RATE, abs=1e-5)
            assert all(one.end == two.start for one, two in zip(segments, segments[1:], strict=False))
            assert all(one.start < one.end for one in segments)
        for above, below in (("word", "phone"), ("phone", "state")):
            parents = alignment.tier(above)
            for one in alignment.tier(below):
                assert parents[one.parent].start <= one.start < one.end <= parents[one.parent].end
        assert [state.label for state in alignment.states] == ["1", "2", "3"] * len(alignment.phones)
        assert [state.parent for state in alignment.states] == list(np.repeat(range(len(alignment.phones)), 3))


def test_the_answer_does_not_depend_on_what_came_before(sounds, alignments):
    aligner = Aligner()
    assert {text: aligner.align(sounds[text], text) for text in SENTENCES[::-1]} == alignments


def test_leading_silence_only_moves_the_times(sounds, alignments):
    text = SENTENCES[1]
    quiet = np.round(np.random.default_rng(0).normal(0, 3, 8000)).astype(np.int16)
    later = align(np.concatenate([quiet, sounds[text]]), text)
    one, two = ([word for word in each.words if word.label != "sil"] for each in (alignments[text], later))
    assert np.median([abs(b.start - a.start - 0.5) for a, b in zip(one, two, strict=True)]) < 0.011


def test_words_that_no_dictionary_lists(sounds):
    text = "Please bring my bloo boat bakk before noon."
    alignment = align(sounds[SENTENCES[0]], text)
    assert [word for word, _ in alignment.guessed] == ["bloo", "bakk"]
    assert "bloo" in [word.label for word in alignment.words]


@pytest.mark.parametrize("wrong", [1, 2, 3])
def test_another_sentence_is_refused(sounds, wrong):
    with pytest.raises(RejectedUtterance, match="is not") as refusal:
        align(sounds[SENTENCES[0]], SENTENCES[wrong])
    assert "correct the transcript" in refusal.value.remedy


@pytest.mark.parametrize(
    "text",
    [
        "Please bring my winter boat back before mountain science foxes found river few mountain.",
        "Please bring my blue table back science yellow five foxes garden garden few vegetables.",
    ],
)
def test_five_words_of_fourteen_that_are_not_said_are_refused(sounds, text):
    sound = np.concatenate([sounds[SENTENCES[0]], sounds[SENTENCES[2]]])
    align(sound, f"{SENTENCES[0]} {SENTENCES[2]}")
    with pytest.raises(RejectedUtterance, match="4 of 14 words do not match the sound"):
        align(sound, text)
    align(sound, text, settings=AlignmentSettings(rejected_word_share=0.5))


def test_a_sentence_of_which_half_is_missing_is_refused(sounds):
    text = SENTENCES[0]
    with pytest.raises(RejectedUtterance):
        align(sounds[text][: len(sounds[text]) // 2], text)


@pytest.mark.parametrize(
    ("noise", "tone", "reason"),
    [(0, 0, "no speech"), (4, 0, "no speech"), (2000, 0, "no speech|is not"), (1, 3000, "no speech|is not")],
)
def test_sound_without_speech_is_refused(noise, tone, reason):
    times = np.arange(3 * RATE) / RATE
    sound = np.random.default_rng(0).normal(0, noise, len(times)) + tone * np.sin(2 * np.pi * 440 * times)
    with pytest.raises(RejectedUtterance, match=reason):
        align(np.round(sound).astype(np.int16), SENTENCES[0])


@pytest.mark.parametrize(
    ("samples", "transcript", "reason"),
    [
        (np.ones(RATE, np.int16), " ... ", "empty"),
        (np.ones(800, np.int16), "far too many words for this", "do not fit|no speech"),
        (np.zeros(0, np.int16), "hello", "no speech"),
        (np.ones(RATE, np.int16), "☃ 你", "pronunciation|empty"),
        (np.ones(200 * RATE, np.int16), "hello", "too long"),
    ],
)
def test_what_cannot_be_aligned_is_refused(samples, transcript, reason):
    with pytest.raises(RejectedUtterance, match=reason) as refusal:
        align(samples, transcript)
    assert refusal.value.remedy


def test_mistaken_arguments():
    with pytest.raises(DataError, match="int32 of shape"):
        align(np.zeros(RATE, np.int32), "hello")
    with pytest.raises(DataError, match=r"float64 of shape \(16000, 2\)"):
        align(np.zeros((RATE, 2)), "hello")
    with pytest.raises(DataError, match=r"must lie in \[-1, 1\]"):
        align(np.full(RATE, 3000.0), "hello")
    with pytest.raises(DataError, match=r"must lie in \[-1, 1\]"):
        align(np.full(RATE, np.nan), "hello")
    with pytest.raises(RejectedUtterance, match="does not exist"):
        align("nothing.wav", "hello")
    with pytest.raises(SettingError, match="alignment.pause"):
        AlignmentSettings(pause_probability=2.0)
    with pytest.raises(SettingError, match="alignment.max_short_phone_share"):
        AlignmentSettings(max_short_phone_share=0.0)


def test_a_recording_its_samples_and_their_16_bit_steps_align_the_same(sounds, alignments, tmp_path):
    import soundfile

    text = SENTENCES[3]
    soundfile.write(tmp_path / "said.wav", sounds[text], RATE)
    recorded = read_audio(tmp_path / "said.wav", RATE)
    assert recorded.dtype == np.float32
    found = align(recorded, text)
    assert align(str(tmp_path / "said.wav"), text) == align(tmp_path / "said.wav", text) == found
    assert Aligner().align(recorded.astype(np.float64), text) == found
    # One 16-bit step of rounding moves no border.
    moved = [a.start - b.start for a, b in zip(found.phones, alignments[text].phones, strict=True)]
    assert np.abs(moved).max() < 0.011


def test_alignments_read_back_the_same(alignments, tmp_path):
    named = {f"u{i}": alignment for i, alignment in enumerate(alignments.values())}
    write_table(tmp_path / "alignment.tsv", to_table(named))
    assert read_alignments(tmp_path / "alignment.tsv") == named
