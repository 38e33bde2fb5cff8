"""The DAG: what runs, what does not run again, and what a change makes run again."""

import time

import pytest

from tests.paths import REPOSITORY, grid_root
from tests.workflow.running import files_of, of_coding, of_system, overlay, planned_rules, snakemake, tiny_corpus
from visualspeech.speech import egemaps
from visualspeech.speech.forced_alignment import AlignmentSettings

pytestmark = pytest.mark.xdist_group("workflow")

OVERLAYS = sorted(path for path in (REPOSITORY / "config").glob("*.yaml") if path.name != "config.yaml")
RECORDING = {"record_demo", "check_recordings", "align_speech", "track_landmarks", "fit_head", "normalise_pose"}


def test_default_config_plans_every_stage(tmp_path):
    rules = planned_rules(tmp_path, "all", configfiles=())
    assert RECORDING | {"fit_aam", "train_model", "predict_model"} <= rules
    assert {"tabulate_results", "tabulate_systems", "render_videos", "write_report"} <= rules


@pytest.mark.parametrize("path", OVERLAYS, ids=lambda path: path.name)
def test_every_shipped_overlay_plans(path, tmp_path):
    root = grid_root()
    if "grid" in path.name and root is None:
        pytest.skip("no copy of GRID here (set GRID_ROOT)")
    if path.name == "egemaps.yaml" and egemaps.missing():
        pytest.skip(egemaps.missing())
    done = snakemake(tmp_path, "--dry-run", "all", configfiles=(path,), env={"GRID_ROOT": str(root)})
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    "target",
    ["alignment", "landmarks", "pose", "coding", "features", "models", "tables", "videos", "speaker", "report"],
)
def test_named_targets_plan(target, tmp_path):
    assert planned_rules(tmp_path, target)


def test_lint_is_clean():
    """No environments are declared: the workflow runs in the Python that runs Snakemake, and no test runs any other."""
    done = snakemake(REPOSITORY, "--lint", configfiles=())
    lints = [line.strip() for line in done.stdout.splitlines() if line.startswith("    * ")]
    assert lints, done.stdout
    assert [lint for lint in lints if not lint.startswith("* Specify a conda environment")] == []


@pytest.mark.parametrize("arguments", [("--dry-run", "all"), ("--lint",), ("--dry-run", "all", "--config", "seed=8")])
def test_planning_writes_nothing(arguments, tmp_path):
    snakemake(tmp_path, *arguments)
    assert files_of(tmp_path) == set()


def test_planning_beside_a_running_run_changes_nothing(tiny_run):
    before = {path: path.stat().st_mtime_ns for path in (tiny_run / "results").rglob("*")}
    assert "write_split" in planned_rules(tiny_run, "all", "--config", "seed=8")
    assert {path: path.stat().st_mtime_ns for path in (tiny_run / "results").rglob("*")} == before


def test_nothing_to_be_done_after_a_run(tiny_run):
    start = time.monotonic()
    done = snakemake(tiny_run, "all")
    assert done.returncode == 0
    assert "Nothing to be done" in done.stdout
    print(f"reported in {time.monotonic() - start:.1f} s")


def test_results_lie_where_the_settings_say(tmp_path):
    done = snakemake(tmp_path, "--dry-run", "all", "--config", "results=elsewhere/deep")
    assert done.returncode == 0 and "elsewhere/deep/tiny/report.html" in done.stdout
    assert " results/tiny" not in done.stdout


def test_digits_of_a_table_remake_the_tables_alone(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "tables", configfiles=overlay(tmp_path, of_system(tables={"digits": 5})))
    assert {"tabulate_results", "tabulate_systems"} <= rules
    assert all(rule == "tables" or rule.startswith(("tabulate_", "compare_")) for rule in rules)


def test_energy_of_the_aam_remakes_from_the_aam_on(tiny_run, tmp_path):
    rules = planned_rules(tiny_run, "all", configfiles=overlay(tmp_path, of_coding(aam={"shape": {"energy": 0.9}})))
    assert {"fit_aam", "encode_appearance", "train_model", "tabulate_results", "render_videos"} <= rules
    assert not rules & (RECORDING | {"accept_utterances", "fit_reference", "sample_textures"})


def test_alignment_settings_leave_the_face_alone(tiny_run, tmp_path):
    changed = 0.17
    assert changed != AlignmentSettings().padding
    over = overlay(tmp_path, {"alignment": {"padding": changed}})
    assert "align_speech" in planned_rules(tiny_run, "alignment", configfiles=over)
    assert not planned_rules(tiny_run, "landmarks", configfiles=over) & {"track_landmarks", "check_recordings"}


def test_another_seed_leaves_the_recording_stages_alone(tiny_run):
    rules = planned_rules(tiny_run, "all", "--config", "seed=2")
    assert {"write_split", "fit_head", "train_model", "tabulate_results"} <= rules
    assert not rules & {"record_demo", "list_utterances", "check_recordings", "align_speech", "track_landmarks"}


def test_a_new_topology_trains_only_itself(tiny_run, tmp_path):
    over = overlay(tmp_path, of_system(models={"nets": {"letters": ["FB", "F"]}}))
    done = snakemake(tiny_run, "--dry-run", "models", configfiles=over)
    assert done.stdout.count("rule train_model:") == 1
    assert "models/F-16/model.safetensors" in done.stdout


def test_one_more_utterance_reruns_its_shard_only(tiny_run, tmp_path):
    over = overlay(tmp_path, tiny_corpus(utterances=13))
    done = snakemake(tiny_run, "--dry-run", "alignment", configfiles=over)
    assert done.stdout.count("rule align_speech:") == 1 and done.stdout.count("rule list_utterances:") == 1
