"""What a run shows on the terminal, given Snakemake's log records."""

import logging

import pytest

from visualspeech.progress import AGAIN, SHOWN, Failed, Quiet, last_message


class Shown(logging.Handler):
    def __init__(self):
        super().__init__()
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


def record(text=None, level=logging.INFO, **more):
    made = logging.LogRecord("snakemake", level, "", 0, text, None, None)
    made.__dict__.update(more)
    return made


def job(number, rule, **wildcards):
    return record(event="job_info", jobid=number, rule_name=rule, wildcards=wildcards)


@pytest.fixture
def run():
    """A handler with its output and a clock that can be set."""
    shown, time = Shown(), [0.0]
    stages = {"train_model": "models", "predict_model": "models", "write_report": "report"}
    quiet = Quiet(shown, lambda rule: stages.get(rule, ""), lambda: shown.lines.append("up to date"),
                  clock=lambda: time[0])  # fmt: skip
    return quiet, shown.lines, time


def test_a_line_per_stage_and_per_minute(run):
    quiet, lines, time = run
    quiet.handle(record("Job stats", event="run_info", stats={"total": 5}))
    quiet.handle(record("SNAKEMAKE", event="workflow_started"))
    quiet.starts(["run.log"])
    assert lines == ["5 jobs. All messages: run.log"]
    for number in range(3):
        quiet.handle(record("Select jobs to execute..."))
        quiet.handle(job(number, "train_model", model="a"))
        quiet.handle(record("Finished jobid", event="job_finished"))
        quiet.handle(record(event="progress", done=number + 1, total=5))
    quiet.handle(job(4, "predict_model"))
    assert len(lines) == 2 and lines[1].endswith("models           0 of 5 jobs done")
    time[0] = AGAIN + 1
    quiet.handle(record(event="progress", done=4, total=5))
    assert lines[2].endswith("models           4 of 5 jobs done")
    quiet.handle(job(5, "write_report"))
    quiet.handle(job(6, "all"))
    assert len(lines) == 4 and "report" in lines[3]


def test_remarks_stay_until_jobs_start_and_warnings_always(run):
    quiet, lines, _ = run
    quiet.handle(record("Building DAG of jobs..."))
    quiet.starts()
    quiet.handle(record("Execute 2 jobs..."))
    quiet.handle(record("a system is skipped", logging.WARNING))
    quiet.handle(record("MissingOutputException: ...", logging.ERROR, event="error"))
    quiet.handle(record("Report: x", **{SHOWN: True}))
    assert lines == ["Building DAG of jobs...", "0 jobs.", "a system is skipped", "MissingOutputException: ...",
                     "Report: x"]  # fmt: skip


def test_a_failed_job_is_kept_and_said_once(run, tmp_path):
    quiet, lines, _ = run
    log = tmp_path / "a.log"
    log.write_text("12:00:00 train_model a: starts\n12:00:01 train_model a: no memory. Use less.\n  file: x\n")
    quiet.starts()
    quiet.handle(job(7, "train_model", corpus="demo", model="a"))
    lines.clear()
    for _ in range(2):
        quiet.handle(record("Error in rule", logging.ERROR, event="job_error", jobid=7, rule_name="train_model",
                            log=[str(log)]))  # fmt: skip
    quiet.handle(record("RuleException:\nCalledProcessError in file ...", logging.ERROR, event="error"))
    quiet.handle(record("Exiting because a job execution failed. Look above", logging.ERROR))
    quiet.handle(record("At least one job did not complete successfully.", logging.ERROR, event="error"))
    assert lines == [] and list(quiet.failed) == [7]
    failed = quiet.failed[7]
    assert str(failed) == "train_model (corpus demo, model a)" and failed.message() == "no memory. Use less.\n  file: x"


def test_a_failed_group_names_its_jobs(run):
    quiet, _, _ = run
    jobs = [{"jobid": 1, "rule_name": "a", "log": []}, {"jobid": 2, "rule_name": "b", "log": ["x"]}]
    quiet.handle(record("Error in group", logging.ERROR, event="group_error", job_error_info=jobs))
    assert quiet.failed == {1: Failed("a", {}), 2: Failed("b", {}, ("x",))}


def test_nothing_to_do_is_said_with_the_summary(run):
    quiet, lines, _ = run
    quiet.handle(record("Nothing to be done (all requested files are present and up to date)."))
    assert lines[-1] == "up to date" and len(lines) == 2


def test_a_full_output_hands_on_everything_and_counts():
    shown = Shown()
    quiet = Quiet(shown, lambda rule: "models", quiet=False)
    quiet.starts(["x"])
    quiet.handle(job(1, "train_model"))
    quiet.handle(record("progress", event="progress", done=1, total=2))
    quiet.handle(record("Error", logging.ERROR, event="job_error", jobid=1, rule_name="train_model", log=[]))
    assert len(shown.lines) == 3 and quiet.done == 1 and list(quiet.failed) == [1]


def test_the_last_message_of_a_log():
    traceback = "12:00:00 a b: starts\nTraceback (most recent call last):\n  File x\nValueError: wrong: 3\n"
    assert last_message(traceback) == "ValueError: wrong: 3"
    assert last_message("") == "" and last_message("no time") == "no time"
    assert last_message("12:00:00 align_speech 0: a: b\n") == "a: b"
    assert len(last_message("12:00:00 a: " + "x" * 5000)) < 700
