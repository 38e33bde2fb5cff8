"""What a whole run costs: from nothing, with nothing to do, and after a change of the tables; stages and their memory.

Run: python -m benchmarks.workflow FOLDER [OVERLAY ...]

Runs the workflow on two cores with FOLDER as its working folder, which is created where it does not exist and must be
empty for a run from nothing; OVERLAYs are configuration files (config/grid.yaml). Prints the seconds of each run, and
for each stage the number of jobs, their seconds and their largest memory.
"""

import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml

from benchmarks.command import run_main
from visualspeech.evaluation.timings import read_timings

REPOSITORY = Path(__file__).resolve().parents[1]


def run(folder: Path, overlays: list[str], target: str) -> tuple[float, str]:
    """Seconds of one call of the workflow, and what it printed."""
    configs = ["--configfile", *overlays] if overlays else []
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(REPOSITORY / "Snakefile"), "--cores", "2"]
    begin = time.perf_counter()
    done = subprocess.run(
        [*command, "--directory", str(folder), *configs, "--", target], text=True, capture_output=True
    )
    if done.returncode:
        sys.exit(done.stdout[-3000:] + done.stderr[-3000:])
    return time.perf_counter() - begin, done.stdout + done.stderr


def main(folder: Path, *overlays: Path) -> None:
    overlays = [str(path.resolve()) for path in overlays]
    folder.mkdir(parents=True, exist_ok=True)
    results = folder / "results"
    seconds, _ = run(folder, overlays, "all")
    print(f"all: {seconds:.0f} s")
    seconds, said = run(folder, overlays, "all")
    print(f"again: {seconds:.1f} s ({'nothing to be done' if 'Nothing to be done' in said else 'something was done'})")
    with tempfile.TemporaryDirectory() as scratch:
        change = Path(scratch, "change.yaml")
        systems = {path.parents[1].name for path in results.glob("*/*/tables/objective.tsv")}
        digits = {"override": {"systems": {system: {"tables": {"digits": 5}} for system in sorted(systems)}}}
        change.write_text(yaml.safe_dump(digits))
        seconds, said = run(folder, [*overlays, str(change)], "tables")
        print(f"tables with other digits: {seconds:.1f} s, {len(re.findall('rule tabulate_', said))} jobs")
    run(folder, overlays, "all")
    # Of the corpora, their codings and their systems.
    timings = read_timings(results.glob("**/benchmarks/**/*.tsv"))
    for timing in sorted(timings, key=lambda stage: -stage.seconds):
        print(f"{timing.stage:24s} {timing.jobs:3d} jobs {timing.seconds:8.1f} s {timing.memory:7.0f} MB at most")


if __name__ == "__main__":
    run_main(main, __doc__)
