"""CTM files of Kaldi and MFA: the utterances that are wanted, and lines that are none."""

import pytest

from tests.unit.corpora.labels import PHONES, WORDS, intervals
from visualspeech.corpora.ctm import CtmFiles, ctm_lines
from visualspeech.errors import CorpusError, RejectedUtterance


def lines(tier, name="a", score=""):
    return "".join(f"{name} 1 {start} {end - start:.3f} {label}{score}\n" for start, end, label in tier)


def files(folder, words=None, phones=None):
    paths = folder / "words.ctm", folder / "phones.ctm"
    for path, text in zip(paths, (words or lines(WORDS), phones or lines(PHONES)), strict=True):
        path.write_text(text)
    return CtmFiles(paths[:1], paths[1:], {"a", "b"})


def rounded(tier):
    return [(one.label, one.start, round(one.end, 6)) for one in tier]


def test_words_and_phones(tmp_path):
    found = files(tmp_path, ";; a comment\n\n" + lines(WORDS, score=" 0.98"), lines(PHONES, "c") + lines(PHONES[::-1]))
    given = found.given("a")
    assert rounded(given.words) == rounded(intervals(WORDS)) and rounded(given.phones) == rounded(intervals(PHONES))
    assert found.has("a") and not found.has("b") and not found.has("c")  # c is not wanted


def test_an_utterance_that_is_missing_is_rejected(tmp_path):
    with pytest.raises(RejectedUtterance, match="the CTM files of words have no utterance 'b'"):
        files(tmp_path).given("b")


@pytest.mark.parametrize("fields", ["nan 0.1", "0.1 inf", "x 0.1", "0.1 y"])
def test_times_that_are_no_numbers_are_rejected(tmp_path, fields):
    with pytest.raises(RejectedUtterance, match="words.ctm, line 1: start and duration of 'be' are no numbers"):
        files(tmp_path, f"a 1 {fields} be\n").given("a")


@pytest.mark.parametrize(
    ("content", "reason"),
    [(b"a 1 0.1 0.2\n", "line 1 has 4 fields"), (b"a 1 0.1 0.2 b c d e\n", "has 8 fields"),
     (b"x" * 20_000, "has more than 10,000 bytes"), (b"a 1 0 1 \xe9\n", "is no UTF-8 text")],
)  # fmt: skip
def test_what_is_no_ctm_file_is_a_sentence(tmp_path, content, reason):
    path = tmp_path / "x.ctm"
    path.write_bytes(content)
    with pytest.raises(CorpusError, match="the CTM file .*x.ctm") as error:
        list(ctm_lines(path))
    assert reason in str(error.value)


def test_a_missing_file_is_a_sentence(tmp_path):
    with pytest.raises(CorpusError, match="none.ctm cannot be read: No such file"):
        list(ctm_lines(tmp_path / "none.ctm"))
