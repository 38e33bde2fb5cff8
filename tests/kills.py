"""Kills runs at random moments and checks that the same command always ends in the same files.

    python -m tests.kills --kills 200 --seed 1

A finished run of the smallest corpus is the reference. Then, again and again, a run is started, and at a random moment
a signal is sent to the whole process group, to Snakemake alone or to one job alone. When nothing is left to do, the
results from a random stage on are deleted. At the end the run is completed and compared with the reference, byte for
byte. The exit status is 1 if any restart needed help, any file differs, or anything is left behind.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from tests.workflow.running import command, same_in_every_run, snakemake

CORPUS = Path("results", "tiny")

#: Results in the order in which they are made, below the corpus; from one of them on they are deleted.
STAGES = (
    ("recordings", "truth", "corpus"),
    ("check", "audio", "findings.tsv", "phones.tsv"),
    ("alignment",),
    ("landmarks",),
    ("heads", "pose", "utterances.tsv"),
    ("codings",),
    ("fan2015/features", "fan2015/targets"),
    ("fan2015/models",),
    ("fan2015/tables", "fan2015/videos", "tables", "report.html"),
)
#: Files of one run only: they hold times of day and durations.
OF_ONE_RUN = (
    "logs", "benchmarks", "learning_curve.tsv", "speed.tsv", "costs.tsv", "report.html", ".snakemake_timestamp",
    ".lock", ".jobs.lock",
)  # fmt: skip

TARGETS = {"group": 4, "main process": 3, "job": 3}
SIGNALS = {signal.SIGKILL: 6, signal.SIGTERM: 2, signal.SIGINT: 2}
#: Seconds in which every job has to end after its run.
GRACE = 10.0
#: Seconds in which a run has to end whose jobs have all been stopped; on a busy machine an import takes some of them.
PATIENCE = 30.0


@dataclass
class Figures:
    """What a campaign has found."""

    kills: Counter = field(default_factory=Counter)
    stages: Counter = field(default_factory=Counter)
    restarts: int = 0
    finished: int = 0
    slowest_end: float = 0.0
    faults: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        lines = [
            f"{sum(self.kills.values())} kills, {self.restarts} starts, {self.finished} of them ended before a kill"
        ]
        lines += [f"  {count:4d}  {name}" for name, count in sorted(self.kills.items())]
        lines += ["jobs that were running at the kill:"]
        lines += [f"  {count:4d}  {name}" for name, count in self.stages.most_common()]
        lines += [f"longest time from the death of a run to that of its last job: {self.slowest_end:.1f} s"]
        lines += [f"faults: {len(self.faults)}", *self.faults]
        return "\n".join(lines)


def start(folder: Path) -> subprocess.Popen:
    """A run of everything in a session of its own, whose output is in ``output.txt``.

    It answers SIGINT also where a shell has started the tests in the background, which ignores that signal for them.
    """
    with open(folder / "output.txt", "w") as output:
        return subprocess.Popen(
            command(folder, "all", cores=2),
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )


def processes(session: int) -> dict[int, str]:
    """Processes of a session that have not ended, with the rules of those that are jobs (otherwise empty)."""
    found = {}
    for process in filter(str.isdecimal, os.listdir("/proc")):
        try:
            status = Path("/proc", process, "stat").read_text(errors="replace").rpartition(")")[2].split()
            arguments = Path("/proc", process, "cmdline").read_bytes().decode(errors="replace").split("\0")
        except OSError:
            continue
        if int(status[3]) == session and status[0] not in "ZX":
            scripts = [Path(one) for one in arguments if "/.snakemake/scripts/" in one]
            found[int(process)] = scripts[0].name.split(".")[1] if scripts else ""
    return found


def jobs(run: subprocess.Popen) -> dict[int, str]:
    """Jobs of a run: process id -> rule."""
    return {process: rule for process, rule in processes(run.pid).items() if rule}


def wait_for_moment(run: subprocess.Popen, chance: random.Random) -> None:
    """Wait for a random moment: of planning, or after the first job has started, sooner rather than later."""
    if chance.random() < 0.2:
        wait(run, chance.uniform(0, 4))
        return
    while run.poll() is None and not jobs(run):
        time.sleep(0.02)
    wait(run, 0.05 * 400 ** chance.random())


def wait(run: subprocess.Popen, seconds: float) -> None:
    try:
        run.wait(seconds)
    except subprocess.TimeoutExpired:
        pass


def kill(run: subprocess.Popen, chance: random.Random, figures: Figures) -> bool:
    """Send a random signal to a random target and wait until the run has ended; returns whether jobs were running."""
    running = jobs(run)
    target = chance.choices(list(TARGETS), list(TARGETS.values()))[0]
    number = chance.choices(list(SIGNALS), list(SIGNALS.values()))[0]
    target = target if running or target != "job" else "main process"
    struck = {"group": sorted(running), "main process": [], "job": [chance.choice(sorted(running) or [0])]}[target]
    with suppress(ProcessLookupError):  # it ends in this moment
        if target == "group":
            os.killpg(run.pid, number)
        else:
            os.kill(struck[0] if struck else run.pid, number)
    figures.kills[f"{number.name} to the {target}"] += 1
    figures.stages.update(set(running.values()) or {"none (planning, or between jobs)"})
    wait(run, PATIENCE)
    if run.poll() is None:  # Snakemake lets jobs finish that got no signal
        left = jobs(run)
        if not left or set(struck) & set(left):
            figures.faults.append(f"alive {PATIENCE:.0f} s after {number.name} to the {target}: {processes(run.pid)}")
        os.killpg(run.pid, signal.SIGKILL)
        run.wait()
        figures.kills["SIGKILL to the group that was waiting for jobs"] += 1
    return bool(running)


def wait_for_jobs(run: subprocess.Popen, figures: Figures) -> None:
    """Wait until no process of a run that has ended is alive; a fault if that takes too long."""
    began = time.monotonic()
    while left := processes(run.pid):
        if time.monotonic() > began + GRACE:
            figures.faults.append(f"alive {GRACE:.0f} s after their run: {left}")
            os.killpg(run.pid, signal.SIGKILL)
            return
        time.sleep(0.02)
    figures.slowest_end = max(figures.slowest_end, time.monotonic() - began)


def check_output(folder: Path, figures: Figures, killed: bool, jobs_ran: bool) -> None:
    """Faults that the output of a run shows.

    A traceback counts once jobs have run: before the Snakefile is read, Ctrl-C meets Snakemake's own imports.
    """
    output = (folder / "output.txt").read_text(errors="replace")
    if not killed:
        figures.faults.append(f"a restart failed:\n{output[-3000:]}")
    elif "unexpected error" in output or (jobs_ran and "Traceback" in output):
        figures.faults.append(f"not one line:\n{output[-3000:]}")


def forget(folder: Path, chance: random.Random) -> None:
    """Delete the results from a random stage on."""
    for names in STAGES[chance.randrange(len(STAGES)) :]:
        for name in names:
            path = folder / CORPUS / name
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def compared(folder: Path) -> dict[str, bytes]:
    """The files of a run that must be the same in every run, by path."""
    results = folder / CORPUS
    paths = (path for path in sorted(results.rglob("*")) if path.is_file())
    return same_in_every_run(
        results, [path for path in paths if not set(path.relative_to(results).parts) & set(OF_ONE_RUN)]
    )


def differences(folder: Path, reference: Path) -> Iterator[str]:
    """What differs between a finished run and the reference, and what is left of unfinished work."""
    ours, theirs = compared(folder), compared(reference)
    yield from (
        f"differs: {path}" for path in sorted(ours.keys() | theirs.keys()) if ours.get(path) != theirs.get(path)
    )
    yield from (f"left behind: {path}" for path in sorted((folder / "results").rglob(".partial.*")))


def campaign(folder: Path, reference: Path, kills: int, seed: int, minutes: float) -> Figures:
    """Kill runs in ``folder``, which begins as a copy of the finished run in ``reference``, and finish them."""
    chance, figures = random.Random(seed), Figures()
    runs, end = [], time.monotonic() + 60 * minutes
    shutil.copytree(reference, folder, symlinks=True)
    forget(folder, chance)
    while sum(figures.kills.values()) < kills and time.monotonic() < end:
        run = start(folder)
        runs.append(run)
        wait_for_moment(run, chance)
        finished = run.poll() is not None
        if finished and run.returncode == 0:
            figures.finished += 1
            figures.faults.extend(differences(folder, reference))
            forget(folder, chance)
            continue
        figures.finished += finished
        jobs_ran = not finished and kill(run, chance, figures)
        check_output(folder, figures, not finished, jobs_ran)
        if chance.random() < 0.5:  # otherwise the next run starts while jobs of this one may still be ending
            wait_for_jobs(run, figures)
        if len(figures.faults) > 20:
            break
    figures.restarts = len(runs)
    done = snakemake(folder, "all")
    if done.returncode:
        figures.faults.append(f"the last run failed:\n{done.stdout[-3000:]}")
    figures.faults.extend(differences(folder, reference))
    figures.faults.extend(f"alive at the end: {left}" for run in runs if (left := processes(run.pid)))
    return figures


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--minutes", type=float, default=60, help="send no signal after this time (default: %(default)s)"
    )
    given = parser.parse_args()
    began = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="visualspeech-kills-") as folder:
        reference = Path(folder, "reference")
        reference.mkdir()
        done = snakemake(reference, "all")
        if done.returncode:
            print(done.stdout[-6000:], file=sys.stderr)
            return 1
        print(f"reference run: {(time.monotonic() - began) / 60:.1f} min", flush=True)
        figures = campaign(Path(folder, "work"), reference, given.kills, given.seed, given.minutes)
    print(figures)
    print(f"{(time.monotonic() - began) / 60:.1f} min")
    return 1 if figures.faults or sum(figures.kills.values()) < given.kills else 0


if __name__ == "__main__":
    sys.exit(main())
