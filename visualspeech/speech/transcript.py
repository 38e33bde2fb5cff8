"""Normalisation of English transcripts: from written text to the spoken words in lower case.

Numbers, times, prices and ordinals are spelt out (by :mod:`inflect`), abbreviations and symbols are expanded, and
punctuation is dropped. Ambiguous spellings get their most common reading: four digits from 1100 to 2099 without a
separator are a year, "St." before a capital is "saint".
"""

import re
import unicodedata
from collections.abc import Callable
from functools import lru_cache

ABBREVIATIONS = {
    **{"mr.": "mister", "mrs.": "missus", "ms.": "miz", "dr.": "doctor", "prof.": "professor", "jr.": "junior"},
    **{"sr.": "senior", "vs.": "versus", "etc.": "et cetera", "e.g.": "for example", "i.e.": "that is", "no.": "no"},
    **{"mt.": "mount", "ave.": "avenue", "approx.": "approximately", "dept.": "department", "gen.": "general"},
    **{"capt.": "captain", "sgt.": "sergeant", "lt.": "lieutenant", "col.": "colonel", "rev.": "reverend"},
    **{"mr": "mister", "mrs": "missus", "dr": "doctor", "vs": "versus", "etc": "et cetera"},
}
UNITS = {
    **{"km": "kilometer", "cm": "centimeter", "mm": "millimeter", "kg": "kilogram", "mg": "milligram", "lb": "pound"},
    **{
        "lbs": "pound",
        "oz": "ounce",
        "ml": "milliliter",
        "hz": "hertz",
        "khz": "kilohertz",
        "ft": "foot",
        "hr": "hour",
    },
    **{"hrs": "hour", "min": "minute", "sec": "second", "ms": "millisecond", "kb": "kilobyte", "mb": "megabyte"},
    **{"gb": "gigabyte", "mph": "mile an hour"},
}
CURRENCIES = {"$": ("dollar", "cent"), "£": ("pound", "penny"), "€": ("euro", "cent"), "¥": ("yen", "sen")}
SYMBOLS = {"&": "and", "@": "at", "+": "plus", "=": "equals", "%": "percent", "°": "degrees", "§": "section"}
MAGNITUDES = "hundred|thousand|million|billion|trillion"

_CHARACTERS = str.maketrans(
    {
        **dict.fromkeys("‘’‚‛ʼ`´′＇", "'"),
        **dict.fromkeys("‐‑﹣－", "-"),
        **dict.fromkeys('–—―…«»„“”‟"', " "),
        "−": "-",
        "⁄": "/",
    }
)
_NUMBER = r"\d{1,3}(?:,\d{3})+(?:\.\d+)?|\d+(?:\.\d+)?"
# Two numbers with a dash between them; more than two are a code.
_RANGE = re.compile(r"(?<=\d)\s?[–—]\s?(?=\d)|(?<![\d-])(\d+)-(?=\d+(?![\d-]))")
_TELEPHONE = re.compile(r"(?<![\d-])(?:\d{3}[- ])?\d{3}-\d{4}(?![\d-])")


def normalise(text: str, known: Callable[[str], bool]) -> list[str]:
    """Words of a transcript as they are spoken.

    Parameters
    ----------
    text : as written; text in [square] or <angle> brackets is a comment and is dropped
    known : whether a lower-case word is in the dictionary; decides about hyphens, apostrophes and capitals

    Returns
    -------
    words in lower case; empty if no word is spoken
    """
    text = re.sub(r"\[[^\]]*\]|<[^>]*>", " ", unicodedata.normalize("NFC", text))
    text = _TELEPHONE.sub(lambda m: " ".join(re.sub(r"\D", "", m[0])), re.sub(r"([½¼¾⅓⅔⅛])", r" \1", text))
    text = _RANGE.sub(lambda m: f"{m[1] or ''} to ", text)
    text = unicodedata.normalize("NFKC", text).translate(_CHARACTERS)
    text = _with_numbers(_without_abbreviations(text))
    lower = bool(re.search(r"[a-z]", text))
    words: list[str] = []
    for token in re.findall(r"[^\W\d_]+(?:['-]+[^\W\d_]+)*'?|'[^\W\d_]+", _plain(text)):
        words += _words_of(token, known, lower)
    return words


def _plain(text: str) -> str:
    """Text without accents, as in dictionaries ("cafe")."""
    return "".join(c for c in unicodedata.normalize("NFKD", text) if not unicodedata.combining(c))


def _words_of(token: str, known: Callable[[str], bool], lower: bool) -> list[str]:
    word = token.lower()
    if known(word):
        return [word]
    if re.fullmatch(r"[A-Z]{2,5}", token) and lower:
        return list(word)
    word = word.strip("'-") if not known(word.strip("-")) else word.strip("-")
    if known(word) or not word:
        return [word] if word else []
    if re.fullmatch(r"[bcdfghjklmnpqrstvwxz]{2,5}", word):  # without a vowel it is spelt out ("mp" of "mp3")
        return list(word)
    if "-" in word:
        return [part for piece in re.split("-+", word) for part in _words_of(piece, known, False)]
    if word.count("'") > 1:
        return [part for piece in word.split("'") for part in _words_of(piece, known, False)]
    return [word]


def _without_abbreviations(text: str) -> str:
    text = re.sub(r"\b[Nn]os?\.\s?(?=\d)|#\s?(?=\d)", " number ", text)
    text = re.sub(r"\bSt\.\s?(?=[A-Z])", "saint ", text)
    text = re.sub(r"\bSt\.", "street", text)
    text = re.sub(r"\b(\d+)\s?([ap])\.?\s?m\b\.?", r"\1 \2 m ", text, flags=re.IGNORECASE)
    known = "|".join(sorted((re.escape(name) for name in ABBREVIATIONS), key=len, reverse=True))
    text = re.sub(rf"(?<![\w.])(?:{known})(?!\w)", lambda m: ABBREVIATIONS[m[0].lower()], text, flags=re.IGNORECASE)
    text = re.sub(r"\b(?:[^\W\d_]\.){2,}", lambda m: " ".join(m[0].replace(".", " ").split()) + " ", text)
    # A dot within an address; before a capital it ends a sentence, and the space is missing.
    return re.sub(r"(?<=[a-z])\.(?=[a-z])", " dot ", text)


def _with_numbers(text: str) -> str:
    """Every number as words; then the symbols."""
    units = "|".join(sorted(UNITS, key=len, reverse=True))
    magnitude = rf"(?:\s?({MAGNITUDES}))?"
    currencies = "".join(re.escape(sign) for sign in CURRENCIES)
    for pattern, spoken in (
        (rf"([{currencies}])\s?({_NUMBER}){magnitude}", lambda m: _price(m[1], m[2], m[3])),
        (rf"({_NUMBER}){magnitude}\s?([{currencies}])", lambda m: _price(m[3], m[1], m[2])),
        (r"\b(\d{1,2}):([0-5]\d)\b", lambda m: _time(int(m[1]), m[2])),
        (r"\b(\d{1,3}(?:,\d{3})+|\d+)(?:st|nd|rd|th)\b", lambda m: _ordinal(int(m[1].replace(",", "")))),
        (r"'?\b(\d{0,2}\d0)'?s\b", lambda m: _decade(m[1])),
        (r"\b(\d{1,2})/(\d{1,2})\b(?!/)", lambda m: _fraction(int(m[1]), int(m[2]))),
        (rf"({_NUMBER})\s?({units})\b\.?", lambda m: _measure(m[1], UNITS[m[2].lower()])),
        (r"(?<![\w.,])(1[1-9]\d\d|20\d\d)(?![\w,]|\.\d)", lambda m: _year(int(m[1]))),
        (r"(?<![\w.])-(?=\d)", lambda m: "minus"),
        (r"(?<![\w.])\.(\d+)", lambda m: f"point {' '.join(map(_spelt, m[1]))}"),
        (_NUMBER, lambda m: _cardinal(m[0])),
        (r"[" + re.escape("".join(SYMBOLS)) + "]", lambda m: SYMBOLS[m[0]]),
    ):
        text = re.sub(pattern, lambda m, spoken=spoken: f" {spoken(m)} ", text, flags=re.IGNORECASE)
    return text


@lru_cache(maxsize=1)
def _engine():
    import inflect

    return inflect.engine()


def _spelt(number: str | int) -> str:
    return _engine().number_to_words(str(number), andword="").replace(",", "").replace("-", " ")


def _cardinal(digits: str) -> str:
    plain = digits.replace(",", "")
    whole, _, decimals = plain.partition(".")
    if decimals:
        return f"{_spelt(whole)} point {' '.join(map(_spelt, decimals))}"
    if len(plain) > 1 and (plain[0] == "0" or (len(plain) > 6 and plain == digits)):  # a code, a telephone number
        return " ".join(map(_spelt, plain))
    return _spelt(plain)


def _ordinal(number: int) -> str:
    return _engine().number_to_words(_engine().ordinal(number), andword="").replace(",", "").replace("-", " ")


def _plural(noun: str, count: str) -> str:
    if count == "1" or noun in ("yen", "hertz", "kilohertz"):
        return noun
    first, _, rest = noun.partition(" ")
    return f"{_engine().plural_noun(first)} {rest}".strip()


def _price(sign: str, amount: str, magnitude: str | None) -> str:
    noun, small = CURRENCIES[sign]
    whole, _, decimals = amount.replace(",", "").partition(".")
    if magnitude:
        return f"{_cardinal(amount)} {magnitude.lower()} {_plural(noun, '2')}"
    if len(decimals) != 2:
        return f"{_cardinal(amount)} {_plural(noun, amount)}"
    cents = str(int(decimals))
    minor = "pence" if small == "penny" and cents != "1" else _plural(small, cents)
    parts = [f"{_spelt(whole)} {_plural(noun, whole)}"] if int(whole) or not int(decimals) else []
    parts += [f"{_spelt(cents)} {minor}"] if int(decimals) else []
    return " and ".join(parts)


def _time(hour: int, minutes: str) -> str:
    if minutes == "00":
        return f"{_spelt(hour)} o'clock"
    return f"{_spelt(hour)} {'oh ' if minutes[0] == '0' else ''}{_spelt(int(minutes))}"


def _decade(digits: str) -> str:
    number = int(digits)
    if number % 100 == 0 and len(digits) == 4:
        return f"{_spelt(number // 100)} hundreds" if number % 1000 else f"{_spelt(number // 1000)} thousands"
    if len(digits) == 3:
        return f"{_spelt(number)}s"
    century = f"{_spelt(number // 100)} " if len(digits) == 4 else ""
    return century + _engine().plural_noun(_spelt(number % 100))


def _year(number: int) -> str:
    century, rest = divmod(number, 100)
    if 2000 <= number < 2010:
        return _spelt(number)
    if rest == 0:
        return f"{_spelt(century)} hundred"
    return f"{_spelt(century)} {'oh ' if rest < 10 else ''}{_spelt(rest)}"


def _fraction(above: int, below: int) -> str:
    if not (0 < above < below <= 16):
        return f"{_spelt(above)} {_spelt(below)}"
    part = {2: "half", 4: "quarter"}.get(below) or _ordinal(below)
    return f"{_spelt(above)} {part if above == 1 else _engine().plural_noun(part)}"


def _measure(amount: str, unit: str) -> str:
    return f"{_cardinal(amount)} {_plural(unit, amount)}"
