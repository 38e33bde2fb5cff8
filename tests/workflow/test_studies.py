"""The target `study`: stimuli and key of a viewing test, and what becomes of it once people have answered."""

import shutil
import sqlite3

import pytest

from tests.described_files import undescribed
from tests.workflow.running import overlay, snakemake
from visualspeech.study.layouts import TABLES
from visualspeech.study.records import ANSWERS, MEDIA, read_key, read_study

pytestmark = pytest.mark.xdist_group("workflow")


def test_a_study_is_made_and_left_alone_once_people_have_answered_it(tiny_run, tmp_path):
    done = snakemake(tiny_run, "study")
    assert done.returncode == 0, done.stdout[-3000:]
    assert "visualspeech study serve results/tiny/studies/fan2015\n" in done.stdout
    folder = tiny_run / "results" / "tiny" / "studies" / "fan2015"
    study, key = read_study(folder), read_key(folder)
    media = {path.name for path in (folder / MEDIA).iterdir()} - {".snakemake_timestamp"}
    assert media == {*key.stimuli, study.sound_check.stimulus}
    assert [one.model for one in key.conditions] == ["FB-16", "hmm_mge"] and key.corpus == "tiny"
    assert [line for line in undescribed(folder.parents[1]) if line.startswith("studies")] == []
    assert "sadoughi2017 is skipped: it compares models of sadoughi2017, which is not selected" in done.stdout
    more = overlay(tmp_path, {"override": {"studies": {"fan2015": {"attention": 1}}}})
    assert "rule make_study" in snakemake(tiny_run, "--dry-run", "study", configfiles=more).stdout
    with sqlite3.connect(folder / ANSWERS) as database:
        database.executescript(TABLES)
        database.execute("INSERT INTO participants VALUES (1, 'c', 't', 0, 'now', 'now', NULL, NULL)")
    database.close()
    done = snakemake(tiny_run, "study", "--forcerun", "make_study", configfiles=more)
    assert done.returncode == 0 and "the study fan2015 of tiny is left as it is" in done.stdout
    assert read_study(folder) == study and read_key(folder) == key
    shutil.rmtree(folder.parent)


def test_a_study_of_unknown_models_concerns_no_other_target(tiny_run, tmp_path):
    wrong = overlay(tmp_path, {"override": {"studies": {"fan2015": {"conditions": ["FB-17", "hmm_mge"]}}}})
    done = snakemake(tiny_run, "--dry-run", "study", configfiles=wrong)
    assert done.returncode != 0 and "Traceback" not in done.stdout
    assert "`studies.fan2015.conditions.0: FB-17` is no model of fan2015" in done.stdout
    assert snakemake(tiny_run, "--dry-run", "tables", configfiles=wrong).returncode == 0
