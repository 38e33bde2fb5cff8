"""Costs of stages, read from the tables that jobs leave."""

import math
import os
import re

import pytest

from tests.paths import REPOSITORY
from visualspeech.evaluation.timings import STAGES, StageTiming, by_stage, read_timings, stage_of

HEADER = "s\th:m:s\tmax_rss\tmax_vms\n"


def write(path, text, ended):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    os.utime(path, (ended, ended))


def test_jobs_of_a_stage_are_added_up(tmp_path):
    folder, other = tmp_path / "benchmarks", tmp_path / "fan2015" / "benchmarks"
    paths = [folder / "track" / "0.tsv", folder / "track" / "1.tsv", other / "fit.tsv", other / "missing.tsv"]
    write(paths[0], HEADER + "2.5\t0:00:02\t100.5\t1\n", 10)
    write(paths[1], HEADER + "1.5\t0:00:01\t300\t1\n", 20)
    write(paths[2], HEADER + "7\t0:00:07\t-\t-\n", 5)
    fit, track = read_timings(paths, {"track": 1000})
    assert track == StageTiming("track", 2, 4.0, 2.5, 300.0, 1000)
    assert track.frames_per_second == 250
    assert (fit.stage, fit.seconds) == ("fit", 7.0)  # ended first
    assert math.isnan(fit.memory) and math.isnan(fit.frames_per_second)


def test_only_the_files_given_count(tmp_path):
    paths = [tmp_path / "benchmarks" / "train" / f"{name}.tsv" for name in ("FBB-64", "removed")]
    for path in paths:
        write(path, HEADER + "1\t0:00:01\t10\t1\n", 1)
    (timing,) = read_timings(paths[:1])
    assert timing.jobs == 1


@pytest.mark.parametrize(
    ("path", "stage"),
    [
        ("results/demo/benchmarks/fit_head.tsv", "fit_head"),
        ("results/demo/benchmarks/track_landmarks/3.tsv", "track_landmarks"),
        ("results/demo/fan2015/benchmarks/build_features/tri/0.tsv", "build_features"),
        ("benchmarks/results/demo/benchmarks/fit_head.tsv", "fit_head"),
        ("elsewhere/fit_head.tsv", "fit_head"),
    ],
)
def test_the_stage_is_in_the_path(path, stage):
    assert stage_of(path) == stage


def test_half_written_tables_are_left_out(tmp_path):
    texts = {"a": "", "b": HEADER, "c": HEADER + "1.0\t0:0", "d": "nonsense\n1\n"}
    for name, text in texts.items():
        write(tmp_path / f"{name}.tsv", text, 1)
    assert read_timings(tmp_path / f"{name}.tsv" for name in texts) == ()


def test_rules_are_gathered_into_stages():
    timings = [
        StageTiming("train_model", 20, 300.0, 40.0, 500.0),
        StageTiming("check_recordings", 4, 2.0, 0.6, float("nan"), 1000),
        StageTiming("track_landmarks", 4, 10.0, 3.0, 200.0, 1000),
        StageTiming("normalise_pose", 4, 10.0, 4.0, float("nan"), 1000),
        StageTiming("of_a_plugin", 1, 1.0, 1.0, 10.0),
    ]
    found = by_stage(timings)
    assert [one.stage for one in found] == ["Check of recordings", "Faces", "Training", "of_a_plugin"]
    faces = found[1]
    assert (faces.jobs, faces.seconds, faces.longest, faces.memory) == (8, 20.0, 4.0, 200.0)
    assert faces.frames_per_second == 50 and math.isnan(found[0].memory)
    assert sum(one.seconds for one in found) == sum(one.seconds for one in timings) and by_stage([]) == ()


def test_the_rules_of_the_stages_exist():
    texts = [path.read_text() for path in (REPOSITORY / "workflow" / "rules").glob("*.smk")]
    rules = {name for text in texts for name in re.findall(r"^rule (\w+):", text, re.MULTILINE)}
    assert {rule for group in STAGES.values() for rule in group} <= rules
