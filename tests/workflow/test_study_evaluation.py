"""Answered viewing tests in a run: evaluated as a target, again when there are new answers, and shown in the report."""

import shutil

import pytest

from tests.unit.study.folders import preference_study, preferring, write_answers
from tests.workflow.running import overlay, snakemake

pytestmark = pytest.mark.xdist_group("workflow")


@pytest.fixture
def answered(tiny_run, tmp_path):
    """The folder of an answered study of the tiny corpus, and the settings that evaluate it."""
    folder = tmp_path / "answered"
    study, key = preference_study(folder, corpus="tiny")
    write_answers(folder, study, preferring(study, key, 3))
    yield folder, overlay(tmp_path, {"study_evaluation": {"folders": [str(folder)], "statistics": {"samples": 100}}})
    shutil.rmtree(tiny_run / "results" / "tiny" / "evaluations", ignore_errors=True)


def test_an_answered_study_is_evaluated(tiny_run, answered):
    folder, settings = answered
    done = snakemake(tiny_run, "study_evaluation", configfiles=settings)
    assert done.returncode == 0, done.stdout[-3000:]
    made = tiny_run / "results" / "tiny" / "evaluations" / "fan2015"
    assert "3 counted, 0 left out" in (made / "preference.md").read_text() and (made / "preference.png").is_file()
    assert sorted(path.name for path in folder.iterdir()) == ["answers.sqlite", "key.json", "study.json"]
    report = snakemake(tiny_run, "--dry-run", "report", configfiles=settings)
    assert "rule write_report" in report.stdout and "rule evaluate_study" not in report.stdout
    study, key = preference_study(folder, corpus="tiny")
    write_answers(folder, study, preferring(study, key, 4))
    again = snakemake(tiny_run, "--dry-run", "report", configfiles=settings)
    assert "rule evaluate_study" in again.stdout and "rule train_model" not in again.stdout


def test_what_cannot_be_evaluated_is_said(tiny_run, answered, tmp_path):
    folder, settings = answered
    none = snakemake(tiny_run, "study_evaluation", "--dry-run")
    assert none.returncode != 0 and "no study is evaluated: name the folders" in none.stdout
    (folder / "answers.sqlite").unlink()
    empty = snakemake(tiny_run, "study_evaluation", configfiles=settings)
    assert empty.returncode != 0 and "holds no answers of people yet" in empty.stdout
    (folder / "key.json").unlink()
    unknown = snakemake(tiny_run, "--dry-run", configfiles=settings)
    assert unknown.returncode != 0 and f"`study_evaluation.folders.0: {folder}`" in unknown.stdout
    for done in (none, empty, unknown):
        assert "Traceback" not in done.stdout
    assert not (tiny_run / "results" / "tiny" / "evaluations" / "fan2015").exists()
