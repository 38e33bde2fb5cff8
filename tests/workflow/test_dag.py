"""The DAG: what runs, what does not run again, and what a change makes run again."""

import time

import pytest
import yaml

from tests.paths import REPOSITORY, grid_root
from tests.workflow.running import TINY, planned_rules, snakemake

OVERLAYS = sorted(path for path in (REPOSITORY / "config").glob("*.yaml") if path.name != "config.yaml")


def overlay(tmp_path, settings):
    path = tmp_path / "over.yaml"
    path.write_text(yaml.safe_dump(settings))
    return (TINY, path)


def test_default_config_plans_every_stage(tmp_path):
    rules = planned_rules(tmp_path, "all", configfiles=())
    assert {"record_demo", "check_recordings", "align_speech", "track_landmarks", "fit_aam", "train_network"} <= rules
    assert {"tabulate_results", "render_videos", "write_report"} <= rules


@pytest.mark.parametrize("path", OVERLAYS, ids=lambda path: path.name)
def test_every_shipped_overlay_plans(path, tmp_path):
    root = grid_root()
    if "corpus: grid" in path.read_text() and root is None:
        pytest.skip("no copy of GRID here (set GRID_ROOT)")
    done = snakemake(tmp_path, "--dry-run", "all", configfiles=(path,), env={"GRID_ROOT": str(root)})
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    "target", ["alignment", "landmarks", "pose", "aam", "features", "models", "tables", "videos", "report"]
)
def test_named_targets_plan(target, tmp_path):
    assert planned_rules(tmp_path, target)


def test_lint_is_clean():
    done = snakemake(REPOSITORY, "--lint", configfiles=())
    assert done.returncode == 0, done.stdout


def test_nothing_to_be_done_after_a_run(tiny_run):
    start = time.monotonic()
    done = snakemake(tiny_run, "all")
    assert done.returncode == 0
    assert "Nothing to be done" in done.stdout
    print(f"said so in {time.monotonic() - start:.1f} s")


def test_digits_of_a_table_remake_the_tables_alone(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "tables", configfiles=overlay(tmp_path, {"tables": {"digits": 5}}))
    assert "tabulate_results" in rules
    assert all(rule == "tables" or rule.startswith("tabulate_") for rule in rules)


def test_energy_of_the_aam_remakes_from_the_aam_on(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "all", configfiles=overlay(tmp_path, {"aam": {"shape": {"energy": 0.9}}}))
    assert {"fit_aam", "encode_appearance", "train_network", "tabulate_results", "render_videos"} <= rules
    untouched = {"record_demo", "check_recordings", "align_speech", "track_landmarks", "normalise_pose"}
    assert not rules & (untouched | {"fit_reference", "sample_textures", "measure_drift"})


def test_alignment_settings_leave_the_face_alone(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "landmarks", configfiles=overlay(tmp_path, {"seed": 1}))
    assert rules <= {"landmarks"}


def test_a_new_topology_trains_only_itself(tiny_run, tmp_path):
    over = overlay(tmp_path, {"networks": {"stacks": ["FB", "F"]}})
    done = snakemake(tiny_run, "--dry-run", "models", configfiles=over)
    assert done.stdout.count("rule train_network:") == 1
    assert "models/F-16/network.safetensors" in done.stdout


def test_one_more_utterance_reruns_its_shard_only(tiny_run, tmp_path):
    over = overlay(tmp_path, {"corpus": {"utterances": 13}})
    done = snakemake(tiny_run, "--dry-run", "alignment", configfiles=over)
    assert done.stdout.count("rule align_speech:") == 1
