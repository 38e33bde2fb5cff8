import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.sentences import LONGEST, listed_sentences, pronounceable, split_sentences


def test_sentences_end_where_a_reader_stops():
    text = 'Hello, Dr. Smith! It costs 3.5 dollars, says J. Doe. "Really?" Yes...\n\nA new paragraph'
    assert split_sentences(text) == [
        "Hello, Dr. Smith!", "It costs 3.5 dollars, says J. Doe.", '"Really?"', "Yes...", "A new paragraph",
    ]  # fmt: skip


def test_no_word_is_lost_and_no_piece_is_too_long():
    text = " ".join(f"word{i}" + ("," if i % 17 == 0 else "") for i in range(600))
    pieces = split_sentences(text)
    assert " ".join(pieces) == text
    assert max(map(len, pieces)) <= LONGEST
    assert split_sentences("a" * 700, 300) == ["a" * 300, "a" * 300, "a" * 100]


def test_what_has_no_word_is_left_out():
    assert split_sentences("Well. ?! ... -- 7!") == ["Well.", "-- 7!"]
    assert pronounceable("été") and pronounceable("5") and not pronounceable("。！—")


@pytest.mark.parametrize("text", ["", "  \n", "?! ...", "—", "\U0001f600"])
def test_a_text_without_a_word_is_refused(text):
    with pytest.raises(SettingError, match="no word to pronounce"):
        split_sentences(text)


def test_texts_are_numbered_and_read_from_a_file(tmp_path):
    path = tmp_path / "texts.txt"
    path.write_text("Second one.\n\n  Third. And more.  \n")
    assert listed_sentences(["First."]) == {"001": "First."}
    assert listed_sentences(["First."], str(path)) == {"001": "Second one.", "002": "Third. And more."}
    assert listed_sentences([]) == {}
    with pytest.raises(SettingError, match="cannot read the sentences of .*nowhere.txt: No such file"):
        listed_sentences([], str(tmp_path / "nowhere.txt"))
    path.write_text("\n \n")
    with pytest.raises(SettingError, match="holds no sentence"):
        listed_sentences([], str(path))
    path.write_bytes(b"\xff\xfe\xff")
    with pytest.raises(SettingError, match="not UTF-8"):
        listed_sentences([], str(path))
    with pytest.raises(SettingError, match="no word to pronounce in '!', text 2 of speak.sentences"):
        listed_sentences(["Fine.", "!"])
    path.write_text("Fine.\n\nFine too.\n- -\n")
    with pytest.raises(SettingError, match=r"no word to pronounce in '- -', text 3 of .*texts\.txt"):
        listed_sentences([], str(path))


def test_a_sentence_that_cannot_be_spoken_is_not_lost_unsaid(caplog):
    assert split_sentences("Hello.\n\nПривет всем.\n\n* * *\n\nGood bye.") == ["Hello.", "Good bye."]
    assert [record.getMessage() for record in caplog.records] == [
        "left out because it has no word in Latin letters: Привет всем."
    ]
