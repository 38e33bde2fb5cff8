"""What a whole run costs: cold, with nothing to do, and after a change of a table; stages and memory from the run.

    python -m benchmarks.workflow FOLDER [config/grid.yaml ...]

Runs in FOLDER (made where it is not there; a cold run wants an empty one) with two cores and prints the figures.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from visualspeech.evaluation.timings import read_timings

REPOSITORY = Path(__file__).resolve().parents[1]


def run(folder: Path, overlays: list[str], target: str) -> tuple[float, str]:
    """Seconds of one call of the workflow, and what it printed."""
    configs = ["--configfile", *overlays] if overlays else []
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(REPOSITORY / "Snakefile"), "--cores", "2"]
    start = time.perf_counter()
    done = subprocess.run(
        [*command, "--directory", str(folder), *configs, "--", target], text=True, capture_output=True
    )
    if done.returncode:
        sys.exit(done.stdout[-3000:] + done.stderr[-3000:])
    return time.perf_counter() - start, done.stdout + done.stderr


def main() -> None:
    folder, overlays = Path(sys.argv[1]), [str(Path(path).resolve()) for path in sys.argv[2:]]
    folder.mkdir(parents=True, exist_ok=True)
    seconds, _ = run(folder, overlays, "all")
    print(f"all: {seconds:.0f} s")
    seconds, said = run(folder, overlays, "all")
    print(f"again: {seconds:.1f} s ({'nothing to be done' if 'Nothing to be done' in said else 'something was done'})")
    with tempfile.TemporaryDirectory() as scratch:
        change = Path(scratch, "change.yaml")
        change.write_text("tables: {digits: 5}\n")
        seconds, said = run(folder, [*overlays, str(change)], "tables")
        print(f"tables with other digits: {seconds:.1f} s, {said.count('rule tabulate_results')} job")
    run(folder, overlays, "all")
    files = [*(folder / "results").glob("*/benchmarks/**/*.tsv"), *(folder / "results").glob("*/*/benchmarks/**/*.tsv")]
    for timing in sorted(read_timings(files), key=lambda one: -one.seconds):
        print(f"{timing.stage:24s} {timing.jobs:3d} jobs {timing.seconds:8.1f} s {timing.memory:7.0f} MB at most")


if __name__ == "__main__":
    main()
