"""TextGrid files: forms, encodings and tiers as MFA and Praat write them, and damaged and hostile ones."""

import parselmouth
import pytest

from tests.unit.corpora.labels import PHONES, SECONDS, WORDS, intervals, spoken, write_grid
from visualspeech.corpora.textgrids import read_textgrid
from visualspeech.errors import RejectedUtterance


def read(path, speaker="", words="words", phones="phones"):
    return read_textgrid(path, words, phones, speaker)


@pytest.mark.parametrize("form", ["long_textgrid", "short_textgrid"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_forms_and_encodings(tmp_path, form, encoding):
    found = read(write_grid(tmp_path / "a.TextGrid", form=form, encoding=encoding))
    assert spoken(found.words) == intervals(WORDS) and spoken(found.phones) == intervals(PHONES)
    assert found.seconds == SECONDS and found.file == "a.TextGrid" and found.states == ()


def of_praat():
    """The same alignment, made by Praat itself."""
    grid = parselmouth.praat.call("Create TextGrid", 0, SECONDS, "words phones clicks", "clicks")
    for tier, entries in ((1, WORDS), (2, PHONES)):
        for time in sorted({time for start, end, _ in entries for time in (start, end)}):
            parselmouth.praat.call(grid, "Insert boundary", tier, time)
        for start, end, label in entries:
            number = parselmouth.praat.call(grid, "Get interval at time", tier, (start + end) / 2)
            parselmouth.praat.call(grid, "Set interval text", tier, int(number), label)
    parselmouth.praat.call(grid, "Insert point", 3, 0.4, 'a "click"')
    return grid


@pytest.mark.parametrize("form", ["text", "short text"])
def test_files_of_praat(tmp_path, form):
    path = str(tmp_path / "a.TextGrid")
    parselmouth.praat.call(of_praat(), f"Save as {form} file", path)
    found = read(path)
    assert spoken(found.words) == intervals(WORDS) and spoken(found.phones) == intervals(PHONES)


def test_a_binary_file_of_praat_is_a_sentence(tmp_path):
    path = str(tmp_path / "a.TextGrid")
    parselmouth.praat.call(of_praat(), "Save as binary file", path)
    with pytest.raises(RejectedUtterance, match="a.TextGrid is no TextGrid, or in another encoding"):
        read(path)


def test_ipa_in_utf_16_and_windows_line_ends(tmp_path):
    path = write_grid(tmp_path / "a.TextGrid", {"words": WORDS, "phones": ((0.2, 0.5, "pʰ"), (0.5, 0.9, "m̩"))})
    path.write_bytes(path.read_text(encoding="utf-8").replace("\n", "\r\n").encode("utf-16"))
    assert [one.label for one in spoken(read(path).phones)] == ["pʰ", "m̩"]


def test_tiers_of_speakers(tmp_path):
    other = ((0.9, 1.1, "oh"),), ((0.9, 1.1, "OW1"),)
    tiers = {"anna - words": WORDS, "anna - phones": PHONES, "Ben - words": other[0], "Ben - phones": other[1]}
    path = write_grid(tmp_path / "a.TextGrid", tiers)
    assert spoken(read(path, "anna").phones) == intervals(PHONES)
    assert read(path, "ben").phone_tier == "Ben - phones"
    with pytest.raises(RejectedUtterance, match="several speakers and none of 'mine'.*anna - words"):
        read(path, "mine")
    alone = write_grid(tmp_path / "b.TextGrid", {"anna - words": WORDS, "anna - phones": PHONES})
    assert spoken(read(alone, "mine").words) == intervals(WORDS)


def test_names_of_tiers_are_a_setting(tmp_path):
    path = write_grid(tmp_path / "a.TextGrid", {"ORT-MAU": WORDS, "MAU": PHONES})
    assert spoken(read(path, words="ort-mau", phones="MAU").words) == intervals(WORDS)
    with pytest.raises(RejectedUtterance, match="a.TextGrid has no tier 'words'.*'ORT-MAU', 'MAU'") as error:
        read(path)
    assert "alignment.word_tier" in error.value.remedy


def test_numbers_that_praatio_misreads(tmp_path):
    path = write_grid(tmp_path / "a.TextGrid")
    text = path.read_text()
    path.write_text(text.replace("xmin = 0.2 ", "xmin = 2.0e-01 ").replace("xmin = 0 ", "xmin = -1e-17 "))
    assert spoken(read(path).words) == intervals(WORDS)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("xmin = 0.2 ", "xmin = nan ", "'xmin = nan' is no time"),
        ("xmin = 0.2 ", "xmin = -0.2 ", "'xmin = -0.2' is no time from 0 s on"),
        ("xmax = 0.9 ", "xmax = inf ", "'xmax = inf' is no time"),
        ("xmax = 0.9 ", "xmax = 1.2.3 ", "'xmax = 1.2.3' is no time"),
        ("xmax = 0.9 ", "xmax = soon ", "a.TextGrid is damaged"),
        ("size = 6", "size = 7", "should have 7 intervals and has 6"),
        ("ooTextFile", "ooSoundFile", "is no TextGrid"),
        ('"IntervalTier"', '"TextTier"', "a.TextGrid is damaged"),
    ],
)
def test_damaged_files_are_a_sentence(tmp_path, old, new, reason):
    path = write_grid(tmp_path / "a.TextGrid")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(RejectedUtterance) as error:
        read(path)
    assert reason in error.value.reason and "a.TextGrid" in error.value.reason and error.value.remedy


@pytest.mark.parametrize("form", ["long_textgrid", "short_textgrid"])
def test_a_file_that_breaks_off_is_never_read_as_shorter(tmp_path, form):
    whole = write_grid(tmp_path / "whole.TextGrid", form=form)
    text, path, same = whole.read_text(), tmp_path / "a.TextGrid", read(whole)
    for size in range(0, len(text.rstrip()) - 1, 7):
        path.write_text(text[:size])
        try:
            found = read(path)
        except RejectedUtterance:
            continue
        assert (found.words, found.phones) == (same.words, same.phones), size


def test_hostile_files_are_a_sentence(tmp_path):
    path = tmp_path / "a.TextGrid"
    for content in (b"", b"\0" * 100, b"\xff\xfe\x00", b"[" * 100_000, b'"ooTextFile"\n' + b'"' * 9_000,
                    b'File type = "ooTextFile"\n' + b"x" * 50_000, bytes(range(256)) * 10):  # fmt: skip
        path.write_bytes(content)
        with pytest.raises(RejectedUtterance, match="a.TextGrid"):
            read(path)
    with path.open("wb") as file:
        file.truncate(500_000_000)
    with pytest.raises(RejectedUtterance, match="cannot be read: it is larger than"):
        read(path)
    with pytest.raises(RejectedUtterance, match="cannot be read: No such file"):
        read(tmp_path / "none.TextGrid")
