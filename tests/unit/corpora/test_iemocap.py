"""The tree of IEMOCAP: turns of actors with markers, emotions by majority, what is missing."""

import numpy as np
import pytest

from tests.motion_capture import MARKERS, RATINGS, IemocapTree, write_evaluation, write_mocap
from visualspeech.corpora.adapters import list_utterances
from visualspeech.corpora.iemocap_texts import majority, read_emotions, read_transcripts
from visualspeech.corpora.motion_files import read_iemocap
from visualspeech.errors import CorpusError, RejectedUtterance, SettingError
from visualspeech.face.markers import read_marker_set
from visualspeech.planning.corpora import plan_corpus

EMOTIONS = {"neu": "neutral", "ang": "anger", "sad": "sadness", "exc": "excited", "xxx": ""}
SHARES = {"train": 0.6, "validation": 0.2, "test": 0.2}


def corpus(root, **settings):
    return {"name": "iemocap", "adapter": "iemocap", "root": str(root), **settings}


def listed(root, **settings):
    return {one.id: one for one in list_utterances(corpus(root, **settings))}


def test_the_turns_of_the_actors_with_markers_are_listed(tmp_path):
    tree = IemocapTree(tmp_path)
    found = listed(tmp_path)
    assert list(found) == sorted(tree.turns) and len(found) == 2 * 2 * len(RATINGS)
    for turn, one in found.items():
        assert one.speaker == turn[:6] and turn.rpartition("_")[2][0] == turn[5]
        assert (one.motion, one.audio) == (str(tree.motion(turn)), str(tree.sound(turn)))
        assert (one.media, one.problem, one.warning, one.split) == ("", "", "", "")
        assert one.file == one.motion and one.sound == one.audio
        assert one.emotion == EMOTIONS[tree.turns[turn]]
        assert one.transcript.startswith("Excuse me, number")
    assert len({one.speaker for one in found.values()}) == 4


def test_sessions_speakers_and_transcripts_are_settings(tmp_path):
    IemocapTree(tmp_path)
    assert {one.speaker for one in listed(tmp_path, sessions=[2]).values()} == {"Ses02F", "Ses02M"}
    assert {one.speaker for one in listed(tmp_path, speaker="ses01m").values()} == {"Ses01M"}
    assert {one.transcript for one in listed(tmp_path, transcripts=False).values()} == {""}
    with pytest.raises(CorpusError, match="no turns of session 5 in .*; there are sessions 1, 2. Correct `sessions`"):
        listed(tmp_path, sessions=[1, 5])
    with pytest.raises(CorpusError, match="no turns of the speaker 'Ses05F' .* Ses01F, Ses01M, Ses02F, Ses02M"):
        listed(tmp_path, speaker="Ses05F")


def test_what_is_missing_is_said_and_the_corpus_goes_on(tmp_path):
    tree = IemocapTree(tmp_path, sessions=(1,), unrated=True)
    tree.sound("Ses01F_impro01_F000").unlink()
    tree.motion("Ses01F_impro01_F001").unlink()
    tree.evaluation("Ses01M_script01_1_X").unlink()
    found = listed(tmp_path)
    assert len(found) == 10
    said = found["Ses01F_impro01_F000"]
    assert said.problem == "no sound: there is no file sentences/wav/Ses01F_impro01/Ses01F_impro01_F000.wav"
    assert said.remedy == "Restore the file from the corpus."
    said = found["Ses01F_impro01_F001"]
    assert said.problem.startswith("no motion capture: there is no file sentences/MOCAP_rotated/Ses01F_impro01/Ses01F_")
    said = found["Ses01F_impro01_F004"]
    assert said.warning == "the emotion file Ses01F_impro01.txt does not hold the turn Ses01F_impro01_F004"
    assert (said.problem, said.emotion) == ("", "") and "left out of the analysis of emotions" in said.remedy
    assert found["Ses01F_impro01_F003"].warning == "" and found["Ses01F_impro01_F003"].emotion == "excited"
    assert found["Ses01M_script01_1_M000"].warning == "there is no emotion file Ses01M_script01_1.txt"
    plan = plan_corpus(corpus(tmp_path), 2, SHARES, 1, "results")
    assert plan.gives == {"audio", "text", "motion", "faces", "emotion", "arpabet"}


def test_an_emotion_file_that_cannot_be_read_costs_the_emotions(tmp_path):
    tree = IemocapTree(tmp_path, sessions=(1,))
    path = tree.evaluation("Ses01F_impro01_X")
    path.unlink()
    path.mkdir()
    (path / "x").write_text("")
    found = listed(tmp_path)
    assert len(found) == 10 and "there is no emotion file" in found["Ses01F_impro01_F000"].warning
    big = tree.evaluation("Ses01M_script01_1_X")
    big.write_bytes(b"x" * 1_000_001)
    assert "cannot be read: it is larger than 1,000,000 bytes" in listed(tmp_path)["Ses01M_script01_1_M000"].warning


def test_a_root_that_is_no_iemocap(tmp_path):
    with pytest.raises(SettingError, match="has no `root`"):
        listed("")
    with pytest.raises(CorpusError, match="no motion capture of IEMOCAP .*MOCAP_rotated and so on; archives must be"):
        listed(tmp_path)


@pytest.mark.parametrize(
    ("raters", "emotion"),
    [
        ([{"a"}, {"a"}, {"b"}], "a"),
        ([{"a"}, {"b"}, {"c"}], ""),
        ([{"a", "b"}, {"b"}, {"c"}], "b"),
        ([{"a", "b"}, {"a", "b"}, {"c"}], ""),
        ([{"a", "b"}, {"a", "b"}, {"b"}], "b"),
        ([{"a"}, {"b"}], ""),
        ([{"a"}], "a"),
        ([], ""),
    ],
)
def test_the_majority_of_raters(raters, emotion):
    assert majority(raters) == emotion


def test_emotions_of_a_file(tmp_path):
    path = tmp_path / "Ses01F_impro01.txt"
    turns = {f"Ses01F_impro01_F{number:03d}": label for number, label in enumerate(RATINGS)}
    write_evaluation(path, turns)
    assert read_emotions(path) == {turn: EMOTIONS[label] for turn, label in turns.items()}
    path.write_text("[6.2901 - 8.2357]\tSes01F_impro01_F000\tfru\t[2.5, 2.5, 2.5]\nC-F1:\tAnger;\t()\n")
    assert read_emotions(path) == {"Ses01F_impro01_F000": "frustration"}  # without raters the corpus's own label
    path.write_text("[6.2901 - 8.2357]\tSes01F_impro01_F000\txxx\t[2.5, 2.5, 2.5]\nnonsense\nC-E2:\t;\t()\n")
    assert read_emotions(path) == {"Ses01F_impro01_F000": ""}


def test_transcripts_of_a_file(tmp_path):
    path = tmp_path / "Ses01F_impro01.txt"
    path.write_text(
        "Ses01F_impro01_F000 [006.2901-008.2357]: Excuse me.\n"
        "Ses01F_impro01_M000 [007.5712-010.4750]: Do you have your forms?\n"
        "Ses01F_impro01_F001 [010.0100-011.3925]: [LAUGHTER] Yeah.\n"
        "F: no turn of the corpus\n"
    )
    assert read_transcripts(path) == {
        "Ses01F_impro01_F000": "Excuse me.",
        "Ses01F_impro01_M000": "Do you have your forms?",
        "Ses01F_impro01_F001": "Yeah.",
    }


def test_markers_are_read_by_name(tmp_path):
    random = np.random.default_rng(1)
    points = random.normal(0, 50, (7, len(MARKERS), 3))
    points[3, MARKERS.index("CH2")] = np.nan
    path = tmp_path / "turn.txt"
    write_mocap(path, points, 6.2901)
    names = read_marker_set("iemocap_46").names
    assert len(names) == 46 and set(names) <= set(MARKERS)
    found = read_iemocap(path, names)
    np.testing.assert_allclose(found.points, points[:, [MARKERS.index(name) for name in names]], atol=1e-5)
    np.testing.assert_allclose(found.times, np.arange(7) / 120, atol=2e-5)
    assert found.times[0] == 0


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        (
            lambda lines: [*lines[:4], lines[4].rsplit(" ", 2)[0], *lines[5:]],
            "line 5: the row has 165 numbers",
        ),
        (lambda lines: [*lines[:4], lines[3], *lines[5:]], "line 5: its time, 0.0083 s after the first row, repeats"),
        (lambda lines: [*lines[:3], lines[5], lines[4]], "line 5: its time, .* is earlier than that of line 4"),
        (lambda lines: [lines[0].replace(" CH2 ", " XX "), *lines[1:]], "lacks 1 of 46 markers: CH2"),
        (lambda lines: lines[2:], "its first line does not begin with `Frame# Time`"),
        (lambda lines: lines[:2], "holds no frame"),
        (lambda lines: [], "is no motion capture of IEMOCAP"),
        (lambda lines: [*lines[:3], lines[3].replace(" ", " x", 3), *lines[4:]], "line 4: .* is 'x.*', not a number"),
        (lambda lines: [*lines[:3], lines[3].rsplit(" ", 4)[0] + " inf" * 4, *lines[4:]], ""),
    ],
)
def test_damaged_motion_capture(tmp_path, edit, reason):
    path = tmp_path / "turn.txt"
    write_mocap(path, np.random.default_rng(1).normal(0, 50, (6, len(MARKERS), 3)))
    path.write_text("\n".join(edit(path.read_text().splitlines())) + "\n")
    names = read_marker_set("iemocap_46").names
    if not reason:  # the marker with the infinite values is not among those that are read
        assert np.isfinite(read_iemocap(path, names).points).all()
        return
    with pytest.raises(RejectedUtterance, match=f"turn.txt.*{reason}" if "turn" not in reason else reason) as told:
        read_iemocap(path, names)
    assert told.value.remedy.endswith(".")
