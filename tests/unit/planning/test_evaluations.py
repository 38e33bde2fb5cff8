"""Answered studies in the settings: what is found in their folders, and what is wrong with them."""

from dataclasses import replace

import pytest

from tests.unit.study.folders import preference_study, preferring, write_answers
from visualspeech.errors import SettingError
from visualspeech.planning.evaluations import EvaluatedStudy, answers_state, evaluated_studies
from visualspeech.study.records import ANSWERS, write_key, write_study


@pytest.fixture
def folder(tmp_path):
    study, key = preference_study(tmp_path / "fan")
    write_answers(tmp_path / "fan", study, preferring(study, key, 2))
    return tmp_path / "fan"


def test_a_study_knows_its_corpus_and_name(folder):
    assert evaluated_studies({"folders": [str(folder)]}, ["demo"]) == (EvaluatedStudy("demo", "fan2015", str(folder)),)
    assert evaluated_studies({"folders": []}, ["demo"]) == ()


def test_mistakes_are_told_at_once_with_their_place(folder, tmp_path):
    (tmp_path / "copy").mkdir()
    for name in ("study.json", "key.json"):
        (tmp_path / "copy" / name).write_bytes((folder / name).read_bytes())
    given = [str(folder), str(tmp_path / "nowhere"), str(tmp_path / "copy"), f"/{'x' * 300}"]
    with pytest.raises(SettingError) as caught:
        evaluated_studies({"folders": given}, ["demo"])
    first, second, third = str(caught.value).splitlines()
    assert first.startswith(f"`study_evaluation.folders.1: {given[1]}`: ") and "holds no study" in first
    assert f"folders.2: {given[2]}`: {folder} holds the study fan2015, too; leave one out." in second
    assert "folders.3" in third and "name too long" in third.lower()
    with pytest.raises(SettingError, match="is a study of the corpus demo, which is not run .run: grid.; add the"):
        evaluated_studies({"folders": [str(folder)]}, ["grid"])


@pytest.mark.parametrize("name", ["../up", "a b", "x" * 65])
def test_a_name_that_is_no_folder_is_refused(folder, name):
    """The folder may come from a stranger, and its name is part of a path."""
    study, key = preference_study(folder)
    study = write_study(folder, replace(study, name=name))
    write_key(folder, replace(key, study=study.digest))
    with pytest.raises(SettingError, match="must be letters, digits, - and _, at most 64"):
        evaluated_studies({"folders": [str(folder)]}, ["demo"])


def test_new_answers_change_the_state(folder):
    before = answers_state(str(folder), False)
    assert before == answers_state(str(folder), False) != answers_state(str(folder), True)
    (folder / f"{ANSWERS}-wal").write_bytes(b"latest answers")
    assert answers_state(str(folder), False) != before
