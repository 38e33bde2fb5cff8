"""A tracker of the user's own: what it is told, and what is said where it is wrong."""

import sys
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.face import trackers
from visualspeech.errors import RejectedUtterance, SettingError
from visualspeech.face.landmarks import track
from visualspeech.face.screening import track_recording
from visualspeech.face.tracker import TRACKERS, LandmarkSettings, TrackedVideo
from visualspeech.face.tracker_loading import load_tracker

STILL = replace(LandmarkSettings(), smoothing=0.0)
FRAMES = [np.zeros((4, 5, 3), np.uint8)] * 3
VIDEO = TrackedVideo("a.mp4", 25.0)


def own(name, module="tests.unit.face.trackers"):
    return replace(STILL, tracker=f"{module}:{name}")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder for modules; what is imported from it is forgotten."""
    before, path = set(sys.modules), list(sys.path)
    yield tmp_path
    sys.path[:] = path
    for name in set(sys.modules) - before:
        del sys.modules[name]


def test_a_tracker_of_ones_own_takes_the_place_of_dlib():
    trackers.Corner.videos.clear(), trackers.Corner.numbers.clear()
    result = track(FRAMES, own("Corner"), rate=25.0, path="b.mp4", first=10)
    np.testing.assert_array_equal(result.points[:, 0, 0], [1, 2, 3])
    assert trackers.Corner.numbers == [10, 11, 12] and result.findings == ()
    assert trackers.Corner.videos == [TrackedVideo("b.mp4", 25.0, 10)]
    said = track(FRAMES, own("Remarking"), rate=25.0).findings
    assert said == ("the light was poor", "3 faces in one frame; the largest was followed")


def test_the_segment_of_a_recording_is_told(tmp_path):
    from visualspeech.media.encoding import write_video

    rng = np.random.default_rng(0)
    still = rng.integers(0, 255, (64, 64, 3), np.uint8)
    write_video(tmp_path / "a.mp4", (np.roll(still, i, axis=0) for i in range(60)), 25.0)
    trackers.Corner.videos.clear(), trackers.Corner.numbers.clear()
    from visualspeech.face.screening import ScreeningSettings

    loose = ScreeningSettings(max_frame_change=255, max_landmark_step=10)
    track_recording(tmp_path / "a.mp4", 1.0, 2.0, own("Corner"), loose)
    assert trackers.Corner.numbers == list(range(25, 50))
    assert trackers.Corner.videos == [TrackedVideo(str(tmp_path / "a.mp4"), 25.0, 25)]


@pytest.mark.parametrize(
    ("name", "module", "said"),
    [
        ("Corner", "nowhere_at_all", "there is no module nowhere_at_all. Put it into the folder of the settings file"),
        ("Corner", "tests.unit.face.nowhere", "there is no module tests.unit.face.nowhere"),
        ("Nobody", "tests.unit.face.trackers", "the module tests.unit.face.trackers has no Nobody"),
        ("NOT_A_CLASS", "tests.unit.face.trackers", "NOT_A_CLASS is no class"),
        ("OldStyle", "tests.unit.face.trackers", r"`OldStyle\(settings, video\)` cannot be called"),
        ("NoNext", "tests.unit.face.trackers", "NoNext has no method `next`"),
        ("OldNext", "tests.unit.face.trackers", r"`OldNext.next\(frame, number\)` cannot be called"),
    ],
)
def test_what_is_no_tracker_is_told_in_a_sentence(name, module, said):
    with pytest.raises(SettingError, match=f"`landmarks.tracker: {module}:{name}`: {said}"):
        track(FRAMES, own(name, module), rate=25.0)


@pytest.mark.parametrize(
    ("points", "said"),
    [
        (np.zeros((68, 3)), r"an array of the shape \(68, 3\) for frame 0 of a.mp4"),
        (np.zeros((5, 2)), r"the shape \(5, 2\)"),
        ([1, 2, 3], r"the shape \(3,\)"),
        ("points", "a str"),
        ([[1, 2], [3]], "a list"),
        ({"x": 1}, "a dict"),
    ],
)
def test_other_shapes_than_points_are_a_mistake_of_the_settings(monkeypatch, points, said):
    monkeypatch.setattr(trackers.Returning, "points", points)
    with pytest.raises(SettingError, match=said):
        track(FRAMES, own("Returning"), rate=25.0, path="a.mp4")


def test_points_that_are_not_finite_are_no_face(monkeypatch):
    points = np.zeros((68, 2))
    points[3, 1] = np.nan
    monkeypatch.setattr(trackers.Returning, "points", points)
    with pytest.raises(RejectedUtterance, match="no face in any frame"):
        track(FRAMES, own("Returning"), rate=25.0)


def test_a_module_is_found_in_the_folder_of_the_user_and_its_neighbours_too(folder):
    (folder / "mine_alone.py").write_text("from its_neighbour import Corner\n")
    (folder / "its_neighbour.py").write_text("from tests.unit.face.trackers import Corner\n")
    tracker = load_tracker(own("Corner", "mine_alone"), VIDEO, str(folder))
    assert isinstance(tracker, trackers.Corner)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "import nothing_like_this\n",
            "cannot be imported \\(ModuleNotFoundError: No module named 'nothing_like_this'",
        ),
        ("def (:\n", "cannot be imported \\(SyntaxError"),
        ("1 / 0\n", "cannot be imported \\(ZeroDivisionError"),
        ("raise SystemExit(0)\n", "cannot be imported \\(SystemExit"),
    ],
)
def test_a_module_that_cannot_be_imported(folder, text, said):
    (folder / "broken_one.py").write_text(text)
    with pytest.raises(SettingError, match=said):
        load_tracker(own("Corner", "broken_one"), VIDEO, str(folder))


def test_a_name_that_python_has_itself_is_told(folder):
    (folder / "json.py").write_text("class Tracker: pass\n")
    with pytest.raises(SettingError, match="Python has a module json of its own .* Rename the file"):
        load_tracker(own("Tracker", "json"), VIDEO, str(folder))


def test_settings_name_a_tracker_or_a_class():
    for name in ("nobody", "a:b:c", "os.path", "a/b:C", "a.:C", "dlib:", ":C", "a:1"):
        with pytest.raises(SettingError, match="landmarks.tracker"):
            replace(STILL, tracker=name)
    assert replace(STILL, tracker="a.b:C").tracker == "a.b:C" and set(TRACKERS) == {"dlib"}
    with pytest.raises(SettingError, match="`landmarks.folder: `"):
        LandmarkSettings(source="csv")
    with pytest.raises(SettingError, match="`landmarks.folder: there` must be left out, unless `source` is csv"):
        LandmarkSettings(folder="there")
