"""TextGrid and label files, read back by other means."""

import pytest

from visualspeech.errors import SettingError
from visualspeech.speech.alignment import Alignment, Segment
from visualspeech.speech.export import read_htk_labels, write_htk_labels, write_hts_labels, write_textgrid

PHONES = (("sil", 0.0, 0.3, 0), ("b", 0.3, 0.36, 1), ("iy", 0.36, 0.51, 1), ("m", 0.51, 0.6, 2), ("sil", 0.6, 0.75, 3))
WORDS = (("sil", 0.0, 0.3), ("be", 0.3, 0.51), ("'m", 0.51, 0.6), ("sil", 0.6, 0.75))
ALIGNMENT = Alignment(
    tuple(Segment(*word) for word in WORDS),
    tuple(Segment(*phone) for phone in PHONES),
    tuple(
        Segment(str(k + 1), round(a + k * (b - a) / 3, 5), round(a + (k + 1) * (b - a) / 3, 5), i)
        for i, (_, a, b, _) in enumerate(PHONES)
        for k in range(3)
    ),
)


def test_textgrid_reads_back(tmp_path):
    from praatio import textgrid

    path = tmp_path / "utterance.TextGrid"
    write_textgrid(path, ALIGNMENT)
    grid = textgrid.openTextgrid(str(path), includeEmptyIntervals=True)
    assert grid.tierNames == ("words", "phones", "states")
    for name, segments in (("words", ALIGNMENT.words), ("phones", ALIGNMENT.phones), ("states", ALIGNMENT.states)):
        read = [(one.start, one.end, one.label) for one in grid.getTier(name).entries]
        assert read == [(one.start, one.end, one.label) for one in segments]
    assert path.read_text().startswith('File type = "ooTextFile"')


@pytest.mark.parametrize("tier", ["word", "phone", "state"])
def test_htk_labels_read_back(tmp_path, tier):
    path = tmp_path / "utterance.lab"
    write_htk_labels(path, ALIGNMENT, tier)
    read = read_htk_labels(path)
    assert [(a.label, a.start, a.end) for a in read] == [(a.label, a.start, a.end) for a in ALIGNMENT.tier(tier)]
    assert all(field.isdigit() for line in path.read_text().splitlines() for field in line.split()[:2])


def test_hts_labels_name_the_neighbours(tmp_path):
    path = tmp_path / "utterance.lab"
    write_hts_labels(path, ALIGNMENT)
    lines = path.read_text().splitlines()
    assert len(lines) == len(ALIGNMENT.states)
    assert lines[0] == "0 1000000 sil-sil+b[2] sil-sil+b sil"
    assert lines[3] == "3000000 3200000 sil-b+iy[2] sil-b+iy be"
    assert lines[4] == "3200000 3400000 sil-b+iy[3]"
    assert lines[6] == "3600000 4100000 b-iy+m[2] b-iy+m"
    assert lines[9] == "5100000 5400000 iy-m+sil[2] iy-m+sil 'm"


def test_unknown_tier(tmp_path):
    with pytest.raises(SettingError, match="no tier 'phones'"):
        write_htk_labels(tmp_path / "x.lab", ALIGNMENT, "phones")
