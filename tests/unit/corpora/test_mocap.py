"""Folders of motion capture: CSV files with sound beside them, or a table."""

import numpy as np
import pytest

from tests.motion_capture import LIVE_LINK, marker_columns, moving, timecodes, write_csv, write_live_link, write_wav
from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.motion_files import read_csv
from visualspeech.errors import CorpusError, RejectedUtterance, SettingError
from visualspeech.face.markers import read_marker_set
from visualspeech.planning.corpora import plan_corpus

NAMES = ("brow", "cheek", "chin")
SHARES = {"train": 0.6, "validation": 0.2, "test": 0.2}
REGIONS = {"upper": ["brow"], "middle": ["cheek"], "lower": ["chin"]}


def corpus(root, **settings):
    return {"name": "mine", "adapter": "mocap", "root": str(root), "regions": REGIONS, **settings}


def listed(root, **settings):
    return {one.id: one for one in list_utterances(corpus(root, **settings))}


def channels(rows=6, names=NAMES):
    return {name: np.arange(rows) + 10.0 * number for number, name in enumerate(names)}


def test_a_csv_with_its_sound_is_an_utterance(tmp_path):
    for name in ("ann/a.csv", "ann/b.csv", "c.csv"):
        write_csv(tmp_path / name, [0, 1], channels(2))
    for name in ("ann/a.wav", "ann/b.MOV", "ann/b.txt", "ann/a.mp4"):
        (tmp_path / name).write_text("Hello there.\n")
    found = listed(tmp_path)
    assert list(found) == ["ann-a", "ann-b", "c"]
    one = found["ann-a"]
    assert (one.motion, one.audio) == (str(tmp_path / "ann/a.csv"), str(tmp_path / "ann/a.wav"))
    assert (one.media, one.speaker, one.transcript, one.problem) == ("", "ann", "", "")
    assert (found["ann-b"].audio, found["ann-b"].transcript) == (str(tmp_path / "ann/b.MOV"), "Hello there.")
    assert listed(tmp_path, transcripts=False)["ann-b"].transcript == ""
    assert found["c"].problem == "no sound: no sound or video file named c lies beside it"
    assert "column `audio`" in found["c"].remedy and found["c"].speaker == "mine"
    assert list(listed(tmp_path, speaker="ann")) == ["ann-a", "ann-b"]


def test_a_table_names_sound_speaker_emotion_and_split(tmp_path):
    (tmp_path / "list.csv").write_text(
        "file,audio,speaker,emotion,split,start,end\n"
        "m/a.csv,s/one.flac,ann,happy,train,0.5,2\n"
        "m/a.csv,s/one.flac,ann,sad,test,2,3\n"
        "m/b.csv,,ben,,validation,,\n"
    )
    (tmp_path / "m").mkdir()
    (tmp_path / "m" / "b.wav").write_bytes(b"")
    found = listed(tmp_path, table="list.csv")
    assert list(found) == ["m-a-0001", "m-a-0002", "m-b"]
    one = found["m-a-0001"]
    assert (one.audio, one.motion) == (str(tmp_path / "s/one.flac"), str(tmp_path / "m/a.csv"))
    assert (one.speaker, one.emotion, one.split, one.start, one.end) == ("ann", "happy", "train", 0.5, 2.0)
    assert found["m-b"].audio == str(tmp_path / "m/b.wav") and found["m-b"].problem == ""


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("audio\nx.wav\n", "no column `file` .*must name the column `file`, separated"),
        ("file,audoi\na.csv,a.wav\n", "`audoi`; if `audio` is meant"),
        ("file,audio\na.csv,https://host/a.wav\n", "line 2: `file` is the address"),
        ('file,audio\na.csv,"a\nb.wav"\n', "line 2: .*`audio` goes on in the next line"),
        ("file\n", "has no rows"),
    ],
)
def test_mistakes_of_a_table(tmp_path, content, said):
    (tmp_path / "list.csv").write_text(content)
    with pytest.raises(CorpusError, match=said):
        listed(tmp_path, table="list.csv")


def test_a_folder_without_motion_capture(tmp_path):
    with pytest.raises(CorpusError, match="no motion capture in .*Put CSV files there with a sound file"):
        listed(tmp_path)


def test_regions_are_a_name_a_file_or_names(tmp_path):
    for number in range(3):
        write_csv(tmp_path / f"u{number}.csv", [0, 1], channels(2))
        (tmp_path / f"u{number}.wav").write_bytes(b"")
    (tmp_path / "face.yaml").write_text("lower: [chin]\nupper: [brow]\n")

    def planned(**changes):
        return plan_corpus(corpus(tmp_path, **changes), 2, SHARES, 1, "results")

    found = planned(rate=60)
    assert found.gives == {"audio", "motion", "faces", "one_speaker", "arpabet"}
    assert found.markers.by_region() == REGIONS
    assert found.motion == {"names": list(NAMES), "format": "csv", "rate": 60, "timecode_rate": 0}
    assert planned(regions="face.yaml").markers.by_region() == {"upper": ["brow"], "lower": ["chin"]}
    assert planned(regions=str(tmp_path / "face.yaml")).markers.names == ("brow", "chin")
    assert planned(regions="").markers == read_marker_set("live_link")
    assert planned(regions="iemocap_46").markers.size == 46
    for regions, said in (
        ({"chins": ["chin"]}, "`corpora.mine.regions` has the unknown region 'chins'; known are upper, middle, lower"),
        ("faces.yaml", "no marker set or file 'faces.yaml'. Give one of iemocap_46, .*live_link"),
        ("live_lnk", "no marker set or file 'live_lnk'"),
        ({"lower": ["chin", "chin"]}, "names chin more than once"),
        ({"lower": "chin"}, "the region lower must be a list of names"),
    ):
        with pytest.raises(SettingError, match=said):
            planned(regions=regions)
    (tmp_path / "face.yaml").write_text("lowr: [chin]\n")
    with pytest.raises(SettingError, match="the file .*face.yaml, has the unknown region 'lowr'"):
        planned(regions="face.yaml")


def test_channels_and_markers_are_read_by_name(tmp_path):
    path = tmp_path / "a.csv"
    write_csv(path, [0.5, 0.6, 0.7], {"extra": [9, 9, 9], **channels(3)}, "Time")
    found = read_csv(path, ("CHIN", "Brow"))
    np.testing.assert_allclose(found.points[:, :, 0], [[20, 0], [21, 1], [22, 2]])
    np.testing.assert_allclose(found.times, [0, 0.1, 0.2], atol=1e-12)
    points = moving(0.1, 3)
    points[2, 1, 0] = np.nan
    write_csv(path, np.arange(12) / 120, marker_columns(NAMES, points))
    found = read_csv(path, NAMES[::-1])
    np.testing.assert_allclose(found.points, points[:, ::-1], rtol=1e-5)
    assert np.isnan(found.points[2, 1, 0]) and np.isnan(found.points).sum() == 1


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_csv_as_spreadsheets_write_it(tmp_path, encoding, delimiter):
    text = "time,brow,chin,\r\n0,1,2,\r\n\r\n0.1,NaN,,\r\n"
    (tmp_path / "a.csv").write_bytes(text.replace(",", delimiter).encode(encoding))
    found = read_csv(tmp_path / "a.csv", ("brow", "chin"))
    np.testing.assert_array_equal(found.points[:, :, 0], [[1, 2], [np.nan, np.nan]])


def test_files_without_times_have_the_rate_of_the_corpus(tmp_path):
    (tmp_path / "a.csv").write_text("brow\n1\n2\n3\n")
    np.testing.assert_allclose(read_csv(tmp_path / "a.csv", ("brow",), rate=50).times, [0, 0.02, 0.04])
    with pytest.raises(RejectedUtterance, match="a.csv has no column `time` .its columns: brow.") as told:
        read_csv(tmp_path / "a.csv", ("brow",))
    assert "`rate`" in told.value.remedy


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("time,brow\n0,1\n1\n", "line 3: the row has 1 cells, the first line names 2 columns"),
        ("time,brow\n0,1\n1,2,3\n", "line 3: the row has 3 cells"),
        ("time,chin\n0,1\n", "lacks 1 of 1 columns: brow .there are time, chin."),
        ("time,brow\n0,1\n0,2\n", "line 3: its time, 0.0000 s after the first row, repeats that of line 2"),
        ("time,brow\n0,1\n2,2\n1,3\n", "line 4: its time, 1.0000 s .* is earlier than that of line 3"),
        ("time,brow\n0,1\n1,x\n", "line 3: `brow` is 'x', not a number"),
        ("time,brow\n0,1\n1,inf\n", "line 3: an infinite value"),
        ("time,brow\n0,1\nnan,2\n", "line 3: the time is no number"),
        ("time,brow\n0,1\n,2\n", "line 3: the time is no number"),
        ("time,brow\n0,1\nx,2\n", "line 3: `time` is 'x', not a number"),
        ("time,brow,brow\n0,1,1\n", "two columns named `brow`"),
        ("time,brow\n", "holds no row below its first line"),
        ("", "lacks 1 of 1 columns: brow .there are none."),
        ("timecode,brow\n10:00:00,1\n", "line 2: the timecode '10:00:00' is not of the form"),
        ("timecode,brow\n10:00:00:30,1\n10:00:00:400,1\n", "line 3: the timecode counts 400 frames in a second"),
        ('time,brow\n0,"1\n', "a.csv, line 2: a quote is not closed"),
        ("\0\0\0", "a.csv lacks"),
    ],
)
def test_damaged_csv(tmp_path, text, reason):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(RejectedUtterance, match=reason) as told:
        read_csv(tmp_path / "a.csv", ("brow",))
    assert told.value.remedy.endswith(".") and str(tmp_path) not in told.value.reason


def test_columns_of_both_kinds_are_refused(tmp_path):
    points = moving(0.1, 2)
    write_csv(tmp_path / "a.csv", np.arange(12), {**marker_columns(("brow", "cheek"), points), "chin": np.zeros(12)})
    with pytest.raises(RejectedUtterance, match="single columns of some names .chin. and three"):
        read_csv(tmp_path / "a.csv", NAMES)
    with pytest.raises(RejectedUtterance, match="lacks columns _x, _y, _z of lip"):
        read_csv(tmp_path / "a.csv", ("brow", "lip"))
    assert read_csv(tmp_path / "a.csv", ("brow", "cheek")).points.shape == (12, 2, 3)


def test_sizes_are_bounded(tmp_path, monkeypatch):
    import visualspeech.corpora.motion_files as module

    path = tmp_path / "a.csv"
    write_csv(path, range(20), channels(20))
    for name, value, said in (
        ("MAX_BYTES", 100, "larger than 100 bytes"),
        ("MAX_ROWS", 10, "more than 10 rows"),
        ("MAX_VALUES", 30, "more than 10 rows"),
        ("MAX_COLUMNS", 3, "more than 3 columns"),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            with pytest.raises(RejectedUtterance, match=said):
                read_csv(path, NAMES)
    with pytest.raises(RejectedUtterance, match="does not exist"):
        read_csv(tmp_path / "none.csv", NAMES)
    with pytest.raises(RejectedUtterance, match="cannot be read: it is a folder"):
        read_csv(tmp_path, NAMES)


def test_live_link_face_is_read_as_it_is(tmp_path):
    markers = read_marker_set("live_link")
    values = write_live_link(tmp_path / "a.csv", unseen=(10, 11))
    assert len(LIVE_LINK) == 61 and set(markers.names) == set(LIVE_LINK[:52])
    found = read_csv(tmp_path / "a.csv", markers.names)
    expected = values[:, [LIVE_LINK.index(name) for name in markers.names]].copy()
    expected[10:12] = np.nan
    np.testing.assert_allclose(found.points[:, :, 0], expected, atol=1e-8)
    np.testing.assert_allclose(found.times, np.arange(len(values)) / 60, atol=2e-5)


@pytest.mark.parametrize(("rate", "count", "given"), [(30, 30, 0), (25, 25, 0), (60, 60, 0), (24, 30, 30)])
def test_timecodes_become_seconds_over_midnight(tmp_path, rate, count, given):
    codes = timecodes(3 * rate, rate, 86_400 - 1.5, count)
    assert codes[0].startswith("23:59:58") and codes[-1].startswith("00:00:01")
    write_csv(tmp_path / "a.csv", codes, channels(3 * rate), "Timecode")
    found = read_csv(tmp_path / "a.csv", NAMES, timecode_rate=given)
    np.testing.assert_allclose(found.times, np.arange(3 * rate) / rate, atol=1e-4)


def test_sound_is_checked_without_a_video(tmp_path):
    from visualspeech.corpora.check import check_recording
    from visualspeech.corpora.check_settings import CheckSettings
    from visualspeech.corpora.records import Utterance

    write_live_link(tmp_path / "a.csv")
    samples = write_wav(tmp_path / "a.wav", 1.6)
    one = Utterance("a", "s", "", "", motion=str(tmp_path / "a.csv"), audio=str(tmp_path / "a.wav"))

    def checked(**changes):
        from dataclasses import replace

        return check_recording(replace(one, **changes), lambda text: [], CheckSettings(), text=False)

    good = checked()
    assert good.findings == [] and good.rejected is None and len(good.samples) == len(samples)
    np.testing.assert_allclose(good.samples / 32767, samples, atol=1e-4)
    assert checked(start=0.5, end=1.25).samples.shape == (12_000,)
    (warned,) = checked(warning="the emotion file lacks it", remedy="Restore it.").findings
    assert (warned.level, warned.finding, warned.file) == ("warn", "the emotion file lacks it", one.motion)
    write_csv(tmp_path / "b.csv", [0, 1], channels(2))
    assert checked(motion=str(tmp_path / "b.csv")).digest != good.digest  # the same sound with another face
    assert checked(audio=str(tmp_path / "no.wav")).rejected.reason == "the file no.wav does not exist"
    assert checked(motion=str(tmp_path / "no.csv")).rejected.reason == "the file does not exist"
    write_wav(tmp_path / "short.wav", 0.2)
    assert checked(audio=str(tmp_path / "short.wav")).rejected.reason == "only 0.20 s of sound"
    (tmp_path / "bad.wav").write_bytes(b"no sound")
    assert checked(audio=str(tmp_path / "bad.wav")).rejected.reason.startswith("unreadable media file")
