"""Another workflow uses this one as a module, with a prefix and settings of its own."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.paths import REPOSITORY
from tests.workflow.running import TINY, files_of, tables

pytestmark = pytest.mark.xdist_group("workflow")

OUTER = """
module visualspeech:
    snakefile:
        {snakefile}
    {placing}
    config:
        {config}


use rule * from visualspeech as speech_*


rule count:
    default_target: True
    input:
        {table},
    output:
        "counted.txt",
    shell:
        "wc -l < {{input}} > {{output}} && echo done"
"""


def workflow(folder, table, config=None, placing='prefix: "speech"'):
    """A workflow of another project that reads a table of this one."""
    config = yaml.safe_load(TINY.read_text()) if config is None else config
    path = Path(folder, "workflow", "Snakefile")
    path.parent.mkdir()
    snakefile = json.dumps(str(REPOSITORY / "Snakefile"))
    path.write_text(OUTER.format(snakefile=snakefile, config=config, table=json.dumps(table), placing=placing))


def run(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "snakemake", "--cores", "1", *arguments],
        cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=600,
    )  # fmt: skip


def paths_shown(output):
    """Paths of inputs, outputs, logs and benchmarks in a dry run."""
    lines = [line.strip() for line in output.splitlines()]
    named = [
        line.split(": ", 1)[1] for line in lines if line.startswith(("input: ", "output: ", "log: ", "benchmark: "))
    ]
    return {path for line in named for path in line.split(", ")}


@pytest.mark.parametrize(
    ("placing", "where"),
    [('prefix: "speech"', "speech/results"), ('replace_prefix: {"results/": "made/"}', "made"), ("", "results")],
)
def test_everything_lies_below_the_prefix(tmp_path, placing, where):
    workflow(tmp_path, f"{where}/tiny/corpus/split.tsv", placing=placing)
    done = run(tmp_path, "--dry-run", "speech_all")
    assert done.returncode == 0, done.stdout
    shown = paths_shown(done.stdout)
    assert f"{where}/tiny/report.html" in shown and f"{where}/tiny/fan2015/videos" in shown
    assert [path for path in shown if not path.startswith(f"{where}/tiny/")] == []
    assert files_of(tmp_path) == {"workflow", "workflow/Snakefile"}


def test_its_own_rule_is_the_default_and_a_small_target_is_made(tmp_path):
    workflow(tmp_path, "speech/results/tiny/check/0.tsv")
    done = run(tmp_path)
    assert done.returncode == 0, done.stdout[-4000:]
    assert (tmp_path / "counted.txt").read_text().strip().isdecimal()
    assert "speech_record_demo" in done.stdout and "speech_align_speech" not in done.stdout
    assert {path.name for path in tmp_path.iterdir()} == {".snakemake", "counted.txt", "speech", "workflow"}
    # Its results are held while it runs, as those of a run by itself.
    assert (tmp_path / "speech" / "results" / "tiny" / ".lock").read_text()
    assert "Nothing to be done" in run(tmp_path).stdout


def test_tables_and_report_are_those_of_a_run_by_itself(tiny_run, tmp_path):
    """Made again by rules whose params name paths."""
    workflow(tmp_path, "speech/results/tiny/corpus/split.tsv")
    shutil.copytree(tiny_run / "results", tmp_path / "speech" / "results", symlinks=True)
    made = tmp_path / "speech" / "results" / "tiny"
    shutil.rmtree(made / "tables")
    (made / "report.html").unlink()
    done = run(tmp_path, "--rerun-triggers", "mtime", "--", "speech_report")
    assert done.returncode == 0, done.stdout[-4000:]
    assert tables(tmp_path / "speech") == tables(tiny_run)
    assert '"fan2015/videos/' in (made / "report.html").read_text()


def test_settings_are_laid_over_the_default_run(tmp_path):
    workflow(
        tmp_path, "speech/results/demo/corpus/split.tsv", config={"corpora": ["demo"], "systems": ["sadoughi2017"]}
    )
    done = run(tmp_path, "--dry-run", "speech_tables")
    assert done.returncode == 0, done.stdout
    assert "speech/results/demo/sadoughi2017/tables/objective.tsv" in done.stdout
    assert "fan2015" not in done.stdout and "demo_pair" not in done.stdout


def test_a_mistake_in_its_settings_is_one_sentence(tmp_path):
    workflow(tmp_path, "x", config={"corpra": ["demo"]})
    done = run(tmp_path, "--dry-run")
    assert done.returncode != 0 and "corpra" in done.stdout and "Traceback" not in done.stdout
