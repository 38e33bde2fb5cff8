"""What a run shows by default: a line per stage and five at its end, or what failed, where, and what to do."""

import pytest

from tests.workflow.running import TINY, of_system, overlay, planned_rules, snakemake, tables

pytestmark = pytest.mark.xdist_group("workflow")

STATISTICS = "results/tiny/fan2015/models/{}/statistics.tsv"
OWN = """def jaw(predicted, true, true_points):
    "Largest movement of a point that is predicted, in pixels."
    return {} * (predicted[:, 0].max() - predicted[:, 0].min())

jaw.best = "high"
"""


def test_a_run_shows_a_line_per_stage_and_ends_with_five(tiny_run):
    (tiny_run / "results/tiny/fan2015/tables/objective.tsv").unlink()
    (tiny_run / "results/tiny/report.html").unlink(missing_ok=True)
    done = snakemake(tiny_run, "all", quiet=True)
    lines = done.stdout.splitlines()
    assert done.returncode == 0 and len(lines) < 20, done.stdout
    # `Next` has a line more where the speaker has not been made yet.
    end = lines[next(number for number, line in enumerate(lines) if line.startswith("Report:")) :]
    assert [line.split(":")[0] for line in end[:5]] == ["Report", "Best model", "Rejected", "Guessed words", "Next"]
    assert "results/tiny/report.html" in end[0] and "fan2015" in end[1] and "0 of 12 utterances" in end[2]
    assert "visualspeech speak --model results/tiny/fan2015/speakers/FB-16" in end[-1] and len(end) <= 6
    assert any("tables" in line and "jobs done" in line for line in lines)
    assert "localrule" not in done.stdout and "tabulate_results" not in done.stdout
    again = snakemake(tiny_run, "all", quiet=True)
    assert "Nothing to be done" in again.stdout and again.stdout.splitlines()[-len(end) :] == end


def test_more_is_shown_where_it_is_asked_for(tiny_run):
    assert planned_rules(tiny_run, "all", "--forcerun", "write_report") == {"write_report", "all"}
    (tiny_run / "results/tiny/report.html").unlink(missing_ok=True)
    done = snakemake(tiny_run, "all")
    assert "rule write_report:" in done.stdout and "Report:" in done.stdout and "steps (100%) done" in done.stdout
    assert snakemake(tiny_run, "all", "--quiet", "all", quiet=True).stdout.count("\n") < 5


def test_an_own_measure_is_in_every_table_and_its_edit_measures_again(tiny_run):
    before = tables(tiny_run)
    (tiny_run / "mine.py").write_text(OWN.format("1.0"))
    files = overlay(tiny_run, of_system(tables={"metrics": ["rmse_appearance", "mine:jaw"]}))
    objective = "results/tiny/fan2015/tables/objective.tsv"
    done = snakemake(tiny_run, objective, "results/tiny/fan2015/tables/comparisons.tsv", configfiles=files, quiet=True)
    assert done.returncode == 0, done.stdout[-3000:]
    new = tables(tiny_run)
    for form in ("tsv", "md", "tex", "html"):
        name = b"mine:jaw" if form == "tsv" else b"Jaw"
        assert name in new[f"fan2015/tables/objective.{form}"] and name in new[f"fan2015/tables/comparisons.{form}"]
    assert "Nothing to be done" in snakemake(tiny_run, objective, configfiles=files, quiet=True).stdout
    (tiny_run / "mine.py").write_text(OWN.format("2.0"))
    assert {"measure_model", "tabulate_results"} == planned_rules(tiny_run, objective, configfiles=files)
    (tiny_run / "mine.py").write_text(OWN.format('float("nan")'))
    failed = snakemake(tiny_run, STATISTICS.format("training_mean"), configfiles=files, quiet=True)
    lines = failed.stdout.splitlines()
    assert failed.returncode != 0 and "Traceback" not in failed.stdout and "localrule" not in failed.stdout
    assert lines[-4] == "The run failed in measure_model (corpus tiny, system fan2015, model training_mean)."
    assert "the measure `mine:jaw` gave nan for the utterance" in lines[-3]
    assert lines[-2] == "  Log: results/tiny/fan2015/logs/measure_model/training_mean.log"
    assert lines[-1].startswith("0 of 1 jobs are done. When this is corrected, run the same command again")
    assert snakemake(tiny_run, "all").returncode == 0
    assert tables(tiny_run) == before


def test_values_inside_sections_of_the_command_line_count(tmp_path):
    given = "override={systems: {fan2015: {rate: 50, models: {hmm_mge: null}}}}"
    done = snakemake(tmp_path, "--dry-run", "all", "--config", given, configfiles=(TINY,))
    assert done.returncode == 0 and "model=hmm_tied" in done.stdout, done.stdout[-3000:]
    assert "model=hmm_mge" not in done.stdout
    refused = snakemake(tmp_path, "--dry-run", "all", "--config", 'features={"rate": 50}')
    assert refused.returncode != 0 and "--config override='{systems: {fan2015: {rate: 50}}}'" in refused.stdout
