"""Tables of a finished run, and what seeds, widths and richer labels make the workflow do."""

import re

import pytest

from tests.workflow.running import of_system, overlay, snakemake

pytestmark = pytest.mark.xdist_group("workflow")


def planned(folder, target, configfiles):
    done = snakemake(folder, "--dry-run", target, configfiles=configfiles)
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_every_table_is_there_in_four_forms(tiny_run):
    folder = tiny_run / "results" / "tiny" / "fan2015" / "tables"
    for name in ("objective", "topologies", "comparisons", "articulation", "resting", "gains", "ablation"):
        for suffix in ("tsv", "md", "tex", "html"):
            assert (folder / f"{name}.{suffix}").stat().st_size > 100
    assert "156.502" in (folder / "topologies.md").read_text()
    report = (tiny_run / "results" / "tiny" / "report.html").read_text()
    assert "156.502" in report and "Systems on one corpus" in report


def test_a_second_seed_trains_only_itself(tiny_run, tmp_path):
    out = planned(tiny_run, "tables", overlay(tmp_path, of_system(seeds=[1, 7])))
    trained = set(re.findall(r"output: results/tiny/fan2015/models/([^/]+)/model.safetensors", out))
    assert trained == {f"FB-16{suffix}-s7" for suffix in ("", "-thirds", "-lips", "-mel", "-tri-mel")}


def test_richer_labels_train_only_networks_of_them(tiny_run, tmp_path):
    rich = {"like": "nets", "letters": ["FB"], "suffix": "rich", "reads": ["tri", "parts"]}
    out = planned(tiny_run, "tables", overlay(tmp_path, of_system(models={"rich": rich})))
    assert out.count("rule train_model:") == 1 and "models/FB-16-rich/model.safetensors" in out
    assert out.count("rule encode_block:") == 2 and "features/parts/0.h5" in out and "rule build_targets:" not in out


def test_the_other_reading_of_widths_trains_anew(tiny_run, tmp_path):
    out = planned(tiny_run, "models", overlay(tmp_path, of_system(models={"nets": {"b_nodes": "layer"}})))
    assert out.count("rule train_model:") == 1 and "models/FB-16/model.safetensors" in out
