"""What a study folder holds is read as it was written, and nothing else is read."""

import json
import sqlite3

import pytest

from tests.unit.study import studies
from visualspeech.errors import DataError, StorageError
from visualspeech.study.layouts import RATING, TABLES
from visualspeech.study.records import (
    Answer,
    is_answered,
    read_answers,
    read_key,
    read_participants,
    read_study,
    write_study,
)


@pytest.fixture
def folder(tmp_path):
    return studies.make(tmp_path / "study", seconds=0.2)


def database(folder, name="answers.sqlite", simulated=0, digest=None):
    made = sqlite3.connect(folder / name)
    made.executescript(TABLES)
    made.execute("INSERT INTO study VALUES (?, ?)", (digest or read_study(folder).digest, simulated))
    made.execute("INSERT INTO participants VALUES (1, 'code', 'ticket', ?, 'now', 'now', NULL, NULL)", (simulated,))
    made.execute("INSERT INTO answers VALUES (1, 'i0', 'preference', 'left', 1, 1, 1, 'now')")
    made.commit()
    made.close()


def test_what_is_written_is_read(folder):
    study = read_study(folder)
    assert write_study(folder, study) == study
    assert len(study.of_role("item")) == 3 and not study.forced and study.sound_check.answer == "table"
    key = read_key(folder)
    assert key.stimuli["s002.mp4"].conditions == ("a", "b") and key.expected == {"t0": {"preference": "right"}}


def test_answers_are_looked_up_by_the_key(folder):
    assert read_answers(folder) == read_participants(folder) == () and not is_answered(folder)
    database(folder)
    (answer,) = read_answers(folder)
    assert answer == Answer(1, "i0", "preference", "left", 1, 1, True, "now")
    study, key = read_study(folder), read_key(folder)
    # Mirrored, b is on the left.
    assert key.preferred(study, answer) == "b" and is_answered(folder)
    assert read_answers(folder, simulated=True) == ()


def test_ratings_are_numbers(tmp_path):
    folder = studies.make(tmp_path / "study", RATING, seconds=0.2)
    database(folder)
    with sqlite3.connect(folder / "answers.sqlite") as made:
        made.execute("UPDATE answers SET item = 'i0a', question = 'lips', value = '7', mirrored = 0")
    (answer,) = read_answers(folder)
    assert answer.value == 7 and read_key(folder).shown(read_study(folder), answer).conditions == ("a",)


def test_answers_of_people_and_simulated_ones_are_not_mixed(folder):
    database(folder, "answers.simulated.sqlite", simulated=1)
    assert len(read_answers(folder, simulated=True)) == 1 and not is_answered(folder)
    (folder / "answers.simulated.sqlite").rename(folder / "answers.sqlite")
    with pytest.raises(DataError, match="does not hold answers of people to this study"):
        read_answers(folder)


def test_answers_to_another_version_are_refused(folder):
    database(folder, digest="0" * 12)
    with pytest.raises(DataError, match="the study was made again"):
        read_participants(folder)


def test_the_key_of_another_study_is_refused(folder):
    about = json.loads((folder / "key.json").read_text())
    (folder / "key.json").write_text(json.dumps(about | {"study": "0" * 12}))
    with pytest.raises(DataError, match="is not the key of"):
        read_key(folder)
    del about["stimuli"]["s002.mp4"]
    (folder / "key.json").write_text(json.dumps(about))
    with pytest.raises(StorageError, match="does not say what s002.mp4 is"):
        read_key(folder)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"kind": "survey"}, "kind"),
        ({"items": []}, "items"),
        ({"more": 1}, "more"),
        ({"version": 2}, "version"),
    ],
)
def test_a_damaged_study_is_refused_in_a_sentence(folder, change, message):
    about = json.loads((folder / "study.json").read_text())
    (folder / "study.json").write_text(json.dumps(about | change))
    with pytest.raises(StorageError, match=message) as caught:
        read_study(folder)
    assert "Make the study again" in str(caught.value)


@pytest.mark.parametrize("name", ["../key.json", "/etc/passwd", "a/b.mp4", "x.sqlite", ".mp4"])
def test_a_stimulus_is_a_plain_name(folder, name):
    about = json.loads((folder / "study.json").read_text())
    about["items"][0]["stimuli"] = [name]
    (folder / "study.json").write_text(json.dumps(about))
    with pytest.raises(StorageError):
        read_study(folder)


def test_no_study_and_no_database(folder, tmp_path):
    with pytest.raises(StorageError, match="holds no study: there is no study.json"):
        read_study(tmp_path)
    (folder / "study.json").write_text("{")
    with pytest.raises(StorageError, match="it is no JSON"):
        read_study(folder)
    studies.make(tmp_path / "other", seconds=0.2)
    (tmp_path / "other" / "answers.sqlite").write_bytes(b"no database at all" * 100)
    with pytest.raises(StorageError, match="cannot read .*answers.sqlite"):
        read_answers(tmp_path / "other")
    assert is_answered(tmp_path / "other")  # what cannot be read is not replaced
