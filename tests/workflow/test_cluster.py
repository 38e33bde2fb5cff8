"""What the workflow asks of a cluster, and runs on one: a Slurm of one node is enough."""

import csv
import os
import re
import shutil
import signal
import subprocess
import time
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

from tests.paths import REPOSITORY
from tests.workflow.running import TINY, command, snakemake, tables
from visualspeech.cluster import PLUGIN

pytestmark = pytest.mark.xdist_group("workflow")

PROFILE = REPOSITORY / "profiles" / "slurm"
RULES = "".join(path.read_text() for path in sorted((REPOSITORY / "workflow" / "rules").glob("*.smk")))
#: Rules whose jobs are worth a job of Slurm each, and those that run beside Snakemake.
ALONE = {
    "accept_utterances", "align_speech", "evaluate_study", "export_alignment", "fit_aam", "fit_faces", "fit_head",
    "fit_markers", "fit_reference", "make_study", "measure_lips", "read_motion", "render_markers", "render_videos",
    "sample_textures", "track_landmarks", "train_model", "try_viseme_number", "write_report",
}  # fmt: skip
LOCAL = {"accept_faces", "gather_findings", "list_phones", "write_split"}


def bodies():
    """Rule -> its text."""
    return dict(re.findall(r"^rule (\w+):\n(.*?)(?=^rule |\Z)", RULES, re.MULTILINE | re.DOTALL))


def profile():
    return yaml.safe_load((PROFILE / "config.yaml").read_text())


def asked(folder, *arguments):
    """Rule -> the least resources that a dry run of everything shows, by name."""
    done = snakemake(folder, "--dry-run", "--forceall", "all", *arguments)
    assert done.returncode == 0, done.stdout[-4000:]
    found = {}
    for rule, line in re.findall(
        r"^(?:local)?rule (\w+):\n(?:    .*\n)*?    resources: (.*)$", done.stdout, re.MULTILINE
    ):
        numbers = {name: int(value) for name, value in re.findall(r"(\w+)=(\d+)(?:,|$)", line)}
        kept = found.setdefault(rule, numbers)
        found[rule] = {name: min(value, kept.get(name, value)) for name, value in numbers.items()}
    return found


def test_every_rule_says_what_it_needs():
    for rule, text in bodies().items():
        for resource in ("mem_mb", "runtime", "disk_mb"):
            assert f"        {resource}=" in text, f"{rule} does not say its {resource}"


def test_every_rule_has_its_place_on_a_cluster():
    groups = profile()["groups"]
    assert set(bodies()) - set(groups) == ALONE | LOCAL
    assert set(groups) <= set(bodies())
    assert set(groups.values()) == set(profile()["group-components"])
    assert {rule for rule, text in bodies().items() if "    localrule: True" in text} == LOCAL


def test_jobs_ask_for_more_than_was_measured(tiny_run):
    """Memory of the script, with the two processes of Snakemake around it, is below what a first attempt asks for."""
    found = asked(tiny_run)
    measured = 0
    for path in (tiny_run / "results").rglob("benchmarks/**/*.tsv"):
        rule = path.relative_to(next(one for one in path.parents if one.name == "benchmarks")).parts[0]
        with open(path) as file:
            peak, seconds = ((row["max_rss"], row["s"]) for row in csv.DictReader(file, delimiter="\t")).__next__()
        if peak.replace(".", "").isdigit():
            measured += 1
            assert float(peak) + 320 < found[rule.removesuffix(".tsv")]["mem_mb"], path
        assert float(seconds) < 60 * found[rule.removesuffix(".tsv")]["runtime"], path
    assert measured > 20
    again = asked(tiny_run, "--attempt", "2")
    for rule, first in found.items():
        if rule != "all":
            for name in ("mem_mb", "runtime", "disk_mb"):
                assert again[rule][name] == 2 * first[name], (rule, name)


def test_a_profile_without_its_plugin_says_what_to_install(tmp_path):
    """The finder of the plugin is hidden, as where it was never installed."""
    (tmp_path / "sitecustomize.py").write_text(
        f"import importlib.util as util\nfind = util.find_spec\n"
        f"util.find_spec = lambda name, *more: None if name == {PLUGIN!r} else find(name, *more)\n"
    )
    environment = {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(REPOSITORY)])}
    done = snakemake(tmp_path, "--profile", str(PROFILE), "--dry-run", "all", env=environment)
    assert done.returncode != 0 and "pip install -c constraints.txt -e '.[cluster]'" in done.stdout
    assert "Traceback" not in done.stdout and "usage:" not in done.stdout


def has_slurm():
    """Whether a Slurm with a free node answers here."""
    if not shutil.which("sinfo") or find_spec(PLUGIN) is None:
        return False
    nodes = subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True)
    return nodes.returncode == 0 and bool({"idle", "mixed", "allocated"} & set(nodes.stdout.split()))


slurm = pytest.mark.skipif(
    not has_slurm(), reason="no Slurm answers here, or its executor is not installed (docs/cluster.md)"
)
#: A quick look at the states of jobs, for a toy.
QUICK = ("--jobs", "4", "--latency-wait", "10", "--slurm-init-seconds-before-status-checks", "2")


def on_slurm(folder, *arguments):
    """Start a run on Slurm; it answers signals also where the shell of the tests has hidden some from them."""
    words = command(folder, *arguments, "--profile", str(PROFILE), *QUICK, configfiles=(TINY,))
    at = words.index("--cores")
    del words[at : at + 2]
    with open(folder / "output.txt", "w") as output:
        return subprocess.Popen(
            words, stdout=output, stderr=subprocess.STDOUT, start_new_session=True,
            preexec_fn=lambda: [signal.signal(one, signal.SIG_DFL) for one in (signal.SIGINT, signal.SIGHUP)],
        )  # fmt: skip


def queued(folder):
    """Slurm's jobs whose working folder is the run's."""
    shown = subprocess.run(["squeue", "-h", "-o", "%i %T %Z"], capture_output=True, text=True, check=True).stdout
    return [line for line in shown.splitlines() if line.split()[2] == str(Path(folder).resolve())]


def wait_until(condition, seconds):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.5)


@slurm
def test_a_run_on_slurm_has_the_tables_of_a_local_one(tiny_run, tmp_path):
    run = on_slurm(tmp_path, "all")
    assert run.wait(3000) == 0, (tmp_path / "output.txt").read_text()[-4000:]
    assert tables(tmp_path) == tables(tiny_run)
    assert queued(tmp_path) == []


@slurm
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_cancelled_run_leaves_no_jobs(tmp_path, number):
    run = on_slurm(tmp_path, "alignment")
    wait_until(lambda: any("RUNNING" in line for line in queued(tmp_path)), 120)
    time.sleep(5)
    assert run.poll() is None
    os.kill(run.pid, number)
    run.wait(60)
    wait_until(lambda: not queued(tmp_path), 60)
    shown = (tmp_path / "output.txt").read_text()
    assert "Traceback" not in shown
    assert list((tmp_path / "results").rglob("*.h5")) == []
    held = snakemake(tmp_path, "--cores", "1", "results/tiny/corpus/split.tsv")
    assert held.returncode == 0, held.stdout[-2000:]
