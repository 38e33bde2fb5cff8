"""Pronunciation dictionaries of one's own: formats of MFA and CMU, their mistakes, and what a voice speaks."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.dictionary import lexicon_with, parse_dictionary, read_dictionary
from visualspeech.speech.forced_alignment import pronounced
from visualspeech.speech.mnemonics import mnemonics, with_own
from visualspeech.speech.phone_sets import PhoneSet
from visualspeech.speech.phones import PHONES
from visualspeech.speech.tts import synthesise

CMU = ";;; a comment\nTOMATO  T AH0 M EY1 T OW2\nTOMATO(2)  T AH0 M AA1 T OW2 # British\n'BOUT  B AW1 T\n\nA(1) AH0\n"
MFA = (
    "<eps>\tsil\n<unk>\tspn\n[bracketed]\tspn\nquux\t0.99\t0.12\t1.34\t0.9\tkʰ w ɐ k s\n"
    "don't\td ow n t\ndon't\td ow ʔ\n"
)


def test_cmu():
    found = parse_dictionary(CMU)
    assert found.entries["tomato"] == (("t", "ah0", "m", "ey1", "t", "ow2"), ("t", "ah0", "m", "aa1", "t", "ow2"))
    assert found.pronunciations()["tomato"][1] == ("t", "ah", "m", "aa", "t", "ow")
    assert set(found.entries) == {"tomato", "'bout", "a"}


def test_mfa_with_and_without_probabilities():
    found = parse_dictionary(MFA, PhoneSet("ipa"))
    assert found.pronunciations() == {
        "quux": (("k", "w", "ah", "k", "s"),), "don't": (("d", "ow", "n", "t"), ("d", "ow", "t"))}  # fmt: skip
    assert parse_dictionary("word 1.0 w er d\n").pronunciations() == {"word": (("w", "er", "d"),)}


def test_what_a_speaker_keeps_reads_back():
    found = parse_dictionary(CMU)
    assert parse_dictionary(found.text()) == found


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings_and_accents(tmp_path, encoding):
    path = tmp_path / "own.dict"
    path.write_bytes("CAFÉ K AE F EY\n".encode(encoding))
    assert read_dictionary(path).pronunciations() == {"cafe": (("k", "ae", "f", "ey"),)}


@pytest.mark.parametrize(
    ("text", "reason"),
    [("word\n", "line 1: 'word' has no phones"), ("a AH0\nb XX\n", "line 2: the phone 'XX' of 'b'"), ("", "no word"),
     ("<unk> spn\n", "no word"), ("a " + "AH0 " * 300, "line 1: a word has at most")],
)  # fmt: skip
def test_mistakes_name_the_line(tmp_path, text, reason):
    path = tmp_path / "own.dict"
    path.write_text(text)
    with pytest.raises(SettingError, match="the pronunciation dictionary .*own.dict, ") as error:
        read_dictionary(path)
    assert reason in str(error.value)


def test_a_hostile_file_is_a_sentence(tmp_path):
    path = tmp_path / "own.dict"
    with path.open("wb") as file:
        file.truncate(500_000_000)
    with pytest.raises(SettingError, match="cannot be read: it is larger than"):
        read_dictionary(path)
    with pytest.raises(SettingError, match="cannot be read: No such file"):
        read_dictionary(tmp_path / "none.dict")
    with pytest.raises(SettingError, match="it is a folder"):
        read_dictionary(tmp_path)


def test_it_comes_before_the_built_in_one(tmp_path):
    path = tmp_path / "own.dict"
    path.write_text("BLUE B L AH1 B\nquux K W AH1 K S\n")
    spoken = pronounced("Blue quux's boats", lexicon_with(path))
    assert spoken.pronunciations["blue"] == (("b", "l", "ah", "b"),)
    assert spoken.pronunciations["quux's"] == (("k", "w", "ah", "k", "s", "ih", "z"),)
    assert spoken.pronunciations["boats"] == (("b", "ow", "t", "s"),)
    assert lexicon_with(**{}).pronunciations("blue") == (("b", "l", "uw"),)


def test_every_phone_has_a_mnemonic_that_the_voice_speaks():
    for phone in PHONES[1:]:
        own = {"zzz": ("b", "iy1", phone, "d") if phone[0] not in "aeiou" else ("b", f"{phone}1", "d")}
        said = [
            one for one, *_ in synthesise("zzz", own=lambda word, own=own: own.get(word, ())).phones if one != "sil"
        ]
        assert phone in said, (phone, said)


def test_the_voice_speaks_the_words_of_the_dictionary():
    own = parse_dictionary("QUUX K W AH1 K S\nTOMATO T AH0 M AA1 T OW2\n")
    found = synthesise("Say tomato [[to the quux's boy.", own=own.spoken)
    assert [word for word, *_ in found.words] == ["say", "tomato", "to", "the", "quux's", "boy"]
    phones = [phone for phone, *_ in found.phones if phone != "sil"]
    joined = " ".join(phones)
    assert "t ah m aa t ow" in joined and "k w ah k s ih z" in joined
    assert "t ah m ey t ow" in " ".join(phone for phone, *_ in synthesise("Say tomato").phones)


def test_without_its_words_the_voice_is_the_same():
    own = parse_dictionary("QUUX K W AH1 K S\n")
    assert with_own("Hello there.", own.spoken) is None
    one, two = synthesise("Hello there."), synthesise("Hello there.", own=own.spoken)
    assert one.phones == two.phones and (one.samples == two.samples).all()


def test_stress_of_mnemonics():
    assert mnemonics(("t", "ah0", "m", "aa1", "t", "ow2")) == "t|@|m|'A:|t|,oU"
    assert mnemonics(("k", "ah", "m", "ih")) == "k|'V|m|I" and mnemonics(("s",)) == "s"
