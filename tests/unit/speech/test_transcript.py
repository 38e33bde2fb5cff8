"""Transcripts as people write them, and the words that are said."""

import pytest

from visualspeech.speech.lexicon import normalise_transcript


@pytest.mark.parametrize(
    ("written", "spoken"),
    [
        ("I have 42 dogs.", "i have forty two dogs"),
        ("the 3rd and the 21st", "the third and the twenty first"),
        ("It cost $5.", "it cost five dollars"),
        ("$1.01, £2.50, 3€, ¥7", "one dollar and one cent two pounds and fifty pence three euros seven yen"),
        ("$0.99 of $3 million", "ninety nine cents of three million dollars"),
        ("in the 1990s, the '60s and 2000s", "in the nineteen nineties the sixties and two thousands"),
        ("1984 1905 1900 2005 2024", "nineteen eighty four nineteen oh five nineteen hundred two thousand five twenty "
         "twenty four"),
        ("1,234,567 and 20,000", "one million two hundred thirty four thousand five hundred sixty seven and twenty "
         "thousand"),
        ("3.14 0.5 .5 007", "three point one four zero point five point five zero zero seven"),
        ("at 5:30 p.m., 10:05 or 7:00", "at five thirty p m ten oh five or seven o'clock"),
        ("10-20 people, pages 3–5", "ten to twenty people pages three to five"),
        ("call 555-1234", "call five five five one two three four"),
        ("½ of 2/3", "one half of two thirds"),
        ("5 km, 1 kg, 3.5mm", "five kilometers one kilogram three point five millimeters"),
        ("100% & more + −4°", "one hundred percent and more plus minus four degrees"),
        ("No. 5, #7", "number five number seven"),
    ],
)  # fmt: skip
def test_numbers_and_symbols(written, spoken):
    assert normalise_transcript(written) == spoken.split()


@pytest.mark.parametrize(
    ("written", "spoken"),
    [
        ("“Don’t,” said Mr. O’Brien", "don't said mister o'brien"),
        ("rock ’n’ roll: the dogs' bones; the ‘cats’", "rock 'n roll the dogs' bones the cats"),
        ("stop—ever… a - b --dash--", "stop ever a b dash"),
        ("a pea-green, able-bodied man", "a pea green able-bodied man"),
        ("naïve café", "naive cafe"),
        ("The U.S.A. and the XQZ", "the u s a and the x q z"),
        ("Dr. Smith of Elm St. near St. Louis, etc.", "doctor smith of elm street near saint louis et cetera"),
        ("see example.com.Then go", "see example dot com then go"),
        ("[laughter] yes <noise>", "yes"),
        ("mp3 4K", "m p three four k"),
        ("HELLO WORLD", "hello world"),
        ("", ""),
        ("...!? — 『』", ""),
    ],
)
def test_punctuation_and_abbreviations(written, spoken):
    assert normalise_transcript(written) == spoken.split()


def test_normalising_twice_changes_nothing():
    text = "Mr. O'Brien paid $42.50 for 3 able-bodied dogs' bones in 1984."
    words = normalise_transcript(text)
    assert normalise_transcript(" ".join(words)) == words
