"""Videos of the report: stills, what is embedded, and which come first."""

import cv2
import numpy as np

from visualspeech.corpora.records import Utterance
from visualspeech.evaluation import report_videos
from visualspeech.evaluation.report import Video
from visualspeech.evaluation.report_videos import still, strip, videos
from visualspeech.media.encoding import write_video


def film(path, seconds=1.0, rate=25):
    """A video whose frames become brighter."""
    levels = np.linspace(0, 250, round(seconds * rate)).astype(np.uint8)
    write_video(path, (np.full((120, 960, 3), level, np.uint8) for level in levels), rate)


def test_a_still_is_a_small_picture_from_inside_the_video(tmp_path):
    film(tmp_path / "a.mp4")
    picture = cv2.imdecode(np.frombuffer(still(tmp_path / "a.mp4"), np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape == (60, 480, 3) and 190 < picture.mean() < 225
    assert still(tmp_path / "a.mp4") == still(tmp_path / "a.mp4")
    film(tmp_path / "short.mp4", 0.2)
    assert still(tmp_path / "short.mp4")
    (tmp_path / "no.mp4").write_bytes(b"no video")
    assert still(tmp_path / "no.mp4") == b""


def test_the_first_videos_have_stills(tmp_path, monkeypatch):
    monkeypatch.setattr(report_videos, "STILLS", 1)
    folder = tmp_path / "fan2015" / "videos"
    folder.mkdir(parents=True)
    for name in "ab":
        film(folder / f"{name}.mp4", 0.2)
    spoken = [Utterance("a", "s", "a.mp4", "some words", "test")]
    first, second = videos(str(folder), str(tmp_path / "report.html"), spoken, "FBB-64", "Fan 2015")
    assert (first.path, first.transcript, first.model, first.system) == (
        "fan2015/videos/a.mp4", "some words", "FBB-64", "Fan 2015")  # fmt: skip
    assert first.still and not second.still and not first.content


def shown(system, names):
    return [Video(f"{system}/{name}.mp4", name, system=system, still=b"still") for name in names]


def test_systems_take_turns_and_show_the_same_words(tmp_path, monkeypatch):
    monkeypatch.setattr(report_videos, "MAX_EMBEDDED", 100)
    monkeypatch.setattr(report_videos, "MAX_TOGETHER", 250)
    given = [shown("one", "abc"), shown("two", "bcd"), [Video("three/x.mp4", "x", system="three")]]
    for one in (video for own in given for video in own):
        path = tmp_path / one.path
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"0" * (101 if one.path == "two/b.mp4" else 90))
    found = strip(given, str(tmp_path / "report.html"))
    assert [one.path for one in found] == ["one/b.mp4", "two/b.mp4", "one/c.mp4", "two/c.mp4", "one/a.mp4", "two/d.mp4"]
    # Too large by itself, and, after two of 90 bytes, too large together.
    assert [bool(one.content) for one in found] == [True, False, True, False, False, False]
    assert strip([], "report.html") == ()
