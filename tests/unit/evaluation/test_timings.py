"""Costs of stages, read from the tables that jobs leave."""

import math
import os

from visualspeech.evaluation.timings import StageTiming, read_timings

HEADER = "s\th:m:s\tmax_rss\tmax_vms\n"


def write(path, text, ended):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    os.utime(path, (ended, ended))


def test_jobs_of_a_stage_are_added_up(tmp_path):
    write(tmp_path / "one" / "track" / "0.tsv", HEADER + "2.5\t0:00:02\t100.5\t1\n", 10)
    write(tmp_path / "one" / "track" / "1.tsv", HEADER + "1.5\t0:00:01\t300\t1\n", 20)
    write(tmp_path / "two" / "fit.tsv", HEADER + "7\t0:00:07\t-\t-\n", 5)
    fit, track = read_timings([tmp_path / "one", tmp_path / "two", tmp_path / "missing"], {"track": 1000})
    assert track == StageTiming("track", 2, 4.0, 2.5, 300.0, 1000)
    assert track.frames_per_second == 250
    assert (fit.stage, fit.seconds) == ("fit", 7.0)  # ended first
    assert math.isnan(fit.memory) and math.isnan(fit.frames_per_second)


def test_half_written_tables_are_left_out(tmp_path):
    for name, text in {"a": "", "b": HEADER, "c": HEADER + "1.0\t0:0", "d": "nonsense\n1\n"}.items():
        write(tmp_path / f"{name}.tsv", text, 1)
    assert read_timings([tmp_path]) == ()
