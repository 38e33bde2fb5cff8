"""Alignment of utterances by each source; the files that this project exports give the alignment that it exported."""

import numpy as np
import pytest

from tests.unit.corpora.labels import WORDS, intervals, write_grid
from visualspeech.corpora.aligning import AlignmentSources, aligner, transcript_difference
from visualspeech.corpora.label_files import find_label_files
from visualspeech.corpora.records import Utterance
from visualspeech.speech.alignment_settings import AlignmentSettings
from visualspeech.speech.export import write_textgrid
from visualspeech.speech.given import Given
from visualspeech.speech.phone_sets import PhoneSet
from visualspeech.speech.tts import synthesise

TEXT = "Please bring my blue boat back before noon."


def sources(tmp_path, settings, **more):
    one = Utterance("one", "anna", f"{tmp_path}/one.mp4", more.pop("transcript", ""))
    found = find_label_files({"name": "mine", "root": str(tmp_path)}, settings, [one])
    return one, AlignmentSources.of(AlignmentSources(labels=found, **more).plain())


@pytest.fixture(scope="module")
def samples():
    from scipy.signal import resample_poly

    speech = synthesise(TEXT)
    return np.clip(np.round(resample_poly(speech.samples.astype(float), 16000, speech.rate)), -32768, 32767).astype(
        "i2"
    )


def test_an_exported_alignment_comes_back(tmp_path, samples):
    forced = aligner(AlignmentSettings(), AlignmentSources())
    exported = forced(Utterance("one", "anna", "", TEXT), samples).alignment
    write_textgrid(tmp_path / "one.TextGrid", exported)
    settings = AlignmentSettings(source="textgrid", states="tier")
    one, own = sources(tmp_path, settings, transcript=TEXT)
    found = aligner(settings, own)(one, samples)
    assert found.alignment == exported and found.warnings == ()
    thirds = aligner(AlignmentSettings(source="textgrid"), own)(one, samples).alignment
    assert thirds.phones == exported.phones and thirds.words == exported.words and thirds.states != exported.states


def test_the_words_of_the_file_count_and_a_difference_is_reported(tmp_path):
    write_grid(tmp_path / "one.TextGrid")
    settings = AlignmentSettings(source="textgrid")
    for transcript, said in (
        ("", 0), ("Be me!", 0), ("Be mine", "'me' where the transcript has 'mine'"),
        ("be me too", "'nothing' where the transcript has 'too'"),
    ):  # fmt: skip
        one, own = sources(tmp_path, settings, transcript=transcript)
        found = aligner(settings, own)(one, np.zeros(19200, np.int16))
        assert [word.label for word in found.alignment.words] == ["sil", "be", "me", "sil"]
        assert len(found.warnings) == bool(said)
        if said:
            ((text, remedy),) = found.warnings
            assert said in text and "one.TextGrid" in text and "words of the file count" in remedy


def test_words_that_differ_in_their_writing_are_the_same():
    def difference(words, transcript):
        given = Given("a", tuple(intervals((k, k + 1, word) for k, word in enumerate(words))), ())
        return transcript_difference(given, transcript)

    assert difference(["don't", "", "well-known"], "Don't! Well-known.") == ""
    assert difference(["twenty", "one"], "21") == "" and difference(["cafe"], "Café") == ""
    assert difference(["the", "<unk>", "ran"], "The okapi ran") == "" and difference(["a", "b"], "a c") != ""
    assert difference([word for *_, word in WORDS], "[laughs] be me") == ""


def test_recognised_states_that_do_not_fit_are_reported(tmp_path):
    write_grid(tmp_path / "one.TextGrid")
    settings = AlignmentSettings(source="textgrid", states="recognised")
    one, own = sources(tmp_path, settings)
    found = aligner(settings, own)(one, np.zeros(19200, np.int16))
    assert "does not find 4 of 4 phones" in found.warnings[0][0]


def test_without_text_speech_is_told_from_pauses(samples):
    sound = np.concatenate([np.zeros(8000, np.int16), samples, np.zeros(8000, np.int16)])
    found = aligner(AlignmentSettings(), AlignmentSources(), text=False)(Utterance("a", "b", "", ""), sound)
    assert {one.label for one in found.alignment.phones} == {"sil", "spn"}


def test_a_dictionary_is_used_in_forced_alignment(tmp_path, samples):
    (tmp_path / "own.dict").write_text("quux b l uː\n")
    own = AlignmentSources(PhoneSet("ipa"), str(tmp_path / "own.dict"))
    found = aligner(AlignmentSettings(phones="ipa"), AlignmentSources.of(own.plain()))(
        Utterance("a", "b", "", TEXT.replace("blue", "quux")), samples
    )
    assert "quux" in [word.label for word in found.alignment.words] and found.alignment.guessed == ()
